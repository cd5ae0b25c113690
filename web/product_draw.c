/* product_draw.c - see product.h: the passes of a frame.

   The sky stays where it is, and the scene and the camera turn the other way: to see a sky turn is the same, and the
   table of its light need not be made anew. So "world" below is the space in which the sky rests. */
#include "product.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979;

/* Mixes the light of a frame, and of what lies behind the surfaces, into the mean of the frames before. The ground has an
   end: towards it it becomes the backdrop. */
static const char mix_text[] =
    "uniform glbk_color_sampler glbk_user0;\n"      /* light of this frame */
    "uniform glbk_color_sampler glbk_user1;\n"      /* the mean so far */
    "uniform sampler2D glbk_user2;\n"               /* the sky, latitude and longitude */
    "uniform mat4 clip_to_world;\n"
    "uniform vec4 eye;\n"                           /* w: share of this frame in the mean */
    "uniform vec4 center;\n"                        /* of the ground; w: where it ends */
    "uniform vec4 backdrop;\n"                      /* w: whether the sky itself is shown */
    "uniform vec4 size;\n"
    "layout(location = 0) out glbk_color mean;\n"
    "void main()\n"
    "{\n"
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n"
    "    vec4 far = clip_to_world * vec4(2.0 * gl_FragCoord.xy / size.xy - 1.0, 1.0, 1.0);\n"
    "    vec3 d = normalize(far.xyz / far.w - eye.xyz);\n"
    "    vec2 uv = vec2(0.5 + atan(d.z, d.x) / 6.2831853, acos(clamp(d.y, -1.0, 1.0)) / 3.14159265);\n"
    "    vec3 sky = textureLod(glbk_user2, uv, 0.0).rgb;\n"
    "    vec3 behind = mix(backdrop.rgb * (0.9 + 0.25 * d.y), sky, backdrop.w);\n"
    "    vec3 light = behind;\n"
    "    glbk_point p;\n"
    "    if (glbk_read_point(at, p)) {\n"
    "        float end = p.plane == 0u ? 0.0 : smoothstep(0.35, 1.0, length(p.position - center.xyz) / center.w);\n"
    "        light = mix(glbk_unpack(texelFetch(glbk_user0, at, 0)).rgb, behind, end);\n"
    "    }\n"
    "    vec3 before = glbk_unpack(texelFetch(glbk_user1, at, 0)).rgb;\n"
    "    mean = glbk_pack(vec4(eye.w < 1.0 ? mix(before, light, eye.w) : light, 1.0));\n"
    "}\n";

/* A curve that leaves the middle alone and bends what is bright towards white, then sRGB. */
static const char show_text[] =
    "uniform glbk_color_sampler glbk_user0;\n"
    "uniform float exposure;\n"
    "out vec4 shown;\n"
    "void main()\n"
    "{\n"
    "    vec3 c = exposure * glbk_unpack(texelFetch(glbk_user0, ivec2(gl_FragCoord.xy), 0)).rgb;\n"
    "    c = c * (1.0 + c / 16.0) / (1.0 + c * 0.45);\n"
    "    c = clamp(c, 0.0, 1.0);\n"
    "    vec3 low = 12.92 * c, high = 1.055 * pow(max(c, vec3(0.0031308)), vec3(1.0 / 2.4)) - 0.055;\n"
    "    shown = vec4(mix(high, low, vec3(lessThan(c, vec3(0.0031308)))), 1.0);\n"
    "}\n";

static int failed(const char *what, glbk_result result, char *error)
{
    if (!error[0]) snprintf(error, EX_ERROR_SIZE, "%s: %s", what, glbk_result_text(result));
    return -1;
}

/* ---- what stays ---- */

static glbk_result compile(pd_picture *p, const char *text, const char *uses, glbk_program *out)
{
    glbk_source source;
    memset(&source, 0, sizeof source);
    source.fragment = text;
    source.uses = uses;
    source.parts[0] = glbk_gbuffer_part();
    return glbk_program_compile(p->gl, &source, out);
}

int pd_picture_create(pd_picture *p, glbk_context *gl, char *error)
{
    glbk_result result;
    memset(p, 0, sizeof *p);
    p->gl = gl;
    result = compile(p, mix_text, "gbuffer", &p->mix);
    if (result == GLBK_OK) result = compile(p, show_text, NULL, &p->show);
    return result == GLBK_OK ? 0 : failed("shaders", result, error);
}

static void free_sized(pd_picture *p)
{
    glbk_csm_renderer_free(p->gl, &p->renderer);
    glbk_gbuffer_free(p->gl, &p->seen);
    glbk_target_free(p->gl, &p->light_target);
    glbk_texture_free(p->gl, &p->light);
    for (int i = 0; i < 2; i++) {
        glbk_target_free(p->gl, &p->sum_target[i]);
        glbk_texture_free(p->gl, &p->sum[i]);
    }
    p->frames = 0;
}

