// Fills a face of a map from textures of the user's own.
// uses: rsm_bindings rsm_imported rsm_bound
// with: screen.vert
// sets: KIND=0 | KIND=1 | KIND=2
#ifndef KIND
#define KIND 0                      // the textures are: 0 2D, 1 layers of arrays, 2 cubes
#endif
layout(location = 0) out uvec4 rsm_out_place;
layout(location = 1) out uvec4 rsm_out_normal;
layout(location = 2) out uvec4 rsm_out_flux;

// These are the bits of the block's `given`.
const uint has_depth = 1u, has_places = 2u, has_colors = 4u, has_materials = 8u;
const uint reversed = 16u, colors_are_flux = 32u;

// These are numbers of glbk_normal_packing; with the others, normals come as floats.
const uint packed_unit = 2u, packed_octahedral = 3u, packed_octahedral_unit = 4u;

ivec2 rsm_at;                       // the texel that is read: of 2D textures and layers its place,
vec3 rsm_toward;                    // and the direction from the light; of a cube its texel's, 1 along its axis

#if KIND == 0
#define RSM_IN_2D(name) texelFetch(name, rsm_at, 0)
#define RSM_DEPTH_IN RSM_IN_2D(glbk_rsm_depth_in)
#define RSM_PLACE_IN RSM_IN_2D(glbk_rsm_place_in)
#define RSM_NORMAL_IN RSM_IN_2D(glbk_rsm_normal_in)
#define RSM_COLOR_IN RSM_IN_2D(glbk_rsm_color_in)
#define RSM_MATERIAL_IN RSM_IN_2D(glbk_rsm_material_in)
#elif KIND == 1
#define RSM_IN_ARRAY(name, layer) texelFetch(name, ivec3(rsm_at, int(layer)), 0)
#define RSM_DEPTH_IN RSM_IN_ARRAY(glbk_rsm_depth_array, glbk_rsm_imported.depth_layer)
#define RSM_PLACE_IN RSM_IN_ARRAY(glbk_rsm_place_array, glbk_rsm_imported.place_layer)
#define RSM_NORMAL_IN RSM_IN_ARRAY(glbk_rsm_normal_array, glbk_rsm_imported.normal_layer)
#define RSM_COLOR_IN RSM_IN_ARRAY(glbk_rsm_color_array, glbk_rsm_imported.color_layer)
#define RSM_MATERIAL_IN RSM_IN_ARRAY(glbk_rsm_material_array, glbk_rsm_imported.material_layer)
#else
#define RSM_IN_CUBE(name) textureLod(name, rsm_toward, 0.0)
#define RSM_DEPTH_IN RSM_IN_CUBE(glbk_rsm_depth_cube)
#define RSM_PLACE_IN RSM_IN_CUBE(glbk_rsm_place_cube)
#define RSM_NORMAL_IN RSM_IN_CUBE(glbk_rsm_normal_cube)
#define RSM_COLOR_IN RSM_IN_CUBE(glbk_rsm_color_cube)
#define RSM_MATERIAL_IN RSM_IN_CUBE(glbk_rsm_material_cube)
#endif

bool has(uint what) { return (glbk_rsm_imported.given & what) != 0u; }

// Returns the depth along the axis that a value of a depth buffer stands for.
float depth_of(rsm_light l, float stored)
{
    float n = glbk_rsm_imported.near_depth, f = glbk_rsm_imported.far_depth, range = f - n;
    if (has(reversed)) return l.kind == RSM_SUN ? f - stored * range : n * f / (n + stored * range);
    return l.kind == RSM_SUN ? n + stored * range : n * f / (f - stored * range);
}

// Returns the direction through the centre of the cube's texel that a direction meets, 1 along the axis of
// the cube's face: so a linear filter reads this texel alone, and its place is where the cube saw it.
vec3 centre_of_texel(vec3 d, float side)
{
    vec3 a = abs(d);
    float m = max(max(a.x, a.y), a.z);
    vec3 c = (floor((d / m * 0.5 + 0.5) * side) + 0.5) * 2.0 / side - 1.0;
    vec3 along = a.x >= a.y && a.x >= a.z ? vec3(1.0, 0.0, 0.0)
                                          : a.y >= a.z ? vec3(0.0, 1.0, 0.0) : vec3(0.0, 0.0, 1.0);
    return mix(c, sign(d), along);
}

