// sfield_field - reads shadow fields at a point, and has the algebra of their coefficients. C twins:
// shadowfield.h.
//
// Functions of direction are float[SFIELD_COEFS] of real spherical harmonics, with number l^2 + l + m and Y1
// = 0.4886 (y, z, x). Fields and tripling coefficients lie in one table, rotations in that of SFIELD_MOVING
// or, without this define, in the same one (docs/gpu-layouts.md). Their first texels name them.
#ifndef SFIELD_TEXEL
#error "SFIELD_TEXEL(i): texel i of the table as uvec4"
#endif
#ifndef SFIELD_BANDS
#error "SFIELD_BANDS: 1 to 8"
#endif
#ifndef SFIELD_MOVING
#define SFIELD_MOVING(i) SFIELD_TEXEL(i)                // texel i of sky, entities and rotations
#endif
#ifndef SFIELD_ROTATION
#define SFIELD_ROTATION(i) SFIELD_MOVING(i)             // texel i of a rotation
#endif
#define SFIELD_COEFS (SFIELD_BANDS * SFIELD_BANDS)
#define SFIELD_CELLS ((SFIELD_COEFS + 15) / 16)         // texels of a sample and channel
#define SFIELD_NONE 0xffffffffu                         // no texel: of a rotation, of a field
#define SFIELD_PI 3.14159265
#define SFIELD_Y00 0.282094792

// The eight samples round a point are first, first + 1, + side, + side + 1 on the inner shell, and 6 side^2
// more on the outer shell.
struct sfield_place {
    uint first;             // number of the first sample
    uint shell;             // number of the inner shell
    vec4 corner;            // weights of the four samples on a shell
    vec2 weight;            // of the inner and of the outer shell, which falls beyond the last shell
};

// Returns 4/pi atan u for |u| <= 1, off by 6e-6, since nodes of the grid of positions lie at equal angles.
float sfield_warp(float u)
{
    float z = u * u;
    float p = 0.0946681494 + z * (-0.0487783181 + z * 0.0127531015);
    return u + u * (1.0 - z) * (0.273219633 + z * (-0.150161507 + z * p));
}

// Returns the measure of a distance, squared, in which weights between shells are linear. Bit 1 of how says
// that the field is a source, bit 2 that shells are uniform.
float sfield_measure(float d2, uint how)
{
    float inverse = 1.0 / d2, u = min(inverse, 1.0);
    if ((how & 2u) != 0u) return -sqrt(d2);
    return (how & 1u) != 0u || d2 < 1.0 ? inverse : u / (1.0 + sqrt(1.0 - u));
}

