/* stage.c - see stage.h: camera, G-buffer, backdrop, the mean over frames, the picture in the window, and handles. */
#include "stage.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979;
static const float  half_fov = 0.3f;        /* of the picture's height, radians */

/* Mixes the light of a frame, and of what lies behind the surfaces, into the mean of the frames before. The ground
   has an end: towards it it becomes the backdrop. */
static const char mix_text[] =
    "uniform glbk_color_sampler glbk_user0;\n"      /* light of this frame */
    "uniform glbk_color_sampler glbk_user1;\n"      /* the mean so far */
    "uniform sampler2D glbk_user2;\n"               /* the sky, latitude and longitude */
    "uniform mat4 clip_to_world;\n"
    "uniform vec4 eye;\n"                           /* w: share of this frame in the mean */
    "uniform vec4 ground;\n"                        /* its middle; w: where it ends */
    "uniform vec4 backdrop;\n"                      /* w: whether the sky itself is shown */
    "uniform vec4 size;\n"                          /* z: turn of the sky */
    "layout(location = 0) out glbk_color mean;\n"
    "void main()\n"
    "{\n"
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n"
    "    vec4 far = clip_to_world * vec4(2.0 * gl_FragCoord.xy / size.xy - 1.0, 1.0, 1.0);\n"
    "    vec3 d = normalize(far.xyz / far.w - eye.xyz);\n"
    "    vec2 uv = vec2(0.5 + (atan(d.z, d.x) + size.z) / 6.2831853, acos(clamp(d.y, -1.0, 1.0)) / 3.14159265);\n"
    "    vec3 sky = textureLod(glbk_user2, uv, 0.0).rgb;\n"
    "    vec3 behind = mix(backdrop.rgb * (0.9 + 0.25 * d.y), sky, backdrop.w);\n"
    "    vec3 light = behind;\n"
    "    glbk_point p;\n"
    "    if (glbk_read_point(at, p)) {\n"
    "        float end = p.plane == 0u ? 0.0 : smoothstep(0.35, 1.0, length(p.position - ground.xyz) / ground.w);\n"
    "        light = mix(glbk_unpack(texelFetch(glbk_user0, at, 0)).rgb, behind, end);\n"
    "    }\n"
    "    vec3 before = glbk_unpack(texelFetch(glbk_user1, at, 0)).rgb;\n"
    "    mean = glbk_pack(vec4(eye.w < 1.0 ? mix(before, light, eye.w) : light, 1.0));\n"
    "}\n";

/* Colours up to 0.6 as they are; the largest of r, g, b above it is bent towards 1, which it never reaches, and the
   further it was above 1 the more of the colour is white, as on film. Then sRGB; and dots where handles are that have
   one, as discs in the picture, hidden by what is nearer to the eye. */
static const char show_text[] =
    "uniform glbk_color_sampler glbk_user0;\n"
    "uniform float exposure;\n"
    "uniform vec4 eye;\n"
    "uniform vec4 dots[4];\n"                       /* x, y in pixels, radius in pixels, distance from the eye */
    "uniform vec4 colors[4];\n"
    "out vec4 shown;\n"
    "void main()\n"
    "{\n"
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n"
    "    vec3 c = exposure * glbk_unpack(texelFetch(glbk_user0, at, 0)).rgb;\n"
    "    glbk_point p;\n"
    "    float far = 1e30;\n"
    "    if (glbk_read_point(at, p)) far = length(p.position - eye.xyz);\n"
    "    float most = max(c.r, max(c.g, c.b));\n"
    "    float bent = 1.0 - 0.16 / (most - 0.2);\n"       /* slope 1 at 0.6 */
    "    if (most > 0.6) c = mix(vec3(bent), c * (bent / most), 1.0 / (1.0 + 0.15 * (most - bent)));\n"
    "    vec3 low = 12.92 * c, high = 1.055 * pow(max(c, vec3(0.0031308)), vec3(1.0 / 2.4)) - 0.055;\n"
    "    c = mix(high, low, vec3(lessThan(c, vec3(0.0031308))));\n"
    "    for (int i = 0; i < 4; i++) {\n"
    "        float r = length(gl_FragCoord.xy - dots[i].xy) / max(dots[i].z, 1e-3);\n"
    "        float inside = clamp((1.0 - r) * dots[i].z, 0.0, 1.0) * (dots[i].w < far ? 1.0 : 0.25);\n"
    "        c = mix(c, colors[i].rgb * (1.0 - 0.35 * r * r), inside);\n"
    "    }\n"
    "    shown = vec4(c, 1.0);\n"
    "}\n";

