// sfield_brdf - returns the kernels of glTF's metal-rough BRDF at a point, by the table of sfield_sh_brdf. C
// twin: gloss in shadowfield.h.
// uses: sfield_access sfield_field

// The table has a node for each of 24 roughnesses and 48 angles of view, and at a node six kernels, of the
// coefficients of order m >= 0 each: (1 - s) / pi, D V (1 - s) and D V s, times the cosine and then without
// it.
#define SFIELD_ROUGHNESSES 24
#define SFIELD_ANGLES 48
#define SFIELD_KERNEL ((SFIELD_BANDS * (SFIELD_BANDS + 1) / 2 + 3) / 4)    // texels of a kernel

#if SFIELD_GLOSS > 1
// Turns a function about z by an angle of that cosine and sine.
void sfield_turn_about_z(vec2 angle, inout float v[SFIELD_COEFS])
{
    float c = 1.0, s = 0.0;
    for (int m = 1; m < SFIELD_BANDS; m++) {
        float next = c * angle.x - s * angle.y;
        s = s * angle.x + c * angle.y;
        c = next;
        for (int l = m; l < SFIELD_BANDS; l++) {
            float p = v[l * l + l + m], q = v[l * l + l - m];
            v[l * l + l + m] = c * p - s * q;
            v[l * l + l - m] = s * p + c * q;
        }
    }
}

// Interpolates kernel 0..5 between four nodes of the table, in the frame in which the normal is z and the
// view lies in the plane of x and z. facing is the cosine between both.
void sfield_mix_kernel(uint kernel, float roughness, float facing, out float v[SFIELD_COEFS])
{
    float x = sqrt(1.0 - clamp(facing, 0.0, 1.0)) * float(SFIELD_ANGLES - 1);
    float y = clamp(roughness, 0.0, 1.0) * float(SFIELD_ROUGHNESSES - 1);
    uint i = min(uint(x), uint(SFIELD_ANGLES - 2)), j = min(uint(y), uint(SFIELD_ROUGHNESSES - 2));
    float u = x - float(i), w = y - float(j);
    uint step = uint(6 * SFIELD_KERNEL), row = uint(SFIELD_ANGLES) * step;
    uint at = glbk_sfield_contents.brdf_texel + j * row + i * step + kernel * uint(SFIELD_KERNEL);
    float half_of[4 * SFIELD_KERNEL];
    for (int k = 0; k < SFIELD_KERNEL; k++, at++) {
        vec4 a = uintBitsToFloat(SFIELD_TEXEL(at)), b = uintBitsToFloat(SFIELD_TEXEL(at + step));
        vec4 c = uintBitsToFloat(SFIELD_TEXEL(at + row)), d = uintBitsToFloat(SFIELD_TEXEL(at + row + step));
        vec4 q = (1.0 - w) * ((1.0 - u) * a + u * b) + w * ((1.0 - u) * c + u * d);
        for (int n = 0; n < 4; n++) half_of[4 * k + n] = q[n];
    }
    for (int l = 0; l < SFIELD_BANDS; l++)
        for (int m = 0; m <= l; m++) {
            v[l * l + l - m] = 0.0;
            v[l * l + l + m] = half_of[l * (l + 1) / 2 + m];
        }
}

// Writes kernel 0..5 in the world, for a unit normal and a unit vector to the eye: turned about z, about y,
// which is z between two quarter turns about x, and about z again.
void sfield_kernel(uint kernel, float roughness, vec3 n, vec3 view, out float v[SFIELD_COEFS])
{
    float ring = length(n.xy);
    vec2 heading = ring > 1e-6 ? n.xy / ring : vec2(1.0, 0.0);
    vec2 tilt = vec2(n.z, ring) / length(vec2(n.z, ring));
    vec2 across = vec2(n.z * dot(heading, view.xy) - ring * view.z, heading.x * view.y - heading.y * view.x);
    float far = length(across);
    sfield_mix_kernel(kernel, roughness, dot(n, view), v);
    sfield_turn_about_z(far > 1e-6 ? across / far : vec2(1.0, 0.0), v);
    uint turns = min(glbk_sfield_contents.term_count + 2u, 2u);    // 2, which compilers do not know
    for (uint i = 0u; i < turns; i++) {
        sfield_rotate(uint(SFIELD_COEFS), i > 0u, v);
        sfield_turn_about_z(i == 0u ? tilt : heading, v);
    }
}
#endif
