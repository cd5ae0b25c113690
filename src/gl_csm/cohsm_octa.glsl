// cohsm_octa - arc cosines, and the equal-area octahedral map, with the answers of csm.h (src/shared: trig.h
// and octa.h)
//
// uses: cohsm_math

float cohsm_acos(float x)
{
    float a = min(abs(x), 1.0), h = 0.5 * (1.0 - a);
    bool far = a > 0.5;
    float s = cohsm_if(far, sqrt(h), a), z = cohsm_if(far, h, a * a);
    float p = s + s * z * (0.1666675393 + z * (0.07495241769 + z * (0.04547709903 + z * (0.02414760004 +
              z * 0.04221856856))));
    p = cohsm_if(far, 2.0 * p, 1.57079633 - p);
    return cohsm_if(x < 0.0, 3.14159265 - p, p);
}

// Returns the unit direction of a point of the unit square by the equal-area map with +Y in the middle
// (Clarberg 2008).
vec3 cohsm_octa_direction(vec2 uv)
{
    float a = 2.0 * uv.x - 1.0, b = 2.0 * uv.y - 1.0, x = abs(a), z = abs(b);
    float d = 1.0 - (x + z), r = 1.0 - abs(d), f = r * sqrt(2.0 - r * r);
    vec2 sc = cohsm_sincos(cohsm_if(r > 0.0, ((z - x) / r + 1.0) * 0.785398163, 0.0));
    return vec3(cohsm_if(a < 0.0, -f * sc.y, f * sc.y), cohsm_if(d < 0.0, r * r - 1.0, 1.0 - r * r),
                cohsm_if(b < 0.0, -f * sc.x, f * sc.x));
}

// Returns the point of the unit square of a unit direction.
vec2 cohsm_octa_square(vec3 n)
{
    float r = sqrt((n.x * n.x + n.z * n.z) / (1.0 + abs(n.y)));
    float b = cohsm_atan2(abs(n.z), abs(n.x)) * 0.636619772 * r, a = r - b, t = a;
    if (n.y < 0.0) {
        a = 1.0 - b;
        b = 1.0 - t;
    }
    a = clamp(a, 0.0, 1.0);
    b = clamp(b, 0.0, 1.0);
    return 0.5 * vec2(cohsm_if(n.x < 0.0, 1.0 - a, 1.0 + a), cohsm_if(n.z < 0.0, 1.0 - b, 1.0 + b));
}
