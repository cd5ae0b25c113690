// ism_map - the hemisphere about +z and the unit square, and the planes of surfels. C twins: ism.h.
// uses: cohsm_math
#define ISM_PROJECTION_COSINE 1u
#define ISM_PROJECTION_PARABOLOID 2u
#define ISM_PROJECTION_OCTAHEDRAL 3u
#define ISM_PROJECTION_LOBE 4u
#define ISM_FAR 1e30
// Of all VPLs, so that no program holds the code of the others; lobes of exponent 1 have the cosine's.
#ifndef ISM_PROJECTION
#define ISM_PROJECTION 1
#elif ISM_PROJECTION == 0
#undef ISM_PROJECTION
#define ISM_PROJECTION 1
#endif

uint ism_projection_of(float exponent)
{
#if ISM_PROJECTION == 4
    return exponent == 1.0 ? ISM_PROJECTION_COSINE : ISM_PROJECTION_LOBE;
#else
    return uint(ISM_PROJECTION);
#endif
}

// 1 - x^y for x in 0..1, to the last digits where that is small.
float ism_power_gap(float x, float y)
{
    if (!(x > 1.18e-38)) return 1.0;
    float t = y * cohsm_log(min(x, 1.0));
    if (t < -0.35) return 1.0 - cohsm_exp(t);
    return -t * (1.0 + t * (0.5 + t * (0.166666667 + t * (0.0416666667 + t * (0.00833333333 +
           t * (0.00138888889 + t * 0.000198412698))))));
}

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

// false: at or below the horizon.
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

// An axis of a tile of `size` texels a side, `rim` of them outside of its window: how many lie below it (all
// where it is not worth its rim), and what share of the square a texel has below, in and above it. cut: 64ths
// of the square below and above.
vec4 ism_axis(uvec2 cut, uint size, uint rim)
{
    uint rest = cut.x + cut.y;
    if (!(rest * size > rim * 64u) || rest >= 64u) return vec4(float(size), 1.0 / float(size), 1.0, 1.0);
    // whole numbers divided as floats, which lanes do side by side: with the half no quotient is near a whole
    // number
    float a = floor((float(2u * rim * cut.x + rest) + 0.5) / float(2u * rest)), most = float(rim);
    if (cut.x != 0u && a == 0.0) a = 1.0;
    if (cut.y != 0u && a == most) a = most - 1.0;
    vec3 share = vec3(cut.x, 64u - rest, cut.y) / (64.0 * max(vec3(a, float(size - rim), most - a), 1.0));
    return vec4(a, a > 0.0 ? share.x : 1.0, share.y, a < most ? share.z : 1.0);
}

// From 0..1 of the square to the texels of such an axis, and back: linear below, in and above the window.
float ism_zoom_axis(vec4 axis, float size, float rim, float u)
{
    float low = axis.x * axis.y, high = 1.0 - (rim - axis.x) * axis.w;
    vec3 part = u < low ? vec3(0.0, u, axis.y) : vec3(axis.x, u - low, axis.z);
    if (!(u < low) && !(u < high)) part = vec3(size, u - 1.0, axis.w);
    return clamp(part.x + part.y / part.z, 0.0, size);
}

float ism_unzoom_axis(vec4 axis, float size, float rim, float x)
{
    float u = x < axis.x ? x * axis.y : x < axis.x + size - rim ? axis.x * axis.y + (x - axis.x) * axis.z
                                                                : 1.0 - (size - x) * axis.w;
    return clamp(u, 0.0, 1.0);
}

// Both axes; window: ism_vpl.window.
void ism_axes(uint window, uint size, uint rim, out vec4 across, out vec4 down)
{
    uvec4 cut = uvec4(window, window >> 6, window >> 12, window >> 18) & 63u;
    across = ism_axis(cut.xz, size, rim);
    down = ism_axis(cut.yw, size, rim);
}

vec2 ism_zoom(uint window, uint size, uint rim, vec2 uv)
{
    vec4 across, down;
    ism_axes(window, size, rim, across, down);
    vec2 s = vec2(size, rim);
    return vec2(ism_zoom_axis(across, s.x, s.y, uv.x), ism_zoom_axis(down, s.x, s.y, uv.y));
}

vec2 ism_unzoom(uint window, uint size, uint rim, vec2 at)
{
    vec4 across, down;
    ism_axes(window, size, rim, across, down);
    vec2 s = vec2(size, rim);
    return vec2(ism_unzoom_axis(across, s.x, s.y, at.x), ism_unzoom_axis(down, s.x, s.y, at.y));
}

// Columns x, y, z; v * frame is v in it.
mat3 ism_frame_of(vec3 z)
{
    vec3 x, y;
    cohsm_basis(z, x, y);
    return mat3(x, y, z);
}

// Depth of a surfel's plane in direction w, or at place w of a sky's map; 0 where they do not meet.
float ism_plane_depth(bool sky, vec3 g, vec3 w)
{
    float s = dot(g, w);
    if (sky) return max(s, 0.0);
    return s > 1e-20 ? 1.0 / s : 0.0;
}
