// cohsm_math - elementary functions with the answers of csm.h and lightsampling.h, for gl_csm.h and gl_ism.h
//
// It needs no other file. The polynomials are those of both headers (src/shared: trig.h and v3.h),
// since the built-in acos and atan of drivers are off by up to 1e-4, which would ask another map. The C twins
// are private: cohsm__sincos of csm.h, lsamp__sincos of lightsampling.h, and so on.

#define COHSM_PI 3.14159265
#define COHSM_BELOW_1 0.99999994
#define COHSM_HUGE 3.402823466e38

// Return c ? a : b, for operands that are more than names: as arguments they are computed first, so that no
// compiler makes two ways through the program of them (src/README.md).
float cohsm_if(bool c, float a, float b) { return c ? a : b; }
vec2 cohsm_if(bool c, vec2 a, vec2 b) { return c ? a : b; }
vec3 cohsm_if(bool c, vec3 a, vec3 b) { return c ? a : b; }
vec4 cohsm_if(bool c, vec4 a, vec4 b) { return c ? a : b; }
int cohsm_if(bool c, int a, int b) { return c ? a : b; }
uint cohsm_if(bool c, uint a, uint b) { return c ? a : b; }
uvec2 cohsm_if(bool c, uvec2 a, uvec2 b) { return c ? a : b; }
uvec4 cohsm_if(bool c, uvec4 a, uvec4 b) { return c ? a : b; }

bool cohsm_finite(float x) { return (floatBitsToUint(x) & 0x7f800000u) != 0x7f800000u; }
bool cohsm_finite3(vec3 v) { return cohsm_finite(v.x) && cohsm_finite(v.y) && cohsm_finite(v.z); }
float cohsm_clamp_unit(float u) { return cohsm_if(u > 0.0, min(u, COHSM_BELOW_1), 0.0); }
float cohsm_safe_sqrt(float x) { return cohsm_if(x > 0.0, sqrt(x), 0.0); }

// Returns |x| with the sign bit of s; s = -0 counts as negative.
float cohsm_copysign(float x, float s)
{
    return uintBitsToFloat((floatBitsToUint(x) & 0x7fffffffu) | (floatBitsToUint(s) & 0x80000000u));
}

// Returns sine and cosine of |x| <= 8192 with an absolute error of 1e-7.
vec2 cohsm_sincos(float x)
{
    float t = clamp(x, -8192.0, 8192.0);
    int k = int(t * 0.636619772 + (t < 0.0 ? -0.5 : 0.5));
    float q = float(k);
    float r = ((t - q * 1.5703125) - q * 4.837512969970703125e-4) - q * 7.5497899548918822e-8;
    float z = r * r;
    float s = r + r * z * (-0.1666665494 + z * (0.008332178146 + z * -0.0001951729898));
    float c = (1.0 - 0.5 * z) + z * z * (0.04166664687 + z * (-0.001388736752 + z * 2.443845159e-5));
    vec2 v = cohsm_if((k & 1) != 0, vec2(c, s), vec2(s, c));
    return vec2(cohsm_if((k & 2) != 0, -v.x, v.x), cohsm_if(((k + 1) & 2) != 0, -v.y, v.y));
}

// Returns atan2 in all quadrants and for zeros of either sign; atan2(0, 0) is 0.
float cohsm_atan2(float y, float x)
{
    float ax = abs(x), ay = abs(y), hi = max(ax, ay), lo = min(ax, ay);
    float a = cohsm_if(lo == hi && hi > 0.0, 1.0, lo / (hi > 0.0 ? hi : 1.0));
    bool steep = a > 0.414213562;
    float t = cohsm_if(steep, (a - 1.0) / (a + 1.0), a), z = t * t;
    float p = t + t * z * (-0.3333295525 + z * (0.1997792608 + z * (-0.1387984996 + z * 0.08060308882)));
    p = cohsm_if(steep, p + 0.785398163, p);
    p = cohsm_if(ay > ax, 1.57079633 - p, p);
    p = cohsm_if((floatBitsToUint(x) >> 31) != 0u, 3.14159265 - p, p);
    return cohsm_copysign(p, y);
}

