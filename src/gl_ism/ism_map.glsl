// ism_map - maps the hemisphere about +z to the unit square and back, and has planes of surfels. Its C twins
// stand in ism.h.
// uses: cohsm_math
#define ISM_PROJECTION_COSINE 1u
#define ISM_PROJECTION_PARABOLOID 2u
#define ISM_PROJECTION_OCTAHEDRAL 3u
#define ISM_PROJECTION_LOBE 4u
#define ISM_FAR 1e30
// ISM_PROJECTION is the projection of all VPLs, so that no program holds the code of others. Lobes of
// exponent 1 have the cosine's.
#ifndef ISM_PROJECTION
#define ISM_PROJECTION 1
#elif ISM_PROJECTION == 0
#undef ISM_PROJECTION
#define ISM_PROJECTION 1
#endif

// Returns the projection of a VPL's map.
uint ism_projection_of(float exponent)
{
#if ISM_PROJECTION == 4
    return exponent == 1.0 ? ISM_PROJECTION_COSINE : ISM_PROJECTION_LOBE;
#else
    return uint(ISM_PROJECTION);
#endif
}

// Returns 1 - x^y for x in 0..1, with all its digits where that is small.
float ism_power_gap(float x, float y)
{
    if (!(x > 1.18e-38)) return 1.0;
    float t = y * cohsm_log(min(x, 1.0));
    if (t < -0.35) return 1.0 - cohsm_exp(t);
    return -t * (1.0 + t * (0.5 + t * (0.166666667 + t * (0.0416666667 + t * (0.00833333333 +
           t * (0.00138888889 + t * 0.000198412698))))));
}

// Returns the unit direction of a place on the unit square.
vec3 ism_map_direction(uint projection, float exponent, vec2 uv)
{
    vec2 ab = 2.0 * uv - 1.0;
    if (projection == ISM_PROJECTION_PARABOLOID) {
        float r2 = dot(ab, ab);
        return vec3(2.0 * ab, 1.0 - r2) / (1.0 + r2);
    }
    if (projection == ISM_PROJECTION_OCTAHEDRAL) {
        vec2 p = 0.5 * vec2(ab.x + ab.y, ab.x - ab.y);
        return cohsm_normalize(vec3(p, 1.0 - abs(p.x) - abs(p.y)));
    }
    float e = projection == ISM_PROJECTION_LOBE ? exponent : 1.0, r = max(abs(ab.x), abs(ab.y));
    float s = max(1.0 - r * r, 0.0), z = e == 1.0 ? sqrt(s) : cohsm_pow(s, 1.0 / (e + 1.0));
    float sine = e == 1.0 ? r : sqrt(ism_power_gap(s, 2.0 / (e + 1.0)));
    return vec3(cohsm_concentric(uv) * (r > 1e-12 ? sine / r : 1.0), z);
}

// Finds the place of a unit direction on the unit square. Returns false if the direction is at or below the
// horizon.
bool ism_map_coordinates(uint projection, float exponent, vec3 w, out vec2 uv)
{
    vec2 ab;
    uv = vec2(0.0);
    if (!(w.z > 0.0)) return false;
    if (projection == ISM_PROJECTION_PARABOLOID) {
        ab = w.xy / (1.0 + w.z);
    } else if (projection == ISM_PROJECTION_OCTAHEDRAL) {
        ab = vec2(w.x + w.y, w.x - w.y) / (abs(w.x) + abs(w.y) + w.z);
    } else {
        float e = projection == ISM_PROJECTION_LOBE ? exponent : 1.0;
        if (e != 1.0) {
            float sine = sqrt(dot(w.xy, w.xy));
            w.xy *= sine > 1e-12 ? sqrt(ism_power_gap(w.z, e + 1.0)) / sine : 1.0;
        }
        uv = cohsm_disc_square(w.xy);
        return true;
    }
    uv = clamp(0.5 * ab + 0.5, 0.0, 1.0);
    return true;
}

// Returns an axis of a tile of `size` texels a side, `rim` of which lie outside of its window. x has how many
// texels lie below the window (all, if the window is not worth its rim), yzw the share of the square that a
// texel has below, in and above the window. cut has how many 64ths of the square lie below and above.
vec4 ism_axis(uvec2 cut, uint size, uint rim)
{
    uint rest = cut.x + cut.y;
    if (!(rest * size > rim * 64u) || rest >= 64u) return vec4(float(size), 1.0 / float(size), 1.0, 1.0);
    // Whole numbers are divided as floats, which lanes do side by side. The half keeps quotients away from
    // whole numbers.
    float a = floor((float(2u * rim * cut.x + rest) + 0.5) / float(2u * rest)), most = float(rim);
    if (cut.x != 0u && a == 0.0) a = 1.0;
    if (cut.y != 0u && a == most) a = most - 1.0;
    vec3 share = vec3(cut.x, 64u - rest, cut.y) / (64.0 * max(vec3(a, float(size - rim), most - a), 1.0));
    return vec4(a, a > 0.0 ? share.x : 1.0, share.y, a < most ? share.z : 1.0);
}

// Returns the place of u (0..1 of the square) on such an axis, in texels. The way is linear below, in and
// above the window.
float ism_zoom_axis(vec4 axis, float size, float rim, float u)
{
    float low = axis.x * axis.y, high = 1.0 - (rim - axis.x) * axis.w;
    vec3 part = u < low ? vec3(0.0, u, axis.y) : vec3(axis.x, u - low, axis.z);
    if (!(u < low) && !(u < high)) part = vec3(size, u - 1.0, axis.w);
    return clamp(part.x + part.y / part.z, 0.0, size);
}

// Returns the place on the square, 0..1, of a place on such an axis, in texels.
float ism_unzoom_axis(vec4 axis, float size, float rim, float x)
{
    float u = x < axis.x ? x * axis.y : x < axis.x + size - rim ? axis.x * axis.y + (x - axis.x) * axis.z
                                                                : 1.0 - (size - x) * axis.w;
    return clamp(u, 0.0, 1.0);
}

// Returns how many 64ths of the square a window leaves below it, and above it, along both axes.
uvec4 ism_cut(uint window) { return uvec4(window, window >> 6, window >> 12, window >> 18) & 63u; }

// Computes both axes of a tile. window is that of its VPL.
void ism_axes(uint window, uint size, uint rim, out vec4 across, out vec4 down)
{
    uvec4 cut = ism_cut(window);
    across = ism_axis(cut.xz, size, rim);
    down = ism_axis(cut.yw, size, rim);
}

// Returns a basis about z as columns x, y, z. v * basis gives a vector by this basis.
mat3 ism_basis_of(vec3 z)
{
    vec3 x, y;
    cohsm_basis(z, x, y);
    return mat3(x, y, z);
}

// Returns the depth of a surfel's plane g in direction w, or at place w of a sky's map, or 0 if the ray does
// not meet the plane.
float ism_plane_depth(bool sky, vec3 g, vec3 w)
{
    float s = dot(g, w);
    if (sky) return max(s, 0.0);
    return s > 1e-20 ? 1.0 / s : 0.0;
}