int pg_failed(const char *what, glbk_result result, char *error)
{
    if (!error[0]) snprintf(error, EX_ERROR_SIZE, "%s: %s", what, glbk_result_text(result));
    return -1;
}

/* ---- what stays ---- */

glbk_result pg_stage_compile(pg_stage *s, const char *text, glbk_program *out)
{
    glbk_source source;
    memset(&source, 0, sizeof source);
    source.fragment = text;
    source.uses = "gbuffer";
    source.parts[0] = glbk_gbuffer_part();
    return glbk_program_compile(s->gl, &source, out);
}

static glbk_result make_sky(pg_stage *s, const float *rgba, uint32_t width, uint32_t height)
{
    glbk_texture_desc desc;
    glbk_texture fresh;
    glbk_result result;
    memset(&desc, 0, sizeof desc);
    desc.format = GLBK_FORMAT_RGBA32F;
    desc.width = width;
    desc.height = height;
    desc.sampling = s->gl->float_linear ? GLBK_SAMPLING_LINEAR : GLBK_SAMPLING_NEAREST;
    desc.repeat = 1;
    desc.data = rgba;
    result = glbk_texture_create(s->gl, &desc, &fresh);
    if (result != GLBK_OK) return result;           /* the sky that was there stays */
    glbk_texture_free(s->gl, &s->sky);
    s->sky = fresh;
    return GLBK_OK;
}

int pg_stage_create(pg_stage *s, glbk_context *gl, char *error)
{
    static const float black[4] = { 0, 0, 0, 1 };
    glbk_result result;
    s->gl = gl;
    s->exposure = s->sky_light = 1;
    s->held = -1;
    result = pg_stage_compile(s, mix_text, &s->mix);
    if (result == GLBK_OK) result = pg_stage_compile(s, show_text, &s->show);
    if (result == GLBK_OK) result = make_sky(s, black, 1, 1);
    return result == GLBK_OK ? 0 : pg_failed("shaders", result, error);
}

static void free_sized(pg_stage *s)
{
    glbk_target_free(s->gl, &s->light_target);
    glbk_texture_free(s->gl, &s->light);
    for (int i = 0; i < 2; i++) {
        glbk_target_free(s->gl, &s->sum_target[i]);
        glbk_texture_free(s->gl, &s->sum[i]);
    }
    s->frames = 0;
}

void pg_stage_free(pg_stage *s)
{
    free_sized(s);
    glbk_gbuffer_free(s->gl, &s->seen);
    glbk_texture_free(s->gl, &s->sky);
    glbk_program_free(s->gl, &s->mix);
    glbk_program_free(s->gl, &s->show);
    s->width = s->height = 0;
}

glbk_result pg_stage_target(pg_stage *s, glbk_texture *texture, glbk_target *target)
{
    glbk_texture_desc desc;
    glbk_target_desc to;
    glbk_result result;
    memset(&desc, 0, sizeof desc);
    memset(&to, 0, sizeof to);
    desc.format = GLBK_FORMAT_COLOR;
    desc.width = s->width;
    desc.height = s->height;
    result = glbk_texture_create(s->gl, &desc, texture);
    to.color[0] = texture;
    return result == GLBK_OK ? glbk_target_create(s->gl, &to, target) : result;
}

int pg_stage_resize(pg_stage *s, uint32_t width, uint32_t height, char *error)
{
    glbk_gbuffer_desc seen;
    glbk_result result;
    if (s->width == width && s->height == height && s->light.name) return 0;
    free_sized(s);
    memset(&seen, 0, sizeof seen);
    s->width = seen.width = width;
    s->height = seen.height = height;
    seen.attributes.normal = 1;
    seen.attributes.uv = 2;
    seen.attributes.tangent = 3;
    if (s->seen.width) result = glbk_gbuffer_resize(s->gl, &s->seen, &seen);
    else result = glbk_gbuffer_create(s->gl, &seen, &s->seen);
    if (result == GLBK_OK) result = pg_stage_target(s, &s->light, &s->light_target);
    for (int i = 0; i < 2 && result == GLBK_OK; i++) result = pg_stage_target(s, &s->sum[i], &s->sum_target[i]);
    return result == GLBK_OK ? 0 : pg_failed("the picture's textures", result, error);
}

