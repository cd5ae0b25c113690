// ism_disc - places surfels as discs in the tiles of their VPLs.
// uses: ism_access
#define ISM_DEEPEST 1.84467429e19      // the depth buffer does not hold 2^64

struct ism_surfel {
    vec3  at;                   // the disc's middle, in the tile's space
    vec3  g;                    // the disc's plane: see ism_plane_depth
    float radius2;              // squared radius
    float depth;                // distance of the middle
    vec2  uv;                   // place of the middle on the unit square
    vec4  cut1, cut2;           // xyz: how two barycentric coordinates grow along the disc; w: their
                                // values at the middle. cut1.w < -1: edges do not cut the disc
    ivec4 box;                  // the first and the last texel of the tile that the disc may touch
};

// Places a disc of an area about p in the map of VPL l. Returns false if the disc does not lie before the
// VPL.
bool ism_place_surfel(ism_vpl l, vec3 p, vec3 normal, float area, inout ism_surfel s)
{
    mat3 basis = l.basis;
    vec3 n = normal * basis;
    s.radius2 = area * (1.0 / COHSM_PI);
    if (l.sky) {
        vec3 o = (p - ISM_F.sphere.xyz) * basis;
        float r = ISM_F.sphere.w, slope = abs(n.z) > 0.05 ? 1.0 / n.z : 0.0;
        s.depth = o.z + r;
        s.uv = 0.5 * o.xy / r + 0.5;
        s.at = vec3(o.xy, s.depth);
        s.g = vec3(-n.xy * slope * r, s.depth + dot(n.xy, o.xy) * slope);
        return fract(s.uv) == s.uv;                     // within 0..1, 1 left out
    }
    vec3 o = (p - l.position) * basis;
    float d2 = dot(o, o), along = dot(n, o);
    s.depth = sqrt(d2);
    s.at = o;
    s.g = o / d2;
    if (!(d2 > 1e-30) || !(o.z > 1e-3 * s.depth)) return false;
    // The surface that the VPL lies on is no occluder; in a lobe's map, which is tilted, the surface could be
    // one.
    bool lobe = ism_projection_of(l.exponent) == ISM_PROJECTION_LOBE;
    if (lobe && !(abs(dot(basis * o, l.normal)) > 1e-3 * s.depth)) return false;
    s.radius2 = min(s.radius2, (along > 0.0 && s.cut1.w < -1.0 ? 0.04 : 1.0) * d2);
    if (abs(along) > 1e-3 * s.depth) s.g = n / along;
    if (!ism_map_coordinates(ism_projection_of(l.exponent), l.exponent, o / s.depth, s.uv)) return false;
    // The disc also stands for neighbours of its surfel, which may lie off its plane by about its radius.
    // Moved so much farther away the disc hides none of them.
    if (s.cut1.w < -1.0) {
        float away = 1.0 + sqrt(s.radius2) / s.depth;
        s.at *= away;
        s.g /= away;
        s.radius2 *= away * away;
        s.depth *= away;
    }
    return true;
}

// Returns the most texels that a radian has, or a unit of space in the map of a sky, in a map without a
// window.
float ism_texels_per_unit(ism_vpl l)
{
    float size = float(ISM_F.tile_side);
    uint p = ism_projection_of(l.exponent);
    if (l.sky) return 0.5 * size / ISM_F.sphere.w;
    if (p == ISM_PROJECTION_PARABOLOID) return 0.5 * size;
    return 0.9 * size * (p == ISM_PROJECTION_LOBE ? sqrt(0.5 * (l.exponent + 1.0)) : 1.0);
}

// Returns whether a tile shows triangles of this opacity. 2 x 2 tiles show 4 levels of opacity (paper,
// section 6.4).
bool ism_dither(uvec2 tile, float opacity)
{
    uint i = (tile.y & 1u) * 2u + (tile.x & 1u);
    return opacity > (i == 0u ? 0.125 : i == 1u ? 0.625 : i == 2u ? 0.875 : 0.375);
}

// Returns the position of a vertex.
vec3 ism_corner(uint vertex) { return texelFetch(glbk_ism_positions, glbk_table_at(vertex), 0).xyz; }

// Finds the texels that the disc may touch. Returns false if there are none.
bool ism_box_surfel(ism_vpl l, inout ism_surfel s)
{
    int size = int(ISM_F.tile_side);
    float most = float(size), reach = sqrt(s.radius2) * ism_texels_per_unit(l) / (l.sky ? 1.0 : s.depth);
    if (!(reach > 0.0)) return false;
    reach = min(reach, most);
    if (l.window == 0u) {
        s.box = ivec4(max(s.uv * most - reach, 0.0), min(ivec2(s.uv * most + reach), size - 1));
    } else {
        vec2 first = ism_to_tile(l.grid, s.uv - reach / most);
        vec2 last = ism_to_tile(l.grid, s.uv + reach / most);
        s.box = ivec4(max(first, 0.0), min(ivec2(last), size - 1));
    }
    return true;
}

// Reads surfel `index` of the table and places the surfel in the map of VPL v. Returns false if the map does
// not show the surfel.
bool ism_surfel_of(uint index, uint v, ism_vpl l, out ism_surfel s)
{
    uvec4 surfel = texelFetch(glbk_ism_surfels, glbk_table_at(index), 0);
    float share = uintBitsToFloat(surfel.w);
    if (!(share > 0.0) || surfel.x >= ISM_F.triangle_count) return false;
    uvec4 t = texelFetch(glbk_ism_triangles, glbk_table_at(surfel.x), 0);
    uvec2 tile = uvec2(v % ISM_F.tiles_across, v / ISM_F.tiles_across);
    if (!ism_dither(tile, uintBitsToFloat(t.w))) return false;
    vec3 p = ism_corner(t.x), e1 = ism_corner(t.y) - p, e2 = ism_corner(t.z) - p, n = cross(e1, e2);
    float length2 = dot(n, n), size = sqrt(length2);
    if (!(length2 > 0.0) || !cohsm_finite(length2)) return false;
    vec2 b = uintBitsToFloat(surfel.yz);
    float area = ISM_F.splat_scale * share * 0.5 * size;
    p += e1 * b.x + e2 * b.y;
    s.cut1 = s.cut2 = vec4(-2.0);
    if (share < 1.0) {
        s.cut1 = vec4((cross(e2, n) / length2) * l.basis, b.x);
        s.cut2 = vec4((cross(n, e1) / length2) * l.basis, b.y);
        area *= 6.0;
    }
    return ism_place_surfel(l, p, n / size, area, s) && ism_box_surfel(l, s);
}

// Returns the depth at which the ray through a texel of the tile, in direction w, meets the disc, or ISM_FAR
// if the ray misses the disc or meets it beyond the limit. No disc is widened to a whole texel.
float ism_meet(bool sky, ism_surfel s, vec3 w, float limit)
{
    float t = ism_plane_depth(sky, s.g, w);
    if (!(t > 0.0 && t <= min(limit, ISM_DEEPEST))) return ISM_FAR;
    vec3 d = (sky ? vec3(w.xy * ISM_F.sphere.w, t) : w * t) - s.at;
    if (!(dot(d, d) <= s.radius2)) return ISM_FAR;
    vec2 b = vec2(s.cut1.w + dot(d, s.cut1.xyz), s.cut2.w + dot(d, s.cut2.xyz));
    return s.cut1.w > -1.0 && !(min(b.x, b.y) >= -1e-4 && b.x + b.y <= 1.0001) ? ISM_FAR : t;
}