// Finds the samples round p, which is in the field's space, about its centre, in radii.
sfield_place sfield_locate(uint field, vec3 p)
{
    uvec4 head = SFIELD_TEXEL(field);                   // how, frames, shells, side
    vec3 a = abs(p);
    float m = max(max(a.x, a.y), a.z), d2 = dot(p, p), inverse = 1.0 / max(m, 1e-20);
    bool on_x = m == a.x, on_y = m == a.y && !on_x;
    uint face = on_x ? (p.x > 0.0 ? 0u : 1u) : on_y ? (p.y > 0.0 ? 2u : 3u) : p.z > 0.0 ? 4u : 5u;
    float s = on_x ? (p.x > 0.0 ? -p.z : p.z) : on_y ? p.x : p.z > 0.0 ? p.x : -p.x;
    float t = on_y ? (p.y > 0.0 ? p.z : -p.z) : -p.y;
    vec2 grid = (vec2(sfield_warp(s * inverse), sfield_warp(t * inverse)) + 1.0) * (0.5 * float(head.w - 1u));
    uvec2 at = uvec2(min(grid, vec2(float(head.w) - 1.5)));
    vec2 f = grid - vec2(at);
    uint low = 0u, high = head.z - 1u;                  // at most the last shell but one
    while (high - low > 1u) {
        uint middle = (low + high) >> 1;
        if (uintBitsToFloat(SFIELD_TEXEL(field + 3u + middle).x) <= d2) low = middle;
        else high = middle;
    }
    vec2 inner = uintBitsToFloat(SFIELD_TEXEL(field + 3u + low).xy);
    vec2 outer = uintBitsToFloat(SFIELD_TEXEL(field + 4u + low).xy);
    float last = uintBitsToFloat(SFIELD_TEXEL(field + 2u + head.z).x), q = max(d2, 1e-12);
    float w = clamp((sfield_measure(q, head.x) - outer.y) / (inner.y - outer.y), 0.0, 1.0);
    sfield_place place;
    place.first = ((low * 6u + face) * head.w + at.y) * head.w + at.x;
    place.shell = low;
    place.corner = vec4((1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y);
    place.weight = vec2(w, (1.0 - w) * min(last / q, 1.0));
    return place;
}

// Returns the four bytes of a word.
vec4 sfield_bytes(uint word)
{
    return vec4(float(word & 255u), float((word >> 8) & 255u), float((word >> 16) & 255u), float(word >> 24));
}

// Adds weight x the four samples from `first` on to v. `group` is the number of their scales.
void sfield_mix(uint field, uint first, uint group, uint channel, vec4 corner, float weight,
                inout float v[SFIELD_COEFS])
{
    uvec4 parts = SFIELD_TEXEL(field + 1u);             // channels, scales, samples
    uint side = SFIELD_TEXEL(field).w, cells = uint(SFIELD_CELLS), step = parts.x * cells;
    uint from = field + parts.z + first * step + channel * cells;
    uint scale = field + parts.y + (group * parts.x + channel) * 8u * cells;
    for (int cell = 0; cell < SFIELD_CELLS; cell++, from++) {
        uvec4 a = SFIELD_TEXEL(from), b = SFIELD_TEXEL(from + step);
        uvec4 c = SFIELD_TEXEL(from + side * step), d = SFIELD_TEXEL(from + (side + 1u) * step);
        for (int word = 0; word < 4; word++) {
            uint at = scale + uint(4 * cell + word);
            vec4 q = corner.x * sfield_bytes(a[word]) + corner.y * sfield_bytes(b[word]) +
                     corner.z * sfield_bytes(c[word]) + corner.w * sfield_bytes(d[word]);
            vec4 scales = uintBitsToFloat(SFIELD_TEXEL(at));
            vec4 biases = uintBitsToFloat(SFIELD_TEXEL(at + 4u * cells));
            q = weight * (q * scales + biases);
            for (int i = 0; i < 4; i++)
                if (16 * cell + 4 * word + i < SFIELD_COEFS) v[16 * cell + 4 * word + i] += q[i];
        }
    }
}

// Finds the frames of a field before and after a time in seconds, and returns how far it lies between them.
float sfield_frames(uint field, float time, out uint before, out uint after)
{
    uvec4 head = SFIELD_TEXEL(field);
    before = after = 0u;
    if (head.y < 2u) return 0.0;
    float n = float(head.y), t = time * uintBitsToFloat(SFIELD_TEXEL(field + 2u).x);
    bool loop = (head.x & 4u) != 0u;
    if (loop) t = clamp(t, -1e7, 1e7) - n * floor(clamp(t, -1e7, 1e7) / n);
    t = max(t, 0.0);
    t = t < n ? t : loop ? 0.0 : n;
    before = min(uint(t), head.y - 1u);
    after = before + 1u < head.y ? before + 1u : loop ? 0u : before;
    return t - float(before) < 1.0 ? t - float(before) : 0.0;
}

// Writes one channel of a field, times weight: the hidden share, or radiance at a time in seconds. Here as
// below, loops with large bodies end at numbers that compilers do not know, lest they unroll the loops and
// take seconds.
void sfield_fetch(uint field, sfield_place at, uint channel, float time, float weight,
                  out float v[SFIELD_COEFS])
{
    uvec4 head = SFIELD_TEXEL(field);
    uint before, after, shell = 6u * head.w * head.w;
    for (int k = 0; k < SFIELD_COEFS; k++) v[k] = 0.0;
    float t = sfield_frames(field, time, before, after);
    for (uint i = 0u; i < (t > 0.0 ? 4u : 2u); i++) {   // two shells of the frame before, then of that after
        uint frame = (i < 2u ? before : after) * head.z, outer = i & 1u;
        float w = weight * (i < 2u ? 1.0 - t : t) * (outer == 0u ? at.weight.x : at.weight.y);
        if (w != 0.0)
            sfield_mix(field, (frame + outer) * shell + at.first, frame + at.shell + outer, channel,
                       at.corner, w, v);
    }
}

// ---- algebra ----

// Turns a function of direction by a rotation of the table, or back. The rotation has the rows of each band,
// from band 1 on, each filled up to a multiple of four numbers.
void sfield_rotate(uint rotation, bool back, inout float v[SFIELD_COEFS])
{
    uint row = rotation;
    for (int l = 1; l < SFIELD_BANDS; l++) {
        float sum[2 * SFIELD_BANDS];
        int n = 2 * l + 1, first = l * l;
        for (int x = 0; x < n; x++) sum[x] = 0.0;
        for (int y = 0; y < n; y++) {
            vec4 m = vec4(0.0);
            for (int x = 0; x < n; x++) {
                if (x % 4 == 0) m = uintBitsToFloat(SFIELD_ROTATION(row++));
                if (back) sum[x] += m[x % 4] * v[first + y];
                else sum[y] += m[x % 4] * v[first + x];
            }
        }
        for (int x = 0; x < n; x++) v[first + x] = sum[x];
    }
}

// Returns the product a b, projected on the basis, by terms.y pairs of tripling coefficients from texel
// terms.x on. Each coefficient is i | j << 8 | k << 16, and c. The pairs are taken in fours, since software
// drivers end an invocation's loops after 65535 rounds in all. With SFIELD_UNROLLED the program has this
// function with its numbers in the text (glbk_sfield_write_product).
#ifndef SFIELD_UNROLLED
void sfield_product(uvec2 terms, float a[SFIELD_COEFS], float b[SFIELD_COEFS], out float r[SFIELD_COEFS])
{
    r[0] = a[0] * b[0];
    for (int k = 1; k < SFIELD_COEFS; k++) {
        r[0] += a[k] * b[k];
        r[k] = SFIELD_Y00 * (a[0] * b[k] + a[k] * b[0]);
    }
    r[0] *= SFIELD_Y00;
    for (uint e = 0u; e < terms.y; e += 4u)
        for (uint of = 0u; of < 4u; of++) {
            uvec4 two = SFIELD_TEXEL(terms.x + e + of);
            for (int h = 0; h < 2; h++) {
                uint which = h == 0 ? two.x : two.z, i = which & 255u, j = (which >> 8) & 255u;
                r[which >> 16] += uintBitsToFloat(h == 0 ? two.y : two.w) * (a[i] * b[j] + a[j] * b[i]);
            }
        }
}
#endif

// Writes the basis at a unit direction.
void sfield_basis(vec3 d, out float y[SFIELD_COEFS])
{
    float c = 1.0, s = 0.0, diagonal = SFIELD_Y00;
    for (int m = 0; m < SFIELD_BANDS; m++) {
        float older = 0.0, now = m > 0 ? 1.41421356 * diagonal : diagonal, fm = float(m);
        for (int l = m; l < SFIELD_BANDS; l++) {
            float fl = float(l), back = l > 0 ? sqrt((fl * fl - fm * fm) / (4.0 * fl * fl - 1.0)) : 0.0;
            float a = sqrt((4.0 * (fl + 1.0) * (fl + 1.0) - 1.0) / ((fl + 1.0) * (fl + 1.0) - fm * fm));
            float next = a * (d.z * now - back * older);
            y[l * l + l - m] = now * s;
            y[l * l + l + m] = now * c;
            older = now;
            now = next;
        }
        diagonal *= sqrt((2.0 * fm + 3.0) / (2.0 * fm + 2.0));
        float turned = c * d.x - s * d.y;
        s = c * d.y + s * d.x;
        c = turned;
    }
}

// Writes max(0, cosine) about a unit normal: T of a point that its own object does not shadow.
void sfield_cosine(vec3 n, out float t[SFIELD_COEFS])
{
    const float a[8] =
        float[8](3.14159265, 2.09439510, 0.785398163, 0.0, -0.130899694, 0.0, 0.0490873852, 0.0);
    sfield_basis(n, t);
    for (int l = 0; l < SFIELD_BANDS; l++)
        for (int k = l * l; k < (l + 1) * (l + 1); k++) t[k] *= a[l];
}

// Writes Phong's lobe, (n + 2) / 2 pi cos^n about the mirrored view, with n in 1..1000.
void sfield_lobe(vec3 mirrored, float n, out float t[SFIELD_COEFS])
{
    float before = (n + 2.0) / (n + 1.0), now = 1.0;
    sfield_basis(mirrored, t);
    t[0] *= before;
    for (int l = 1; l < SFIELD_BANDS; l++) {
        for (int k = l * l; k < (l + 1) * (l + 1); k++) t[k] *= now;
        float next = before * (n - float(l) + 1.0) / (n + float(l) + 2.0);
        before = now;
        now = next;
    }
}

// Returns the integral of a b over all directions.
float sfield_dot(float a[SFIELD_COEFS], float b[SFIELD_COEFS])
{
    float sum = 0.0;
    for (int k = 0; k < SFIELD_COEFS; k++) sum += a[k] * b[k];
    return sum;
}