// Returns the unit vector that the octahedral map has at a point of the square -1..1.
vec3 unit_of_square(vec2 p)
{
    float z = 1.0 - abs(p.x) - abs(p.y), t = max(-z, 0.0);
    return rsm_normalize(vec3(p.x + (p.x >= 0.0 ? -t : t), p.y + (p.y >= 0.0 ? -t : t), z));
}

// Returns the unit normal in world space that a texel holds, or 0 where it holds none.
vec3 normal_of(vec3 v)
{
    uint packing = glbk_rsm_imported.normal_packing;
    if (packing == packed_unit || packing == packed_octahedral_unit) v = v * 2.0 - 1.0;
    if (packing >= packed_octahedral) v = unit_of_square(v.xy);
    float d = dot(v, v);
    if (!(d > 0.25 && d < 2.25)) return vec3(0.0);
    return rsm_normalize(mat3(glbk_rsm_imported.to_world) * v);
}

// Returns whether all three numbers are from `low` to `high`. Compilers may turn comparisons round as if there
// were no NaNs, so what is no finite number is found by its bits.
bool within(vec3 v, float low, float high)
{
    uvec3 size = floatBitsToUint(v) & 0x7fffffffu;
    return all(lessThan(size, uvec3(0x7f800000u))) && all(greaterThanEqual(v, vec3(low))) &&
           all(lessThanEqual(v, vec3(high)));
}

// Finds the place of the texel in world space; returns false if nothing is seen there.
bool find_place(rsm_light l, out vec3 place)
{
    place = vec3(0.0);
    float stored = has(has_depth) ? RSM_DEPTH_IN.x : 0.5;
    bool seen = has(reversed) ? stored > 0.0 : stored < 1.0;
    if (!seen) return false;
    if (has(has_places)) {
        vec4 p = RSM_PLACE_IN;
        place = (glbk_rsm_imported.to_world * vec4(p.xyz, 1.0)).xyz;
        return p.w != 0.0;
    }
    float z = depth_of(l, stored);
    vec3 r, u, a;
    rsm_face_axes(l, int(glbk_rsm_imported.face), r, u, a);
    place = l.position + (l.kind == RSM_SUN ? rsm_toward + a * (z - 1.0) : rsm_toward * z);
    return true;
}

void main()
{
    rsm_light l = rsm_bound();
    int face = int(glbk_rsm_imported.face);
    ivec2 t = ivec2(gl_FragCoord.xy);
    vec2 q = vec2(rsm_texel_centre(l, t.x), rsm_texel_centre(l, t.y)) * l.extent;
    vec3 r, u, a, place;
    rsm_face_axes(l, face, r, u, a);
    rsm_at = t + ivec2(int(glbk_rsm_imported.left), int(glbk_rsm_imported.bottom));
    rsm_toward = a + r * q.x + u * q.y;
#if KIND == 2
    rsm_toward = centre_of_texel(rsm_toward, l.side);
#endif
    rsm_out_place = uvec4(0u, 0u, 0u, floatBitsToUint(3.0e38));
    rsm_out_normal = rsm_out_flux = uvec4(0u);
    bool seen = find_place(l, place);
    vec3 n = normal_of(RSM_NORMAL_IN.xyz);
    if (!seen || !(dot(n, n) > 0.5) || !within(place, -1e9, 1e9)) return;
    vec3 color = glbk_rsm_imported.color.xyz, flux;
    if (has(has_colors)) color *= RSM_COLOR_IN.xyz;
    flux = has(colors_are_flux) ? color : rsm_incident(l, face, t) * l.value * color;
    if (!within(color, 0.0, 3.0e38) || !within(flux, 0.0, 1e18)) return;
    uint material = glbk_rsm_imported.material;
    if (has(has_materials)) material = RSM_MATERIAL_IN.x;
    rsm_out_place = floatBitsToUint(vec4(place, dot(place - l.position, a)));
    rsm_out_normal = uvec4(floatBitsToUint(n), material);
    rsm_out_flux = floatBitsToUint(vec4(flux, rsm_area(l, face, place, n)));
}