/* ---- the sky ---- */

enum { SKY_WIDTH = 512, SKY_HEIGHT = 256 };

/* At most SKY_WIDTH x SKY_HEIGHT texels, each the mean of those that it stands for. */
static float *shrink(const ex_sky *sky, uint32_t *width, uint32_t *height)
{
    uint32_t across = 1, down = 1;
    float *out;
    while (sky->width / across > SKY_WIDTH) across++;
    while (sky->height / down > SKY_HEIGHT) down++;
    *width = sky->width / across;
    *height = sky->height / down;
    out = calloc(4 * (size_t)*width * *height, sizeof *out);
    if (!out) return NULL;
    for (uint32_t y = 0; y < *height * down; y++)
        for (uint32_t x = 0; x < *width * across; x++)
            for (uint32_t k = 0; k < 3; k++)
                out[4 * ((size_t)(y / down) * *width + x / across) + k] +=
                    sky->rgb[3 * ((size_t)y * sky->width + x) + k] / (float)(across * down);
    for (size_t i = 0; i < (size_t)*width * *height; i++) out[4 * i + 3] = 1;
    return out;
}

/* What a white surface that looks up reflects, and the mean radiance of the upper half. */
static void measure(pg_stage *s, const float *rgba, uint32_t width, uint32_t height)
{
    double light = 0, mean[3] = { 0, 0, 0 }, area = 0;
    for (uint32_t y = 0; y < height / 2; y++) {
        double a = pi * (y + 0.5) / height, texel = sin(a) * 2 * pi / width * pi / height;
        for (uint32_t x = 0; x < width; x++) {
            const float *c = rgba + 4 * ((size_t)y * width + x);
            light += (0.2126 * (double)c[0] + 0.7152 * (double)c[1] + 0.0722 * (double)c[2]) * texel * cos(a) / pi;
            for (int k = 0; k < 3; k++) mean[k] += (double)c[k] * texel;
            area += texel;
        }
    }
    s->sky_light = light > 1e-20 ? (float)light : 1;
    for (int k = 0; k < 3; k++) s->sky_mean[k] = (float)(mean[k] / (area > 0 ? area : 1));
}

/* Grey, with half of the sky's colour. */
static void choose_backdrop(pg_stage *s)
{
    const float mean = 0.2126f * s->sky_mean[0] + 0.7152f * s->sky_mean[1] + 0.0722f * s->sky_mean[2];
    for (int k = 0; k < 3; k++)
        s->backdrop[k] = 0.45f * s->sky_light * (0.5f + 0.5f * (mean > 0 ? s->sky_mean[k] / mean : 1));
}

int pg_stage_sky(pg_stage *s, const ex_sky *sky, float **texels, uint32_t *width, uint32_t *height, char *error)
{
    uint32_t w, h;
    float *rgba = shrink(sky, &w, &h);
    glbk_result result;
    if (!rgba) return pg_failed("the sky", GLBK_ERR_ALLOC, error);
    result = make_sky(s, rgba, w, h);
    if (result == GLBK_OK) {
        measure(s, rgba, w, h);
        choose_backdrop(s);
        s->frames = 0;
    }
    if (result == GLBK_OK && texels) {
        for (size_t i = 0; i < (size_t)w * h; i++) memmove(rgba + 3 * i, rgba + 4 * i, 3 * sizeof *rgba);
        *texels = rgba;
        *width = w;
        *height = h;
        return 0;
    }
    free(rgba);
    return result == GLBK_OK ? 0 : pg_failed("the sky", result, error);
}

/* ---- the camera ---- */

static void turn_about_y(float angle, const float v[3], float out[3])
{
    const float c = cosf(angle), s = sinf(angle), x = v[0], z = v[2];
    out[0] = c * x + s * z;
    out[1] = v[1];
    out[2] = c * z - s * x;
}

