// envsh_cast - a caster's vertices and fragments in the tile of a light; gl_InstanceID says of which.
// uses: table envsh_bindings
// The vertex shader has "out float envsh_depth;" and ENVSH_CAST(world); the fragment shader "in float envsh_depth;"
// and, behind what it discards, ENVSH_STORE(envsh_depth). With ENVSH_RGBA it has "layout(location = 0) out uvec4
// envsh_bits;".
#ifndef ENVSH_RGBA
#error "ENVSH_RGBA: 1 where four maps share a texel (glbk_envsh_maps_desc.rgba), else 0"
#endif

struct envsh_vertex { vec4 position, inside; float depth; };

// Triangles end at the tile's guard. OpenGL clips them by distances and clamps their depth. ES has neither: there the
// viewport is a column of tiles and clips along x, the near and far planes stand in along y, and the depth is written.
envsh_vertex envsh_cast(int instance, vec3 world)
{
    uint at = 8u * (glbk_envsh_object.lights.x + glbk_envsh_object.lights.y * uint(instance));
    vec4 p = vec4(world, 1.0);
    uvec4 tiles = glbk_envsh_scene.tiles;
    vec2 texel = vec2(dot(uintBitsToFloat(texelFetch(glbk_envsh_views, glbk_table_at(at), 0)), p),
                      dot(uintBitsToFloat(texelFetch(glbk_envsh_views, glbk_table_at(at + 1u), 0)), p));
    uint place = texelFetch(glbk_envsh_views, glbk_table_at(at + 6u), 0).w;
    vec2 corner = vec2(uvec2(place & 2047u, (place >> 11) & 2047u) * tiles.x);
    envsh_vertex v;
    v.depth = dot(uintBitsToFloat(texelFetch(glbk_envsh_views, glbk_table_at(at + 2u), 0)), p);
    v.inside = vec4(texel - float(tiles.y), float(tiles.x - tiles.y) - texel);
#ifdef GL_ES
    vec2 inner = v.inside.xy * glbk_envsh_scene.page.z - 1.0;
    v.position = vec4(inner.x, (corner.y + texel.y) * glbk_envsh_scene.page.y - 1.0, inner.y, 1.0);
#else
    v.position = vec4((corner + texel) * glbk_envsh_scene.page.xy - 1.0, 2.0 * v.depth - 1.0, 1.0);
#endif
    return v;
}

#ifdef GL_ES
#define ENVSH_CLIP(d)
#define ENVSH_WRITE_DEPTH(depth) gl_FragDepth = clamp(depth, 0.0, 1.0);
#else
#define ENVSH_CLIP_PART(i, d) gl_ClipDistance[i] = d;
#define ENVSH_CLIP(d) ENVSH_CLIP_PART(0, d.x) ENVSH_CLIP_PART(1, d.y) ENVSH_CLIP_PART(2, d.z) ENVSH_CLIP_PART(3, d.w)
#define ENVSH_WRITE_DEPTH(depth)
#endif
#define ENVSH_SET(v) gl_Position = v.position; envsh_depth = v.depth; ENVSH_CLIP(v.inside)
#define ENVSH_CAST(world) { envsh_vertex envsh_v = envsh_cast(gl_InstanceID, world); ENVSH_SET(envsh_v) }

#if ENVSH_RGBA
#define ENVSH_STORE(depth) { envsh_bits = uvec4(floatBitsToUint(clamp(depth, 0.0, 1.0))); ENVSH_WRITE_DEPTH(depth) }
#else
#define ENVSH_STORE(depth) { ENVSH_WRITE_DEPTH(depth) }
#endif
