/* ---- numbers: what lights and materials share ---- */

LSAMP_DEF const char *lsamp_result_text(lsamp_result result)
{
    switch (result) {
#define LSAMP__TEXT(name, text) case name: return text;
    LSAMP_RESULTS(LSAMP__TEXT)
#undef LSAMP__TEXT
    default: return "unknown result";
    }
}

#define LSAMP__PI 3.14159265f
#define LSAMP__BELOW_1 0.99999994f

static float lsamp__mean3(lsamp__v3 c) { return (c.x + c.y + c.z) * (1.0f / 3.0f); }
static float lsamp__clamp_unit(float u) { return u > 0.0f ? u < LSAMP__BELOW_1 ? u : LSAMP__BELOW_1 : 0.0f; }
static float lsamp__safe_sqrt(float x) { return x > 0.0f ? sqrtf(x) : 0.0f; }

/* Returns t w.x + b w.y + n w.z. */
static lsamp__v3 lsamp__from_axes(lsamp__v3 t, lsamp__v3 b, lsamp__v3 n, lsamp__v3 w)
{
    return lsamp__v3_madd(lsamp__v3_madd(lsamp__v3_scale(t, w.x), b, w.y), n, w.z);
}

/* Does the inverse of lsamp__concentric. */
static void lsamp__disc_square(float x, float y, float *u, float *v)
{
    float r = sqrtf(x * x + y * y), a, b;
    if (fabsf(x) > fabsf(y)) {
        a = x > 0.0f ? r : -r;
        b = a * (4.0f / LSAMP__PI) * lsamp__atan2(y / x, 1.0f);
    } else {
        b = y > 0.0f ? r : -r;
        a = r > 0.0f ? b * (4.0f / LSAMP__PI) * lsamp__atan2(x / y, 1.0f) : 0.0f;
    }
    *u = lsamp__clamp_unit(0.5f * (a + 1.0f));
    *v = lsamp__clamp_unit(0.5f * (b + 1.0f));
}

/* Says whether three floats are numbers within low..high. */
static int lsamp__in3(const float *p, float low, float high)
{
    int i;
    for (i = 0; i < 3; i++)
        if (!lsamp__finite(p[i]) || p[i] < low || p[i] > high) return 0;
    return 1;
}

static int lsamp__is_unit(const float *p)
{
    lsamp__v3 v = lsamp__v3_load(p);
    return lsamp__v3_finite(v) && lsamp__is_unit2(lsamp__v3_dot(v, v));
}

static lsamp__logger lsamp__logger_of(const lsamp_system *s, const char *function)
{
    lsamp__logger log;
    log.log = s->log;
    log.user = s->user;
    log.function = function;
    return log;
}