/* A camera at eye that looks at target; the picture is moved by jitter, in clip space. One that is high and narrow, as a
   phone's, sees as far to the sides as one of 3 : 2. */
static void look(const pg_stage *s, const float eye[3], const float target[3], float radius, const float jitter[2],
                 pg_camera *out)
{
    float f[3], r[3], u[3], length, far, near, top = tanf(half_fov), side;
    float distance, *m = out->clip, *n = out->unclip;
    for (int k = 0; k < 3; k++) f[k] = target[k] - eye[k];
    distance = sqrtf(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]);
    for (int k = 0; k < 3; k++) f[k] /= distance;
    length = sqrtf(f[0] * f[0] + f[2] * f[2]);
    r[0] = -f[2] / length;
    r[1] = 0;
    r[2] = f[0] / length;
    u[0] = r[1] * f[2] - r[2] * f[1];
    u[1] = r[2] * f[0] - r[0] * f[2];
    u[2] = r[0] * f[1] - r[1] * f[0];
    if (3 * s->height > 2 * s->width) top *= 1.5f * (float)s->height / (float)s->width;
    side = top * (float)s->width / (float)s->height;
    near = 0.05f * radius;
    far = distance + 60 * radius;
    for (int k = 0; k < 3; k++) {
        out->eye[k] = eye[k];
        m[4 * k] = r[k] / side + jitter[0] * f[k];
        m[4 * k + 1] = u[k] / top + jitter[1] * f[k];
        m[4 * k + 2] = f[k] * (far + near) / (far - near);
        m[4 * k + 3] = f[k];
    }
    for (int row = 0; row < 4; row++)
        m[12 + row] = -(m[row] * eye[0] + m[4 + row] * eye[1] + m[8 + row] * eye[2]);
    m[14] -= 2 * far * near / (far - near);
    /* From clip space with w = 1 on the far plane: only the direction from the eye is asked for. */
    for (int k = 0; k < 3; k++) {
        n[k] = side * r[k];
        n[4 + k] = top * u[k];
        n[8 + k] = 0;
        n[12 + k] = eye[k] + f[k] - side * jitter[0] * r[k] - top * jitter[1] * u[k];
    }
    n[3] = n[7] = n[11] = 0;
    n[15] = 1;
}

static float radical_inverse(uint32_t i, uint32_t base)
{
    float value = 0, digit = 1 / (float)base;
    for (; i; i /= base, digit /= (float)base) value += (float)(i % base) * digit;
    return value;
}

void pg_stage_look(pg_stage *s, const pg_model *model, const pg_view *view, float turn)
{
    float eye[3], target[3], jitter[2];
    const float co = cosf(view->elevation), distance = view->distance * model->radius;
    memcpy(target, model->center, sizeof target);
    target[1] += view->up * model->radius;
    eye[0] = target[0] + distance * co * cosf(view->azimuth);
    eye[1] = target[1] + distance * sinf(view->elevation);
    eye[2] = target[2] + distance * co * sinf(view->azimuth);
    if (eye[1] < model->ground + 0.02f * model->radius) eye[1] = model->ground + 0.02f * model->radius;
    turn_about_y(turn, eye, eye);
    turn_about_y(turn, target, target);
    jitter[0] = (2 * radical_inverse(s->frames + 1, 2) - 1) / (float)s->width;
    jitter[1] = (2 * radical_inverse(s->frames + 1, 3) - 1) / (float)s->height;
    if (s->no_mean) jitter[0] = jitter[1] = 0;
    look(s, eye, target, model->radius, jitter, &s->camera);
    memcpy(s->ground, model->center, sizeof model->center);
    s->ground[1] = model->ground;
    turn_about_y(turn, s->ground, s->ground);
    s->ground[3] = PG_GROUND_END * model->radius;
}

void pg_stage_project(const pg_stage *s, const float point[3], float out[2])
{
    const float *m = s->camera.clip;
    float v[4];
    for (int r = 0; r < 4; r++) v[r] = m[r] * point[0] + m[4 + r] * point[1] + m[8 + r] * point[2] + m[12 + r];
    out[0] = v[0] / v[3];
    out[1] = v[1] / v[3];
}

/* ---- a frame ---- */

static glbk_result set_seen(void *user, glbk_context *gl, const glbk_surface *surface)
{
    return glbk_gbuffer_object(gl, &((pg_stage *)user)->seen, surface);
}

