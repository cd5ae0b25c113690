// envsh_cast - puts a caster's vertices and fragments into the tile of a light, which gl_InstanceID tells.
// uses: table envsh_bindings
// The vertex shader declares "out float envsh_depth;" and ends with ENVSH_CAST(world), world being the
// position. The fragment shader declares "in float envsh_depth;" and, with ENVSH_RGBA, "layout(location = 0)
// out uvec4 envsh_bits;". After what it discards it ends with ENVSH_STORE(envsh_depth).
#ifndef ENVSH_RGBA
#error "ENVSH_RGBA: 1 where four maps share a texel (glbk_envsh_maps_desc.rgba), else 0"
#endif

struct envsh_vertex {
    vec4 position;          // in clip space
    vec4 inside;            // texels from the four edges of the tile without its guard; below 0 outside
    float depth;            // 0..1 between the planes of the light
};

// Projects a point of the world into the tile of an instance's light. Triangles end at the tile's guard.
// OpenGL clips them by distances and clamps their depth. ES has neither: there the viewport is a column of
// tiles and clips along x, the near and far planes of clip space clip along y, and the fragment shader writes
// the depth.
envsh_vertex envsh_cast(int instance, vec3 world)
{
    uint at = 8u * (glbk_envsh_object.first_light + glbk_envsh_object.light_step * uint(instance));
    vec4 p = vec4(world, 1.0);
    uint side = glbk_envsh_scene.map_side, guard = glbk_envsh_scene.guard;
    vec2 texel = vec2(dot(uintBitsToFloat(texelFetch(glbk_envsh_views, glbk_table_at(at), 0)), p),
                      dot(uintBitsToFloat(texelFetch(glbk_envsh_views, glbk_table_at(at + 1u), 0)), p));
    uint place = texelFetch(glbk_envsh_views, glbk_table_at(at + 6u), 0).w;
    vec2 corner = vec2(uvec2(place & 2047u, (place >> 11) & 2047u) * side);
    envsh_vertex v;
    v.depth = dot(uintBitsToFloat(texelFetch(glbk_envsh_views, glbk_table_at(at + 2u), 0)), p);
    v.inside = vec4(texel - float(guard), float(side - guard) - texel);
#ifdef GL_ES
    vec2 inner = v.inside.xy * glbk_envsh_scene.clip_per_inside - 1.0;
    float y = (corner.y + texel.y) * glbk_envsh_scene.clip_per_texel_y - 1.0;
    v.position = vec4(inner.x, y, inner.y, 1.0);
#else
    vec2 clip_per_texel = vec2(glbk_envsh_scene.clip_per_texel_x, glbk_envsh_scene.clip_per_texel_y);
    v.position = vec4((corner + texel) * clip_per_texel - 1.0, 2.0 * v.depth - 1.0, 1.0);
#endif
    return v;
}

#ifdef GL_ES
#define ENVSH_CLIP(d)
#define ENVSH_WRITE_DEPTH(depth) gl_FragDepth = clamp(depth, 0.0, 1.0);
#else
#define ENVSH_CLIP_PAIR(i, d) gl_ClipDistance[i] = d.x; gl_ClipDistance[i + 1] = d.y;
#define ENVSH_CLIP(d) ENVSH_CLIP_PAIR(0, d.xy) ENVSH_CLIP_PAIR(2, d.zw)
#define ENVSH_WRITE_DEPTH(depth)
#endif
#define ENVSH_SET(v) gl_Position = v.position; envsh_depth = v.depth; ENVSH_CLIP(v.inside)
#define ENVSH_CAST(world) { envsh_vertex envsh_v = envsh_cast(gl_InstanceID, world); ENVSH_SET(envsh_v) }

#if ENVSH_RGBA
#define ENVSH_BITS(depth) uvec4(floatBitsToUint(clamp(depth, 0.0, 1.0)))
#define ENVSH_STORE(depth) { envsh_bits = ENVSH_BITS(depth); ENVSH_WRITE_DEPTH(depth) }
#else
#define ENVSH_STORE(depth) { ENVSH_WRITE_DEPTH(depth) }
#endif