void pd_picture_free(pd_picture *p)
{
    free_sized(p);
    glbk_csm_lights_free(p->gl, &p->lights);
    glbk_csm_maps_free(p->gl, &p->maps);
    glbk_texture_free(p->gl, &p->sky);
    glbk_program_free(p->gl, &p->mix);
    glbk_program_free(p->gl, &p->show);
}

static glbk_result make_target(pd_picture *p, glbk_texture *texture, glbk_target *target)
{
    glbk_texture_desc desc;
    glbk_target_desc to;
    glbk_result result;
    memset(&desc, 0, sizeof desc);
    memset(&to, 0, sizeof to);
    desc.format = GLBK_FORMAT_COLOR;
    desc.width = p->width;
    desc.height = p->height;
    result = glbk_texture_create(p->gl, &desc, texture);
    to.color[0] = texture;
    return result == GLBK_OK ? glbk_target_create(p->gl, &to, target) : result;
}

int pd_picture_resize(pd_picture *p, uint32_t width, uint32_t height, char *error)
{
    glbk_gbuffer_desc seen;
    glbk_csm_renderer_desc desc;
    glbk_result result;
    if (p->width == width && p->height == height && p->light.name) return 0;
    free_sized(p);
    memset(&seen, 0, sizeof seen);
    memset(&desc, 0, sizeof desc);
    p->width = seen.width = desc.width = width;
    p->height = seen.height = desc.height = height;
    seen.attributes.normal = 1;
    seen.attributes.uv = 2;
    seen.attributes.tangent = -1;
    result = glbk_gbuffer_create(p->gl, &seen, &p->seen);
    if (result == GLBK_OK) result = glbk_csm_renderer_create(p->gl, &desc, &p->renderer);
    if (result == GLBK_OK) result = make_target(p, &p->light, &p->light_target);
    for (int i = 0; i < 2 && result == GLBK_OK; i++) result = make_target(p, &p->sum[i], &p->sum_target[i]);
    return result == GLBK_OK ? 0 : failed("the picture's textures", result, error);
}

int pd_picture_maps(pd_picture *p, const void *data, size_t bytes, float radius, char *error)
{
    glbk_csm_block block = { data, bytes };
    glbk_csm_instance instance;
    glbk_csm_maps maps;
    glbk_result result;
    memset(&instance, 0, sizeof instance);
    result = glbk_csm_maps_create(p->gl, &block, 1, 1, &instance.start, &maps);
    if (result != GLBK_OK) return failed("the maps", result, error);
    glbk_csm_maps_free(p->gl, &p->maps);
    p->maps = maps;
    p->frames = 0;
    p->offset = 0.01f * radius;
    return 0;
}

/* ---- the sky ---- */

enum { SKY_WIDTH = 512, SKY_HEIGHT = 256 };

/* At most SKY_WIDTH x SKY_HEIGHT texels, each the mean of those that it stands for. */
static float *shrink(const ex_sky *sky, uint32_t *width, uint32_t *height)
{
    uint32_t step = 1;
    float *out;
    while (sky->width / step > SKY_WIDTH || sky->height / step > SKY_HEIGHT) step++;
    *width = sky->width / step;
    *height = sky->height / step;
    out = calloc(4 * (size_t)*width * *height, sizeof *out);
    if (!out) return NULL;
    for (uint32_t y = 0; y < *height * step; y++)
        for (uint32_t x = 0; x < *width * step; x++)
            for (uint32_t k = 0; k < 3; k++)
                out[4 * ((size_t)(y / step) * *width + x / step) + k] +=
                    sky->rgb[3 * ((size_t)y * sky->width + x) + k] / (float)(step * step);
    for (size_t i = 0; i < (size_t)*width * *height; i++) out[4 * i + 3] = 1;
    return out;
}

/* What a white surface that looks up reflects, and the mean radiance of the upper half. */
static void measure(pd_picture *p, const float *rgba, uint32_t width, uint32_t height)
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
    p->sky_light = light > 1e-20 ? (float)light : 1;
    for (int k = 0; k < 3; k++) p->sky_mean[k] = (float)(mean[k] / (area > 0 ? area : 1));
}