glbk_result pg_stage_draw(pg_stage *s, const pg_model *model, const float transform[16], uint32_t first_entity)
{
    const pg_draw draw = { transform, set_seen, s, 0, 0, first_entity };
    const glbk_result result = glbk_gbuffer_begin(s->gl, &s->seen, s->camera.clip, s->camera.eye);
    return result == GLBK_OK ? pg_model_draw(model, s->gl, &draw) : result;
}

static void set_uniform(const glbk_functions *f, uint32_t program, const char *name, const float xyz[3], float w)
{
    const float value[4] = { xyz[0], xyz[1], xyz[2], w };
    f->Uniform4fv(f->GetUniformLocation(program, name), 1, value);
}

glbk_result pg_stage_mix(pg_stage *s)
{
    const glbk_functions *f = &s->gl->gl;
    const float size[3] = { (float)s->width, (float)s->height, s->sky_turn };
    glbk_pass pass;
    glbk_result result;
    memset(&pass, 0, sizeof pass);
    pass.target = &s->sum_target[1 - s->now];
    result = glbk_begin(s->gl, &pass, &s->mix);
    if (result != GLBK_OK) return result;
    glbk_gbuffer_bind(s->gl, &s->seen, NULL);
    glbk_bind_texture(s->gl, GLBK_SLOT_glbk_user0, &s->light);
    glbk_bind_texture(s->gl, GLBK_SLOT_glbk_user1, &s->sum[s->now]);
    glbk_bind_texture(s->gl, GLBK_SLOT_glbk_user2, &s->sky);
    f->UniformMatrix4fv(f->GetUniformLocation(s->mix.name, "clip_to_world"), 1, 0, s->camera.unclip);
    set_uniform(f, s->mix.name, "eye", s->camera.eye, s->no_mean ? 1 : 1 / (float)(s->frames + 1));
    set_uniform(f, s->mix.name, "ground", s->ground, s->ground[3]);
    set_uniform(f, s->mix.name, "backdrop", s->backdrop, s->show_sky ? 1.0f : 0.0f);
    set_uniform(f, s->mix.name, "size", size, 0);
    glbk_draw_screen(s->gl);
    s->now = 1 - s->now;
    s->frames++;
    return GLBK_OK;
}

/* Dots of the first handles that have one. */
static void set_dots(const pg_stage *s)
{
    const glbk_functions *f = &s->gl->gl;
    float dots[PG_DOTS][4] = { { 0 } }, colors[PG_DOTS][4] = { { 0 } };
    uint32_t n = 0;
    for (uint32_t i = 0; i < s->handle_count && n < PG_DOTS; i++) {
        const pg_handle *h = &s->handles[i];
        const float most = fmaxf(h->color[0], fmaxf(h->color[1], h->color[2]));
        float d = 0, at[2];
        if (most <= 0) continue;
        for (int k = 0; k < 3; k++) {
            d += (h->position[k] - s->camera.eye[k]) * (h->position[k] - s->camera.eye[k]);
            colors[n][k] = h->color[k] / most;      /* a lamp that is dim is no dark thing */
        }
        pg_stage_project(s, h->position, at);
        dots[n][0] = (0.5f + 0.5f * at[0]) * (float)s->width;
        dots[n][1] = (0.5f + 0.5f * at[1]) * (float)s->height;
        dots[n][2] = 0.018f * (float)s->height;
        dots[n++][3] = 0.98f * sqrtf(d);        /* not in the wall on which it lies */
    }
    f->Uniform4fv(f->GetUniformLocation(s->show.name, "dots"), PG_DOTS, dots[0]);
    f->Uniform4fv(f->GetUniformLocation(s->show.name, "colors"), PG_DOTS, colors[0]);
}