// Returns exp(x) for x up to 88, and 0 below -87. ln 2 has two parts, since there are no doubles.
float cohsm_exp(float x)
{
    float t = clamp(x, -88.0, 88.0);
    float k = floor(t * 1.44269504 + 0.5);
    float r = (t - k * 0.693145752) - k * 1.42860677e-6;
    float p = 1.0 + (r + r * r * (0.500000008 + r * (0.166666669 + r * (0.0416662701 + r * (0.00833326438 +
              r * 0.00139460621)))));
    return cohsm_if(t < -87.0, 0.0, p * uintBitsToFloat(uint(int(k) + 127) << 23));
}

// Returns the logarithm of x > 0, which must not be denormal, from x = 2^e m with m in [sqrt(1/2), sqrt(2)),
// by log m = 2 artanh((m - 1) / (m + 1)), which keeps its digits near 1.
float cohsm_log(float x)
{
    uint bits = floatBitsToUint(x);
    int e = int(bits >> 23) - 127;
    float m = uintBitsToFloat((bits & 0x007fffffu) | 0x3f800000u);
    if (m > 1.41421356) {
        m *= 0.5;
        e += 1;
    }
    float s = (m - 1.0) / (m + 1.0), z = s * s;
    float p = 2.0 * (s + s * z * (0.333333328 + z * (0.200001676 + z * (0.142686543 + z * 0.117910756))));
    return float(e) * 0.693145752 + (p + float(e) * 1.42860677e-6);
}

// Returns x^y; x below 0 counts as 0. The relative error is 1e-7 times the size of y log x.
float cohsm_pow(float x, float y)
{
    if (y == 0.0) return 1.0;
    if (!(x > 1.18e-38)) return y > 0.0 ? 0.0 : COHSM_HUGE;
    float t = y * cohsm_log(x);
    return t > 88.0 ? COHSM_HUGE : cohsm_exp(t);
}

// Returns v with length 1, for tiny and huge vectors too; the zero vector stays zero.
vec3 cohsm_normalize(vec3 v)
{
    float m = max(max(abs(v.x), abs(v.y)), abs(v.z));
    if (!(m > 0.0)) return vec3(0.0);
    if (m < 1e-30) {
        v *= 1e30;
        m *= 1e30;
    }
    v /= m;
    return v / sqrt(dot(v, v));
}

// Writes t and b, which are orthonormal and right-handed together with a unit n.
void cohsm_basis(vec3 n, out vec3 t, out vec3 b)
{
    float s = n.z >= 0.0 ? 1.0 : -1.0, a = -1.0 / (s + n.z), c = n.x * n.y * a;
    t = vec3(1.0 + s * n.x * n.x * a, s * c, -s * n.x);
    b = vec3(c, s + n.y * n.y * a, -n.y);
}

// Returns where a point of the unit square goes on the unit disc by Shirley and Chiu's concentric map.
vec2 cohsm_concentric(vec2 uv)
{
    float a = 2.0 * uv.x - 1.0, b = 2.0 * uv.y - 1.0, r, phi;
    if (abs(a) > abs(b)) {
        r = a;
        phi = 0.785398163 * (b / a);
    } else {
        r = b;
        phi = cohsm_if(b == 0.0, 0.0, 1.57079633 - 0.785398163 * (a / b));
    }
    return r * cohsm_sincos(phi).yx;
}

// Returns the point of the unit square that cohsm_concentric takes to p.
vec2 cohsm_disc_square(vec2 p)
{
    float r = sqrt(p.x * p.x + p.y * p.y), a, b;
    if (abs(p.x) > abs(p.y)) {
        a = p.x > 0.0 ? r : -r;
        b = a * (4.0 / COHSM_PI) * cohsm_atan2(p.y / p.x, 1.0);
    } else {
        b = p.y > 0.0 ? r : -r;
        a = r > 0.0 ? b * (4.0 / COHSM_PI) * cohsm_atan2(p.x / p.y, 1.0) : 0.0;
    }
    return vec2(cohsm_clamp_unit(0.5 * (a + 1.0)), cohsm_clamp_unit(0.5 * (b + 1.0)));
}