static glbk_result upload_sky(pd_picture *p, float *rgba, uint32_t width, uint32_t height)
{
    glbk_texture_desc texture;
    glbk_csm_lights_desc lights;
    lsamp_light_desc light;
    glbk_result result;
    memset(&texture, 0, sizeof texture);
    memset(&lights, 0, sizeof lights);
    memset(&light, 0, sizeof light);
    texture.format = GLBK_FORMAT_RGBA32F;
    texture.width = light.width = width;
    texture.height = light.height = height;
    texture.sampling = p->gl->float_linear ? GLBK_SAMPLING_LINEAR : GLBK_SAMPLING_NEAREST;
    texture.repeat = 1;
    texture.data = rgba;
    result = glbk_texture_create(p->gl, &texture, &p->sky);
    for (size_t i = 0; i < (size_t)width * height; i++) memmove(rgba + 3 * i, rgba + 4 * i, 3 * sizeof *rgba);
    light.kind = LSAMP_LIGHT_ENVIRONMENT;
    light.radiance[0] = light.radiance[1] = light.radiance[2] = 1;
    light.texels = rgba;
    lights.lights = &light;
    lights.light_count = 1;
    if (result == GLBK_OK) result = glbk_csm_lights_create(p->gl, &lights, &p->sky_start, &p->lights);
    return result;
}

int pd_picture_sky(pd_picture *p, const ex_sky *sky, char *error)
{
    uint32_t width, height;
    float *rgba = shrink(sky, &width, &height);
    glbk_result result;
    if (!rgba) return failed("the sky", GLBK_ERR_ALLOC, error);
    glbk_csm_lights_free(p->gl, &p->lights);
    glbk_texture_free(p->gl, &p->sky);
    measure(p, rgba, width, height);
    result = upload_sky(p, rgba, width, height);
    free(rgba);
    p->frames = 0;
    return result == GLBK_OK ? 0 : failed("the sky", result, error);
}

/* ---- a frame ---- */

static void turn_about_y(float angle, const float v[3], float out[3])
{
    float c = cosf(angle), s = sinf(angle);
    out[0] = c * v[0] + s * v[2];
    out[1] = v[1];
    out[2] = c * v[2] - s * v[0];
}

typedef struct camera { float eye[3], clip[16], unclip[16]; } camera;