glbk_result pg_stage_show(pg_stage *s)
{
    const glbk_functions *f = &s->gl->gl;
    glbk_pass pass;
    glbk_result result;
    memset(&pass, 0, sizeof pass);
    pass.viewport[2] = (int32_t)s->width;
    pass.viewport[3] = (int32_t)s->height;
    f->BindFramebuffer(GLBK_GL_DRAW_FRAMEBUFFER, s->window);
    result = glbk_begin(s->gl, &pass, &s->show);
    if (result != GLBK_OK) return result;
    glbk_gbuffer_bind(s->gl, &s->seen, NULL);
    glbk_bind_texture(s->gl, GLBK_SLOT_glbk_user0, &s->sum[s->now]);
    f->Uniform1f(f->GetUniformLocation(s->show.name, "exposure"), s->exposure);
    set_uniform(f, s->show.name, "eye", s->camera.eye, 0);
    set_dots(s);
    glbk_draw_screen(s->gl);
    return glbk_check(s->gl);
}

/* ---- handles ---- */

/* The direction from the eye through a point of the window. */
static void aim(const pg_stage *s, float x, float y, float d[3])
{
    const float *n = s->camera.unclip;
    for (int k = 0; k < 3; k++) d[k] = n[k] * x + n[4 + k] * y + n[12 + k] - s->camera.eye[k];
}

int pg_stage_press(pg_stage *s, float x, float y)
{
    float d[3], best = 1e30f;
    s->held = -1;
    aim(s, x, y, d);
    for (uint32_t i = 0; i < s->handle_count; i++) {
        const pg_handle *h = &s->handles[i];
        float to[3], along = 0, length = 0, miss = 0;
        for (int k = 0; k < 3; k++) {
            to[k] = h->position[k] - s->camera.eye[k];
            along += to[k] * d[k];
            length += d[k] * d[k];
        }
        along /= length;
        for (int k = 0; k < 3; k++) miss += (to[k] - along * d[k]) * (to[k] - along * d[k]);
        if (along <= 0 || miss > h->radius * h->radius || miss >= best) continue;
        best = miss;
        s->held = (int)i;
    }
    return s->held >= 0;
}

/* How far along d a point on the handle's track is, or 0 = nowhere. */
static float meet(const pg_stage *s, const pg_handle *h, const float d[3])
{
    float far = 1e30f;
    if (h->track == PG_TRACK_PLANE)
        return d[1] * (h->position[1] - s->camera.eye[1]) > 0 ? (h->position[1] - s->camera.eye[1]) / d[1] : 0;
    for (int k = 0; k < 3; k++) {               /* where the ray leaves the box */
        const float t = d[k] != 0 ? (s->box[d[k] > 0][k] - s->camera.eye[k]) / d[k] : 1e30f;
        if (t < far) far = t;
    }
    return far > 0 ? far : 0;
}

void pg_stage_drag(pg_stage *s, float x, float y)
{
    pg_handle *h;
    float d[3], t;
    if (s->held < 0) return;
    h = &s->handles[s->held];
    aim(s, x, y, d);
    t = meet(s, h, d);
    if (t <= 0) return;
    for (int k = 0; k < 3; k++) {
        float at = s->camera.eye[k] + t * d[k];
        if (k == 1 && h->track == PG_TRACK_PLANE) continue;
        h->position[k] = fminf(fmaxf(at, s->box[0][k]), s->box[1][k]);
    }
}

/* ---- to compare with ---- */

void pg_lights_spot(pg_lights *lights, const float position[3], const float direction[3], float cone_half_angle,
                    const float value[3])
{
    const float *d = direction;
    const float length = sqrtf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    ex_light *light = &lights->lights[0];
    memset(lights, 0, sizeof *lights);
    light->kind = EX_LIGHT_SPOT;
    light->cos_half_angle = cosf(cone_half_angle);
    for (int k = 0; k < 3; k++) {
        light->position[k] = position[k];
        light->direction[k] = d[k] / length;
        light->value[k] = value[k];
    }
    lights->count = 1;
}

int pg_lights_sky(pg_lights *lights, const char *name, float rotation, char *error)
{
    static const char builtin[] = "builtin:";
    ex_sky *sky = &lights->sky;
    const int named = strncmp(name, builtin, sizeof builtin - 1) == 0;
    if ((named ? ex_sky_builtin(sky, name + sizeof builtin - 1, error) : ex_sky_load(sky, name, error)) != 0) return -1;
    memset(sky->rgb + 3 * (size_t)sky->width * (sky->height / 2), 0,
           3 * (size_t)sky->width * (sky->height - sky->height / 2) * sizeof *sky->rgb);
    sky->rotation = rotation;
    return 0;
}
