// A G-buffer of the user's, brought into ours.
// uses: gbuffer_bindings gbuffer_imported gbuffer_write
// with: screen.vert
// sets: GBUFFER_DEPTH=0 | GBUFFER_DEPTH=1
#ifndef GBUFFER_DEPTH
#define GBUFFER_DEPTH 0             // not 0: our depth texture is drawn to
#endif

const uint has_places = 1u, has_depth = 2u, has_flat = 4u, has_colors = 8u, has_gloss = 16u, has_occlusion = 32u,
           has_entities = 64u, reversed = 128u;

bool has(uint what) { return (glbk_gbuffer_imported.how.x & what) != 0u; }
float depth_at(ivec2 at) { return texelFetch(glbk_gbuffer_depth_in, at, 0).x; }

// w: 0 where nothing is seen, as far as places and depths say so.
vec4 place_at(ivec2 at)
{
    if (at.x < 0 || at.y < 0 || at.x >= int(glbk_gbuffer_imported.how.z) || at.y >= int(glbk_gbuffer_imported.how.w))
        return vec4(0.0);
    float depth = has(has_depth) ? depth_at(at) : 0.5;
    bool seen = has(reversed) ? depth > 0.0 : depth < 1.0;
    if (!seen) return vec4(0.0);
    if (has(has_places)) {
        vec4 p = texelFetch(glbk_gbuffer_place_in, at, 0);
        return p.w == 0.0 ? vec4(0.0) : vec4((glbk_gbuffer_imported.to_world * vec4(p.xyz, 1.0)).xyz, 1.0);
    }
    vec2 size = vec2(glbk_gbuffer_imported.how.zw), xy = (vec2(at) + 0.5) / size * 2.0 - 1.0;
    vec4 scale = glbk_gbuffer_imported.depths;
    vec4 p = glbk_gbuffer_imported.from_clip * vec4(xy, depth * scale.x + scale.y, 1.0);
    return vec4(p.xyz / p.w, 1.0);
}

// 0 where it holds none.
vec3 normal_of(vec3 v)
{
    uint packing = glbk_gbuffer_imported.how.y;
    if (packing == 2u || packing == 4u) v = v * 2.0 - 1.0;
    if (packing >= 3u) v = glbk_unit_of_square(v.xy);
    float d = dot(v, v);
    if (!(d > 0.25 && d < 2.25)) return vec3(0.0);
    return glbk_unit(mat3(glbk_gbuffer_imported.to_world) * v);
}

// From the pixel to that neighbour of two which lies nearer to the plane across n: an edge lies at one side, as a rule.
vec3 step_along(ivec2 at, ivec2 by, vec3 p, vec3 n)
{
    vec4 a = place_at(at + by), b = place_at(at - by);
    vec3 da = a.xyz - p, db = p - b.xyz;
    float off_a = dot(da, n) * dot(da, n) * dot(db, db), off_b = dot(db, n) * dot(db, n) * dot(da, da);
    bool first = a.w != 0.0 && (b.w == 0.0 || off_a <= off_b);
    return first ? da : b.w != 0.0 ? db : vec3(0.0);
}

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    uvec4 numbers = glbk_gbuffer_imported.numbers;
    vec4 p = place_at(at);
    vec3 n = normal_of(texelFetch(glbk_gbuffer_normal_in, at, 0).xyz);
    if (p.w == 0.0 || dot(n, n) == 0.0) discard;
    vec3 view = glbk_gbuffer_imported.eye.xyz - p.xyz;
    vec3 flat_n = has(has_flat) ? normal_of(texelFetch(glbk_gbuffer_flat_in, at, 0).xyz)
                                : glbk_unit(cross(step_along(at, ivec2(1, 0), p.xyz, n),
                                                  step_along(at, ivec2(0, 1), p.xyz, n)));
    if (dot(flat_n, view) < 0.0) flat_n = -flat_n;
    if (dot(n, flat_n) < 0.0) n = -n;
    if (!has(has_flat) && dot(n, flat_n) < 0.25) {          // across edges on all sides, or none at all
        flat_n = dot(n, view) < 0.0 ? -n : n;
        n = flat_n;
    }
    vec3 color = glbk_gbuffer_imported.diffuse.xyz, map = vec3(1.0);
    float occlusion = glbk_gbuffer_imported.depths.z;
    if (has(has_colors)) color *= texelFetch(glbk_gbuffer_color_map, at, 0).xyz;
    if (has(has_gloss)) map = texelFetch(glbk_gbuffer_gloss_map, at, 0).xyz;
    if (has(has_occlusion)) occlusion = 1.0 - texelFetch(glbk_gbuffer_open_in, at, 0).x;
    if (has(has_entities)) numbers.y = texelFetch(glbk_gbuffer_entity_in, at, 0).x;
#if GBUFFER_DEPTH
    float depth = 0.0;
    if (has(has_depth)) {
        depth = depth_at(at);
        if (has(reversed)) depth = 1.0 - depth;
    } else {
        vec4 clip = glbk_gbuffer_imported.to_clip * vec4(p.xyz, 1.0);
        if (clip.w > 0.0) depth = clamp(clip.z / clip.w * 0.5 + 0.5, 0.0, 1.0);
    }
    gl_FragDepth = depth;
#endif
    glbk_write_surface(p.xyz, n, flat_n, vec3(0.0), numbers, glbk_gbuffer_imported.lobes, color,
                       glbk_gbuffer_imported.gloss, map, occlusion);
}
