/* layout_test - a query as docs/gpu-layouts.md describes it, step by step and from nothing else, on blocks of every
   domain, order and orientation: its answers are those of csm.h. Who changes one changes the other. */
#include "csm.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "util.h"

enum { COUNT = 3000 };
enum { LATLONG = 1, OCTAHEDRAL, DISC = 5, SPHERE };
enum { ZIGZAG = 2, ZIGZAG_THETA, HILBERT };
enum { POLAR = 1, MINIMAL };
enum { LIT = 1, DARK = 0, REFUSED = -1 };

typedef struct block {
    const uint32_t *w;
    uint32_t order_at, locations_at, lookup_at, directories_at, lines_at, bases_at, trays_at;
    uint32_t side[3], count, size, dimensions, c[3];
} block;

static float real(const block *b, uint32_t word)
{
    float x;
    memcpy(&x, b->w + word, 4);
    return x;
}

static uint32_t half_word(const uint32_t *run, uint32_t i) { return run[i / 2] >> 16 * (i % 2) & 0xffff; }

static uint32_t bits(const uint32_t *run, uint32_t at, uint32_t count)
{
    uint32_t x = 0, i;
    for (i = 0; i < count; i++) x |= (run[(at + i) / 32] >> (at + i) % 32 & 1) << i;
    return x;
}