/* A camera at eye that looks at target, fovy 0.6; the picture is moved by x, y pixels. */
static void look(const pd_picture *p, const float eye[3], const float target[3], float radius, const float jitter[2],
                 camera *out)
{
    float f[3], r[3], u[3], length, far, near, top = tanf(0.3f), side;
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
    side = top * (float)p->width / (float)p->height;
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

/* The picture's camera in the space where the sky rests, and how the scene is turned there. */
static void place(const pd_picture *p, const pd_model *model, const pd_view *view, camera *c, float world[16])
{
    float eye[3], target[3], turned[3], jitter[2];
    float co = cosf(view->elevation), distance = view->distance * model->radius;
    for (int k = 0; k < 3; k++) target[k] = model->center[k];
    target[1] += view->up * model->radius;
    eye[0] = target[0] + distance * co * cosf(view->azimuth);
    eye[1] = target[1] + distance * sinf(view->elevation);
    eye[2] = target[2] + distance * co * sinf(view->azimuth);
    if (eye[1] < model->ground + 0.02f * model->radius) eye[1] = model->ground + 0.02f * model->radius;
    turn_about_y(-view->sky_turn, eye, turned);
    memcpy(eye, turned, sizeof eye);
    turn_about_y(-view->sky_turn, target, turned);
    jitter[0] = (2 * radical_inverse(p->frames + 1, 2) - 1) / (float)p->width;
    jitter[1] = (2 * radical_inverse(p->frames + 1, 3) - 1) / (float)p->height;
    look(p, eye, turned, model->radius, jitter, c);
    memset(world, 0, 16 * sizeof *world);
    world[0] = world[10] = cosf(-view->sky_turn);
    world[8] = sinf(-view->sky_turn);
    world[2] = -world[8];
    world[5] = world[15] = 1;
}

static glbk_result shade(pd_picture *p, const pd_model *model, const pd_view *view, const camera *c,
                         const float world[16])
{
    glbk_csm_use use;
    glbk_csm_frame_desc desc;
    glbk_csm_instance instance;
    glbk_pass pass;
    glbk_result result;
    memset(&use, 0, sizeof use);
    memset(&desc, 0, sizeof desc);
    memset(&instance, 0, sizeof instance);
    memset(&pass, 0, sizeof pass);
    memcpy(instance.transform, world, sizeof instance.transform);
    instance.offset = p->offset;
    result = glbk_csm_maps_place(p->gl, &p->maps, &instance, 1);
    use.start = p->sky_start;
    use.kind = LSAMP_LIGHT_ENVIRONMENT;
    use.maps = &p->maps;
    use.sample_count = view->samples ? view->samples : 8;
    desc.lights = &p->lights;
    desc.uses = &use;
    desc.use_count = 1;
    memcpy(desc.eye, c->eye, sizeof desc.eye);
    desc.planes[0][1] = 1;
    desc.planes[0][3] = model->ground;
    desc.plane_count = 1;
    desc.filter = COHSM_FILTER_ROULETTE;
    desc.frame = p->frames;
    glbk_csm_reset(&p->renderer);
    if (result == GLBK_OK) result = glbk_csm_render(p->gl, &p->renderer, &p->seen, &desc);
    pass.target = &p->light_target;
    return result == GLBK_OK ? glbk_csm_resolve(p->gl, &p->renderer, &p->seen, &pass, NULL) : result;
}

static void set_uniform(const glbk_functions *f, uint32_t program, const char *name, const float xyz[3], float w)
{
    const float value[4] = { xyz[0], xyz[1], xyz[2], w };
    f->Uniform4fv(f->GetUniformLocation(program, name), 1, value);
}

static void set_uniforms(pd_picture *p, const pd_model *model, const pd_view *view, const camera *c)
{
    const glbk_functions *f = &p->gl->gl;
    const float center[3] = { model->center[0], model->ground, model->center[2] };
    const float size[3] = { (float)p->width, (float)p->height, 0 };
    const float mean = 0.2126f * p->sky_mean[0] + 0.7152f * p->sky_mean[1] + 0.0722f * p->sky_mean[2];
    float turned[3], behind[3];
    turn_about_y(-view->sky_turn, center, turned);
    for (int k = 0; k < 3; k++)     /* grey, with half of the sky's colour */
        behind[k] = 0.45f * p->sky_light * (0.5f + 0.5f * (mean > 0 ? p->sky_mean[k] / mean : 1));
    f->UniformMatrix4fv(f->GetUniformLocation(p->mix.name, "clip_to_world"), 1, 0, c->unclip);
    set_uniform(f, p->mix.name, "eye", c->eye, 1 / (float)(p->frames + 1));
    set_uniform(f, p->mix.name, "center", turned, 6 * model->radius);
    set_uniform(f, p->mix.name, "backdrop", behind, view->show_sky ? 1.0f : 0.0f);
    set_uniform(f, p->mix.name, "size", size, 0);
}

static glbk_result mix(pd_picture *p, const pd_model *model, const pd_view *view, const camera *c)
{
    glbk_pass pass;
    glbk_result result;
    memset(&pass, 0, sizeof pass);
    pass.target = &p->sum_target[1 - p->now];
    result = glbk_begin(p->gl, &pass, &p->mix);
    if (result != GLBK_OK) return result;
    glbk_gbuffer_bind(p->gl, &p->seen, NULL);
    glbk_bind_texture(p->gl, GLBK_SLOT_glbk_user0, &p->light);
    glbk_bind_texture(p->gl, GLBK_SLOT_glbk_user1, &p->sum[p->now]);
    glbk_bind_texture(p->gl, GLBK_SLOT_glbk_user2, &p->sky);
    set_uniforms(p, model, view, c);
    glbk_draw_screen(p->gl);
    p->now = 1 - p->now;
    return GLBK_OK;
}

static glbk_result show(pd_picture *p, const pd_view *view)
{
    const glbk_functions *f = &p->gl->gl;
    glbk_pass pass;
    glbk_result result;
    memset(&pass, 0, sizeof pass);
    pass.viewport[2] = (int32_t)p->width;
    pass.viewport[3] = (int32_t)p->height;
    f->BindFramebuffer(GLBK_GL_DRAW_FRAMEBUFFER, p->window);
    result = glbk_begin(p->gl, &pass, &p->show);
    if (result != GLBK_OK) return result;
    glbk_bind_texture(p->gl, GLBK_SLOT_glbk_user0, &p->sum[p->now]);
    f->Uniform1f(f->GetUniformLocation(p->show.name, "exposure"), 0.9f * view->exposure / p->sky_light);
    glbk_draw_screen(p->gl);
    return glbk_check(p->gl);
}

int pd_picture_frame(pd_picture *p, const pd_model *model, const pd_view *view, int anew, char *error)
{
    camera c;
    float world[16];
    glbk_result result;
    if (!p->maps.blocks.name || !p->lights.texels.name || !model->parts) return 0;
    if (anew) p->frames = 0;
    place(p, model, view, &c, world);
    if (pd_model_draw(model, p->gl, &p->seen, c.clip, c.eye, world) != 0) {
        snprintf(error, EX_ERROR_SIZE, "the G-buffer cannot be drawn");
        return -1;
    }
    result = shade(p, model, view, &c, world);
    if (result == GLBK_OK) result = mix(p, model, view, &c);
    if (result == GLBK_OK) result = show(p, view);
    p->frames++;
    return result == GLBK_OK ? 0 : failed("a frame", result, error);
}
