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
    return -t * (1.0 + t * (0.5 + t * (0.166666667 + t * (0.0416666667 + t * (0.00833333333 + t * (0.00138888889 +
           t * 0.000198412698))))));
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

// The texels of an axis below its window, of `size` a side with `rim` outside of it; `size` where it is not worth its rim.
// cut: 64ths of the square below and above it.
uint ism_below(uvec2 cut, uint size, uint rim)
{
    uint rest = cut.x + cut.y;
    if (!(rest * size > rim * 64u) || rest >= 64u) return size;
    uint a = (2u * rim * cut.x + rest) / (2u * rest);
    if (cut.x != 0u && a == 0u) a = 1u;
    return cut.y != 0u && a == rim ? rim - 1u : a;
}

// From 0..1 of the square to the texels of a tile's axis, and back: linear below, in and above the window.
float ism_zoom_axis(uvec2 cut, uint size, uint rim, float u)
{
    uint a = ism_below(cut, size, rim), wide = 64u - cut.x - cut.y;
    float low = float(cut.x) * 0.015625, high = float(64u - cut.y) * 0.015625, x;
    if (a == size) return u * float(size);
    if (u < low) x = u * (float(64u * a) / float(cut.x));
    else if (u < high) x = float(a) + (u - low) * (float(64u * (size - rim)) / float(wide));
    else x = float(size - rim + a) + (cut.y == 0u ? 0.0 : (u - high) * (float(64u * (rim - a)) / float(cut.y)));
    return clamp(x, 0.0, float(size));
}

float ism_unzoom_axis(uvec2 cut, uint size, uint rim, float x)
{
    uint a = ism_below(cut, size, rim), b = size - rim + a, wide = 64u - cut.x - cut.y;
    float u;
    if (a == size) return x / float(size);
    if (x < float(a)) u = x * (float(cut.x) / float(64u * a));
    else if (x < float(b)) u = float(cut.x) * 0.015625 + (x - float(a)) * (float(wide) / float(64u * (size - rim)));
    else u = float(64u - cut.y) * 0.015625 + (cut.y == 0u ? 0.0 : (x - float(b)) * (float(cut.y) / float(64u * (rim - a))));
    return clamp(u, 0.0, 1.0);
}

// Of both axes; window: ism_vpl.window.
vec2 ism_zoom(uint window, uint size, uint rim, vec2 uv)
{
    uvec4 cut = uvec4(window, window >> 6, window >> 12, window >> 18) & 63u;
    return vec2(ism_zoom_axis(cut.xz, size, rim, uv.x), ism_zoom_axis(cut.yw, size, rim, uv.y));
}

vec2 ism_unzoom(uint window, uint size, uint rim, vec2 at)
{
    uvec4 cut = uvec4(window, window >> 6, window >> 12, window >> 18) & 63u;
    return vec2(ism_unzoom_axis(cut.xz, size, rim, at.x), ism_unzoom_axis(cut.yw, size, rim, at.y));
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
