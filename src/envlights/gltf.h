/* ---- gltf: text without the C library, whose numbers depend on the locale ---- */

/* A text that is written, or only measured: length goes on where size ends. */
typedef struct envlt__text { char *out; size_t size, length; } envlt__text;

static void envlt__put_text(envlt__text *t, const char *s)
{
    for (; *s; s++, t->length++)
        if (t->length + 1 < t->size) t->out[t->length] = *s;
}

static void envlt__put_unsigned(envlt__text *t, uint32_t v)
{
    char digits[11];
    int n = 10;
    digits[n] = 0;
    do {
        digits[--n] = (char)('0' + v % 10u);
        v /= 10u;
    } while (v);
    envlt__put_text(t, digits + n);
}

/* Writes a number with nine significant digits, from which the same float can be read back. JSON has no word
   for infinity and NaN, which are written as 0. */
static void envlt__put_float(envlt__text *t, float f)
{
    double v = (double)f;
    int exponent = 0;
    char one[2] = { 0, 0 };
    uint32_t digits, scale;
    if (v < 0.0 && envlt__finite(f)) {
        envlt__put_text(t, "-");
        v = -v;
    }
    if (!(v > 0.0) || !envlt__finite(f)) {
        envlt__put_text(t, "0");
        return;
    }
    while (v >= 999999999.5) {
        v /= 10.0;
        exponent++;
    }
    while (v < 99999999.95) {
        v *= 10.0;
        exponent--;
    }
    digits = (uint32_t)(v + 0.5);
    if (digits > 999999999u) digits = 999999999u;
    exponent += 8;
    for (scale = 100000000u; scale; scale /= 10u) {
        one[0] = (char)('0' + digits / scale % 10u);
        envlt__put_text(t, one);
        if (scale == 100000000u) envlt__put_text(t, ".");
    }
    envlt__put_text(t, exponent < 0 ? "e-" : "e");
    envlt__put_unsigned(t, (uint32_t)(exponent < 0 ? -exponent : exponent));
}

static void envlt__put_floats(envlt__text *t, const float *v, int n)
{
    int i;
    envlt__put_text(t, "[");
    for (i = 0; i < n; i++) {
        if (i) envlt__put_text(t, ",");
        envlt__put_float(t, v[i]);
    }
    envlt__put_text(t, "]");
}

/* Writes a node. A light of glTF shines along the -Z of its node, so the node's rotation, a quaternion x y z
   w, is the shortest turn that brings +Z to the light's direction. */
static void envlt__put_node(envlt__text *t, const envlt_light *l, uint32_t i)
{
    envlt__v3 d = envlt__v3_load(l->direction);
    float q[4], length;
    q[0] = -d.y;
    q[1] = d.x;
    q[2] = 0.0f;
    q[3] = 1.0f + d.z;
    if (!(q[3] > 1e-6f)) {
        q[0] = 1.0f;
        q[1] = q[2] = q[3] = 0.0f;
    }
    length = sqrtf(q[0] * q[0] + q[1] * q[1] + q[3] * q[3]);
    q[0] /= length;
    q[1] /= length;
    q[3] /= length;
    envlt__put_text(t, i ? ",\n" : "\n");
    envlt__put_text(t, "{\"rotation\":");
    envlt__put_floats(t, q, 4);
    envlt__put_text(t, ",\"extensions\":{\"KHR_lights_punctual\":{\"light\":");
    envlt__put_unsigned(t, i);
    envlt__put_text(t, "}}}");
}

static void envlt__put_light(envlt__text *t, const envlt_light *l, uint32_t i)
{
    float color[3], most = l->irradiance[0];
    int c;
    for (c = 1; c < 3; c++)
        if (l->irradiance[c] > most) most = l->irradiance[c];
    for (c = 0; c < 3; c++) color[c] = most > 0.0f ? l->irradiance[c] / most : 1.0f;
    envlt__put_text(t, i ? ",\n" : "\n");
    envlt__put_text(t, "{\"type\":\"directional\",\"color\":");
    envlt__put_floats(t, color, 3);
    envlt__put_text(t, ",\"intensity\":");
    envlt__put_float(t, most);
    envlt__put_text(t, "}");
}

static void envlt__put_document(envlt__text *t, const envlt_light *lights, uint32_t count)
{
    uint32_t i;
    envlt__put_text(t, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"envlights.h\"}");
    if (count) {
        envlt__put_text(t, ",\n\"extensionsUsed\":[\"KHR_lights_punctual\"],\n"
                       "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[");
        for (i = 0; i < count; i++) envlt__put_light(t, &lights[i], i);
        envlt__put_text(t, "]}},\n\"nodes\":[");
        for (i = 0; i < count; i++) envlt__put_node(t, &lights[i], i);
        envlt__put_text(t, "],\n\"scene\":0,\"scenes\":[{\"nodes\":[");
        for (i = 0; i < count; i++) {
            if (i) envlt__put_text(t, ",");
            envlt__put_unsigned(t, i);
        }
        envlt__put_text(t, "]}]");
    }
    envlt__put_text(t, "}\n");
}

ENVLT_DEF size_t envlt_gltf_bytes(const envlt_light *lights, uint32_t count)
{
    envlt__text t;
    if (!lights) return 0;
    memset(&t, 0, sizeof t);
    envlt__put_document(&t, lights, count);
    return t.length + 1;
}

ENVLT_DEF envlt_result envlt_gltf_write(const envlt_light *lights, uint32_t count, char *text, size_t bytes)
{
    envlt__text t;
    if (!lights || !text) return ENVLT_ERR_ARGUMENT;
    if (!envlt__directions_fit(lights, count)) return ENVLT_ERR_INPUT;
    if (bytes < envlt_gltf_bytes(lights, count)) return ENVLT_ERR_MEMORY;
    t.out = text;
    t.size = bytes;
    t.length = 0;
    envlt__put_document(&t, lights, count);
    text[t.length] = 0;
    return ENVLT_OK;
}