static float dot(const float *a, const float *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* ---- step 1 ---- */

static block open_block(const void *data)
{
    block b;
    int k;
    memset(&b, 0, sizeof b);
    b.w = (const uint32_t *)data;
    for (k = 0; k < 3; k++) b.side[k] = b.w[8 + k];
    b.count = b.w[11];
    b.size = b.w[13];
    b.dimensions = b.w[15];
    b.order_at = 96;
    b.locations_at = b.order_at + b.w[20];
    b.lookup_at = b.locations_at + b.w[21];
    b.directories_at = b.lookup_at + b.w[22];
    b.lines_at = b.directories_at + b.w[23];
    if (b.w[17] & 2) b.lines_at = (b.locations_at + b.w[21] + 15) & ~15u;
    b.bases_at = b.lines_at + b.w[22];
    b.trays_at = b.bases_at + b.w[23];
    return b;
}

/* ---- step 3 ---- */

static float page_acos(float x)
{
    float a = fminf(fabsf(x), 1), h = (1 - a) / 2, s = a > 0.5f ? sqrtf(h) : a, z = a > 0.5f ? h : a * a;
    float r = s + s * z * (0.1666675393f + z * (0.07495241769f + z * (0.04547709903f + z * (0.02414760004f +
              z * 0.04221856856f))));
    r = a > 0.5f ? 2 * r : 1.57079633f - r;
    return x < 0 ? 3.14159265f - r : r;
}

static float page_atan2(float y, float x)
{
    float hi = fmaxf(fabsf(x), fabsf(y)), a = hi > 0 ? fminf(fabsf(x), fabsf(y)) / hi : 0;
    float t = a > 0.414213562f ? (a - 1) / (a + 1) : a, z = t * t;
    float r = t + t * z * (-0.3333295525f + z * (0.1997792608f + z * (-0.1387984996f + z * 0.08060308882f)));
    if (a > 0.414213562f) r = 0.785398163f + r;
    if (fabsf(y) > fabsf(x)) r = 1.57079633f - r;
    if (copysignf(1, x) < 0) r = 3.14159265f - r;
    return copysignf(r, y);
}

static void cell_of(block *b, const float *s)
{
    int k;
    for (k = 0; k < 3; k++) {
        b->c[k] = (uint32_t)fmaxf(s[k] * (float)b->side[k], 0);
        if (b->c[k] >= b->side[k]) b->c[k] = b->side[k] - 1;
    }
    if ((b->w[4] == LATLONG || b->w[4] == SPHERE) && s[0] * (float)b->side[0] >= (float)b->side[0]) b->c[0] = 0;
}

static void cell_of_direction(block *b, const float *v)
{
    float s[3] = { 0, 0, 0 }, length = sqrtf(dot(v, v)), d[3];
    int k;
    for (k = 0; k < 3; k++) d[k] = v[k] / length;
    if (b->w[4] == LATLONG) {
        s[0] = 0.5f + page_atan2(v[2], v[0]) * 0.159154943f;
        s[1] = page_acos(v[1] / length) * 0.318309886f;
    } else {
        float r = sqrtf((d[0] * d[0] + d[2] * d[2]) / (1 + fabsf(d[1])));
        float y = r * 0.636619772f * page_atan2(fabsf(d[2]), fabsf(d[0])), x = r - y, old = x;
        if (d[1] < 0) {
            x = 1 - y;
            y = 1 - old;
        }
        s[0] = (d[0] < 0 ? 1 - x : 1 + x) / 2;
        s[1] = (d[2] < 0 ? 1 - y : 1 + y) / 2;
    }
    cell_of(b, s);
}

/* ---- step 4 ---- */

static uint32_t place_of(const block *b)
{
    const uint32_t *c = b->c, *n = b->side;
    uint32_t cell = c[0] + n[0] * (c[1] + n[1] * c[2]), line;
    if (b->w[6] == ZIGZAG) {
        line = n[1] * c[2] + (c[2] % 2 ? n[1] - 1 - c[1] : c[1]);
        return line * n[0] + (line % 2 ? n[0] - 1 - c[0] : c[0]);
    }
    if (b->w[6] == ZIGZAG_THETA) {
        line = n[0] * c[2] + (c[2] % 2 ? n[0] - 1 - c[0] : c[0]);
        return line * n[1] + (line % 2 ? n[1] - 1 - c[1] : c[1]);
    }
    if (b->w[6] != HILBERT) return cell;
    return b->count <= 65536 ? half_word(b->w + b->order_at, cell) : b->w[b->order_at + cell];
}

/* ---- step 5 ---- */

static void middle_of(const block *b, float *u)
{
    int k;
    for (k = 0; k < 3; k++) u[k] = ((float)b->c[k] + 0.5f) / (float)b->side[k];
}

static void back_of(const block *b, float *back)
{
    const float pi = 3.14159265f;
    float u[3];
    middle_of(b, u);
    if (b->w[4] == LATLONG) {
        float f = 2 * pi * (u[0] - 0.5f);
        back[0] = sinf(pi * u[1]) * cosf(f);
        back[1] = cosf(pi * u[1]);
        back[2] = sinf(pi * u[1]) * sinf(f);
    } else {
        float x = 2 * u[0] - 1, y = 2 * u[1] - 1, e = 1 - fabsf(x) - fabsf(y), r = 1 - fabsf(e);
        float g = r > 0 ? ((fabsf(y) - fabsf(x)) / r + 1) * pi / 4 : 0, h = r * sqrtf(2 - r * r);
        back[0] = copysignf(h * cosf(g), x);
        back[1] = copysignf(1 - r * r, e);
        back[2] = copysignf(h * sinf(g), y);
    }
}

/* px, py and depth */
static void project(const block *b, const float *p, float bias, float *seen)
{
    float back[3], right[3], up[3], m = (float)b->size, x, y, z, s, a;
    back_of(b, back);
    x = back[0];
    y = back[1];
    z = back[2];
    s = b->w[7] == MINIMAL || y >= 0 ? 1.0f : -1.0f;
    if (b->w[7] == POLAR) {
        float r = sqrtf(x * x + z * z);
        right[0] = r > 1e-6f ? -z / r : 0;
        right[1] = 0;
        right[2] = r > 1e-6f ? x / r : 1;
        up[0] = right[1] * z - right[2] * y;
        up[1] = right[2] * x - right[0] * z;
        up[2] = right[0] * y - right[1] * x;
    } else if (s + y < 1e-6f && s > 0) {
        memset(right, 0, sizeof right);
        memset(up, 0, sizeof up);
        right[0] = up[2] = 1;
    } else {
        a = -1 / (s + y);
        right[0] = 1 + s * x * x * a;
        right[1] = -s * x;
        right[2] = s * x * z * a;
        up[0] = x * z * a;
        up[1] = -z;
        up[2] = s + z * z * a;
    }
    seen[0] = m / 2 * dot(p, right) + m / 2;
    seen[1] = m / 2 * dot(p, up) + m / 2;
    seen[2] = 0.5f - 0.5f * dot(p, back) - bias / m;
}

/* ---- steps 6 to 8 ---- */

static uint32_t mark(const uint32_t *run, uint32_t at) { return bits(run, 16 + at, 1); }

static uint32_t depth_in_block(const block *b, const uint32_t *run, uint32_t view)
{
    uint32_t base = bits(run, 0, 8), k = bits(run, 8, 4), width = bits(run, 12, 4), n = 0, i, at = 0, j, zeros, x, g;
    uint32_t palette = width > 9, ones, codes, bucket = view >> k, low = view & ((1u << k) - 1), exact = 0;
    uint32_t top = (1u << b->w[14]) - 1;
    for (i = 0; i < 64; i++) n += mark(run, i);
    for (zeros = bucket; zeros; at++) zeros -= !mark(run, at);
    for (j = at - bucket; at < 64 && mark(run, at) && bits(run, 80 + j * k, k) <= low; at++) j++;
    j--;
    if (palette) width -= 9;
    ones = (1u << width) - 1;
    codes = 80 + n * k;
    x = bits(run, codes + j * width, width);
    if (x == ones) {
        for (i = 0; i < j; i++) exact += bits(run, codes + i * width, width) == ones;
        return bits(run, codes + n * width + (palette ? 8 * base : 0) + 16 * exact, 16);
    }
    if (!palette && x == ones - 1) return 65535;
    g = palette ? bits(run, codes + n * width + 8 * x, 8) : base + x;
    return g >= top ? 65535 : g * 65535 / top;
}

static uint32_t stored_depth(const block *b, uint32_t pixel, uint32_t place)
{
    uint32_t entry = b->w[b->lookup_at + (place >> 16) * (b->w[19] - b->w[18]) + pixel], view = place & 0xffff, k;
    const uint32_t *d = b->w + b->directories_at + entry;
    uint32_t count, last = 0, line;
    if (entry >> 31) return entry & 0xffff;
    count = d[1] & 0xffff;
    for (k = 1; k < count && half_word(d, k + 3) <= view; k++) last = k;
    if (last) view -= half_word(d, last + 3);
    line = last == count - 1 ? 16 * (d[0] - (d[1] >> 20)) + (d[1] >> 16 & 15) : 16 * (d[0] + last);
    return depth_in_block(b, b->w + b->lines_at + line, view);
}

/* ---- steps 6 to 8 in the fast layout ---- */

static uint32_t stored_depth_fast(const block *b, uint32_t pixel, uint32_t place)
{
    const uint32_t pixels = b->w[19] - b->w[18], bucket = place >> 8, v = place & 255, top = (1u << b->w[14]) - 1;
    const uint8_t *lines = (const uint8_t *)(b->w + b->lines_at), *tray, *other;
    uint32_t line = b->w[b->bases_at + bucket * ((pixels + 255) >> 8) + (pixel >> 8)], split, first, n, j = 0, e = 0, i;
    uint16_t a;
    memcpy(&a, (const uint16_t *)(b->w + b->trays_at) + bucket * pixels + pixel, sizeof a);
    split = (uint32_t)a >> 14;
    first = a & 0x3fffu;
    tray = lines + 64 * (size_t)line + 2 * first;
    if (split) tray = lines + 64 * ((size_t)line + first + (v >> (8 - split)));
    n = tray[0];
    for (i = 1; i <= n; i++) j += tray[i] <= v;
    if (tray[1 + n + j] != 254) return tray[1 + n + j] >= top ? 65535 : tray[1 + n + j] * 65535u / top;
    for (i = 0; i < j; i++) e += tray[1 + n + i] == 254;
    other = n == 31 ? tray + 64 * (size_t)tray[1] + 2 * (v & 31) : tray + 2 + 2 * n + 2 * e;
    return other[0] | (uint32_t)other[1] << 8;
}

/* ---- steps 5 and 9, of what was seen ---- */

static int compared(const block *b, const float *seen, uint32_t place)
{
    float m = (float)b->size;
    uint32_t q, pixel;
    if (!(seen[0] >= 0 && seen[0] < m && seen[1] >= 0 && seen[1] < m && seen[2] >= 0)) return LIT;
    q = seen[2] * 65533 < 65535 ? (uint32_t)(65533 * seen[2]) : 65535;
    pixel = (uint32_t)seen[1] * b->size + (uint32_t)seen[0];
    if (pixel < b->w[18] || pixel >= b->w[19]) return LIT;
    pixel -= b->w[18];
    return q > (b->w[17] & 2 ? stored_depth_fast(b, pixel, place) : stored_depth(b, pixel, place)) ? DARK : LIT;
}

/* ---- local and semi-local lights ---- */

static void location_of(const block *b, float *out)
{
    const float pi = 3.14159265f;
    float s[3], f = 0, y = 0;
    int k;
    middle_of(b, s);
    if (b->w[4] == DISC) {
        float a = 2 * s[0] - 1, t = 2 * s[1] - 1, r = fabsf(a) > fabsf(t) ? a : t;
        float g = fabsf(a) > fabsf(t) ? t / a * pi / 4 : fabsf(t) > 0 ? pi / 2 - a / t * pi / 4 : 0;
        s[0] = r * cosf(g);
        s[1] = r * sinf(g);
        s[2] = 0;
    }
    if (b->w[4] == SPHERE) {
        float u[3] = { real(b, 36), real(b, 37), real(b, 38) }, length = sqrtf(dot(u, u));
        y = 1 - 2 * s[1];
        f = 2 * pi * (s[0] - 0.5f);
        out[0] = real(b, 33) + length * sqrtf(1 - y * y) * cosf(f);
        out[1] = real(b, 34) + length * y;
        out[2] = real(b, 35) + length * sqrtf(1 - y * y) * sinf(f);
        return;
    }
    for (k = 0; k < 3; k++)
        out[k] = real(b, 33 + (uint32_t)k) + s[0] * real(b, 36 + (uint32_t)k) + s[1] * real(b, 39 + (uint32_t)k) +
                 s[2] * real(b, 42 + (uint32_t)k);
}

static int local(block *b, const float *p, const float *light, float bias)
{
    float at[3], e[3], seen[3], f, m = (float)b->size;
    uint32_t axis = 0, face;
    int k;
    cell_of(b, light);
    location_of(b, at);
    for (k = 0; k < 3; k++) {
        e[k] = p[k] - (at[k] - real(b, 27 + (uint32_t)k)) / real(b, 30);
        if (fabsf(e[k]) > fabsf(e[axis])) axis = (uint32_t)k;
    }
    face = 2 * axis + (e[axis] < 0);
    f = fabsf(e[axis]);
    for (k = 0; k < 2; k++) {
        seen[k] = m / 2 * e[(axis + (uint32_t)k + 1) % 3] / f + m / 2;
        if (seen[k] >= m) seen[k] = m - 0.5f;
        if (seen[k] < 0) seen[k] = 0;
    }
    seen[2] = f * (1 - 2 * bias / m) * real(b, 30) / real(b, 31);
    return compared(b, seen, place_of(b) + face * b->count);
}

/* What the hull says, or 2: go on. */
static int hull(const block *b, const float *p, const float *light)
{
    static const float axes[13][3] = { { 1, 0, 0 }, { 0, 1, 0 },  { 0, 0, 1 }, { 1, 1, 0 },  { 1, -1, 0 },
                                       { 1, 0, 1 }, { 1, 0, -1 }, { 0, 1, 1 }, { 0, 1, -1 }, { 1, 1, 1 },
                                       { 1, 1, -1 }, { 1, -1, 1 }, { -1, 1, 1 } };
    float center[3] = { real(b, 27), real(b, 28), real(b, 29) }, radius = real(b, 30), enter = 0, leave = 1;
    int inside = 1, miss = 0;
    uint32_t i;
    for (i = 0; i < 13; i++) {
        float least = (real(b, 45 + 2 * i) - dot(axes[i], center)) / radius;
        float most = (real(b, 46 + 2 * i) - dot(axes[i], center)) / radius;
        float from = dot(axes[i], p), to = dot(axes[i], light), t0, t1;
        inside = inside && least <= to && to <= most;
        if (!(fabsf(to - from) > 0)) {
            miss = miss || from < least || from > most;
            continue;
        }
        t0 = (least - from) / (to - from);
        t1 = (most - from) / (to - from);
        enter = fmaxf(enter, fminf(t0, t1));
        leave = fminf(leave, fmaxf(t0, t1));
    }
    return inside ? REFUSED : miss || enter > leave ? LIT : 2;
}

static int answer(block *b, cohsm_light_kind kind, const float *point, const float *light, float bias)
{
    float p[3], l[3], seen[3];
    int k;
    for (k = 0; k < 3; k++) p[k] = (point[k] - real(b, 27 + (uint32_t)k)) / real(b, 30);        /* step 2 */
    if (kind == COHSM_LIGHT_PARAMETER) return local(b, p, light, bias);
    memcpy(l, light, sizeof l);
    if (kind == COHSM_LIGHT_POSITION) {
        int known;
        for (k = 0; k < 3; k++) l[k] = (light[k] - real(b, 27 + (uint32_t)k)) / real(b, 30);
        known = hull(b, p, l);
        if (known != 2) return known;
        for (k = 0; k < 3; k++) l[k] -= p[k];
    }
    cell_of_direction(b, l);
    project(b, p, bias, seen);
    return compared(b, seen, place_of(b));
}

/* ---- the tests ---- */

typedef struct tally { unsigned asked, differ, dark, refused; } tally;

static void ask(const cohsm_maps *maps, cohsm_light_kind kind, float bias, uint64_t *seed, tally *t)
{
    static float points[COUNT][3], lights[COUNT][3], expected[COUNT];
    cohsm_query q = { 0 };
    cohsm_info info;
    size_t size;
    block b = open_block(cohsm_data(maps, &size)), fast = open_block(cohsm_fast_data(maps, &size));
    int i, k;
    cohsm_get_info(maps, &info);
    for (i = 0; i < COUNT; i++) {
        rnd_direction(seed, lights[i]);
        for (k = 0; k < 3; k++) {
            points[i][k] = info.center[k] + info.radius * (float)rnd_in(seed, -1.1, 1.1);
            if (kind == COHSM_LIGHT_POSITION)
                lights[i][k] = info.center[k] + 3 * info.radius * lights[i][k] * (float)rnd(seed);
            if (kind == COHSM_LIGHT_PARAMETER) lights[i][k] = (float)rnd(seed);
        }
    }
    q.positions = points[0];
    q.lights = lights[0];
    q.light_stride = sizeof lights[0];
    q.count = COUNT;
    q.light_kind = kind;
    q.bias = bias > 0 ? bias : -1;
    assert_int_equal(cohsm_visible(maps, &q, expected, NULL), COHSM_OK);
    for (i = 0; i < COUNT; i++) {
        int found = answer(&b, kind, points[i], lights[i], bias);
        assert_int_equal(answer(&fast, kind, points[i], lights[i], bias), found);
        t->differ += fabsf((float)found - expected[i]) > 0;
        t->dark += found == DARK;
        t->refused += found == REFUSED;
    }
    t->asked += COUNT;
}

/* Depths of trays that are split, spread and full of exact ones, read by the page. */
static void the_page_reads_every_tray(void **state)
{
    cohsm_maps *maps = torture_maps(COHSM_LAYOUT_FAST);
    static uint16_t wanted[256];
    size_t size;
    block b = open_block(cohsm_fast_data(maps, &size));
    uint32_t view, pixel;
    (void)state;
    assert_int_equal(size, 4 * (size_t)b.w[2]);
    for (view = 0; view < b.count; view++) {                /* the order is SCANLINE: a view is its place */
        assert_int_equal(cohsm_depths(maps, view, wanted), COHSM_OK);
        for (pixel = 0; pixel < 256; pixel++) assert_int_equal(stored_depth_fast(&b, pixel, view), wanted[pixel]);
    }
    cohsm_free(maps);
}

/* Roundings at the border of a map, a pixel or a depth may differ: the page fixes no order of sums. */
static void the_page_answers_as_the_header(void **state)
{
    tally sum = { 0, 0, 0, 0 };
    uint64_t seed = 3;
    size_t i;
    (void)state;
    for (i = 0; i < sizeof csm_kinds / sizeof csm_kinds[0]; i++) {
        cohsm_desc d = desc_of(csm_kinds[i].domain, csm_kinds[i].side, i % 2 ? 48 : 31);
        model m = model_torus(24, 12, 1.0, 0.4);
        cohsm_mesh mesh = mesh_of(&m);
        cohsm_maps *maps = NULL;
        int local_light = csm_kinds[i].domain > COHSM_DOMAIN_OCTAHEDRAL;
        tally t = { 0, 0, 0, 0 };
        if (local_light) place_domain(&d, 1.6f, 0.9f, 0.3f, 0.5f);
        d.order = csm_kinds[i].order;
        d.orientation = csm_kinds[i].orientation;
        d.depth_bits = i % 3 == 1 ? 5 : 8;
        d.layout = COHSM_LAYOUT_FAST;
        assert_int_equal(cohsm_build(&d, &mesh, &maps, NULL), COHSM_OK);
        if (local_light)
            ask(maps, COHSM_LIGHT_PARAMETER, 1, &seed, &t);
        else {
            ask(maps, COHSM_LIGHT_DIRECTION, i % 2 ? 0.0f : 1.0f, &seed, &t);
            ask(maps, COHSM_LIGHT_POSITION, 1, &seed, &t);
        }
        if (t.differ * 1000 > t.asked || t.dark * 10 < t.asked)
            fail_msg("build %d: of %u answers %u differ, %u are dark", (int)i, t.asked, t.differ, t.dark);
        sum.asked += t.asked;
        sum.differ += t.differ;
        sum.dark += t.dark;
        sum.refused += t.refused;
        cohsm_free(maps);
        model_free(&m);
    }
    printf("%u queries by the page: %u differ, %u dark, %u refused\n", sum.asked, sum.differ, sum.dark, sum.refused);
    assert_true(sum.differ * 10000 <= sum.asked);
    assert_true(sum.refused * 100 > sum.asked);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(the_page_reads_every_tray),
                                        cmocka_unit_test(the_page_answers_as_the_header) };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
