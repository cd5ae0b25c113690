/* main.c - the program `render`: one picture of one scene by one technique. docs/programs.md is its definition. */
#include "../common/gl_context.h"
#include "../common/gl_timer.h"
#include "kept.h"
#include "setup.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

extern const char dapple_version[];        /* of CHANGELOG.md, by the Makefile */

enum { DONE = 0, FAILED = 1, BAD_ARGUMENTS = 2 };

/* ---- --help, --list, --version ---- */

static void print_help(void)
{
    puts("usage: render --technique NAME --scene SCENE --out FILE.png|FILE.pfm [options]\n"
         "       render --list | --help | --version\n"
         "\n"
         "  --technique NAME      csm, shadowfield, envshadow, rsm, ism or reference\n"
         "  --backend cpu|gl      default cpu\n"
         "  --scene SCENE         builtin:NAME, FILE.glb or FILE.gltf\n"
         "  --figure FILE[@x,y,z] what is skinned in a glTF file stands in the scene, too\n"
         "  --env SKY             builtin:NAME or a latitude-longitude FILE.hdr\n"
         "                        default where nothing else shines: builtin:sky; rsm, ism: sun:0.48,0.8,0.36\n"
         "  --light LIGHT         may be repeated; directions point to the sun and out of lamps; d, n, u, v, p, q are\n"
         "                        three numbers each; E, I, L one number or r,g,b:\n"
         "                          sun:d[,E]  spot:p,d,degrees[,I]  point:p[,I]  sphere:p,radius[,L]\n"
         "                          rect:p,u,v[,L]  disc:p,n,radius[,L]  line:p,q,radius[,L]\n"
         "  --baked FILE          data made by bake\n"
         "  --camera px,py,pz,tx,ty,tz,fovy_degrees\n"
         "  --size 640x360        width and height\n"
         "  --samples N           see --list for each technique's default\n"
         "  --frames N            frame i has seed + i and shows the time T + i / 30 s\n"
         "  --time T              default 0, in seconds\n"
         "  --seed N              default 0\n"
         "  --threads N           default 0: all cores; the result does not depend on it\n"
         "  --limit-memory MB     what reading a scene or sky may take, nearly; default 1000\n"
         "  --set key=value       may be repeated; see --list\n"
         "  --json FILE           figures of the run; - is stdout\n"
         "  --kept FOLDER         of technique reference: a picture that the folder has is not drawn again\n"
         "  --hash                last: nothing is drawn, the number by which the folder knows the picture is printed\n"
         "\n"
         "exit status: 0 done, 1 failed, 2 bad arguments");
}

static void print_keys(const char *title, const rd_key *keys)
{
    printf("\nsettings of %s (--set key=value):\n", title);
    rd_print_keys(keys);
}

static void print_names(const char *title, const char *const *names)
{
    printf("\n%s:\n ", title);
    for (; *names; names++)
        printf(" builtin:%s", *names);
    puts("");
}

static void print_list(void)
{
    const rd_technique *const *t;
    puts("techniques:");
    for (t = rd_techniques(); *t; t++) {
        printf("  %-12s %s", (*t)->name, (*t)->summary);
        if ((*t)->missing)
            printf(" (%s)", (*t)->missing);
        else if ((*t)->most_samples && (*t)->samples < (*t)->least_samples)
            printf(" (--samples by its settings)");
        else if ((*t)->most_samples)
            printf(" (--samples %u)", (unsigned)(*t)->samples);
        puts("");
    }
    print_names("scenes", ex_scene_names());
    print_names("skies", ex_sky_names());
    print_keys("every technique", rd_common_keys);
    for (t = rd_techniques(); *t; t++)
        if ((*t)->keys)
            print_keys((*t)->name, (*t)->keys);
}

/* ---- one run ---- */

typedef struct run {
    const rd_args *args;
    ex_scene       scene;
    rd_emitter    *emitters;
    ex_gbuffer     gbuffer;
    rd_job         job;
    void          *state;
    ex_image       frame;              /* as large as the G-buffer */
    double        *sum;                /* of averaged frames */
    ex_image       picture;
    double         precompute_ms, *frame_ms;
    uint32_t       first;              /* frame that is drawn; those before it are passed by */
    rd_kept        kept;
    ex_gl         *context;            /* --backend gl, else NULL */
    glbk_context   gl;
} run;

/* A context of its own for the technique, and gl_backend.h on it. */
static int open_gl(run *r, char *error)
{
    ex_gl_options options = { EX_GL_HEADLESS, 0, 0, 0, 0, 0, 0, 0, 0, NULL };
    glbk_desc desc;
    glbk_result result;
    if (!r->args->use_gl)
        return 0;
    r->context = ex_gl_create(&options, error);
    if (!r->context)
        return -1;
    memset(&desc, 0, sizeof desc);
    desc.get_proc_fn = ex_gl_get_proc;
    desc.user = r->context;
    desc.system.log = ex_gl_log;
    desc.core_only = rd_setting_is(&r->args->settings, "compute", "0");
    result = glbk_init(&r->gl, &desc);
    if (result == GLBK_OK && rd_setting_is(&r->args->settings, "compute", "auto") &&
        ex_gl_is_software(r->gl.renderer)) {
        glbk_free(&r->gl);       /* which run groups of compute one invocation after the other: slower but for csm */
        desc.core_only = 1;
        result = glbk_init(&r->gl, &desc);
    }
    if (result != GLBK_OK) {
        snprintf(error, EX_ERROR_SIZE, "--backend gl: %s", glbk_result_text(result));
        return -1;
    }
    r->job.gl = &r->gl;
    return 0;
}

static int open_technique(run *r, double *ms, char *error)
{
    double start = ex_seconds();
    int result = r->args->technique->open(&r->state, &r->job, error);
    *ms = 1000 * (ex_seconds() - start);
    if (result != 0)
        r->state = NULL;
    return result;
}

static void close_technique(run *r)
{
    if (r->args->technique->close)
        r->args->technique->close(r->state);
    r->state = NULL;
}

static float frame_time(const rd_args *args, uint32_t frame)
{
    return args->time + (float)frame / 30.0f;
}

/* The scene at a frame's time, and what the camera sees of it. */
static int load(run *r, uint32_t frame, char *error)
{
    float time = frame_time(r->args, frame);
    uint32_t aa = (uint32_t)rd_setting_integer(&r->args->settings, "aa");
    int result = frame == 0 ? rd_setup(&r->scene, &r->job, &r->emitters, r->args, time, error)
                            : rd_move(&r->scene, &r->job, &r->emitters, time, error);
    ex_gbuffer_free(&r->gbuffer);
    if (result != 0)
        return -1;
    return ex_gbuffer_render(&r->gbuffer, &r->scene, r->args->width, r->args->height, aa, r->args->threads, error);
}

/* Moves an animated scene on; techniques without update are opened anew. Its time belongs to the frame. */
static int advance(run *r, double *ms, char *error)
{
    const rd_technique *technique = r->args->technique;
    double start;
    *ms = 0;
    if (r->job.frame == 0 || !r->scene.animated)
        return 0;
    if (!technique->update)
        close_technique(r);
    if (load(r, r->job.frame, error) != 0)
        return -1;
    start = ex_seconds();
    if (technique->update) {
        int result = technique->update(r->state, &r->job, error);
        *ms = 1000 * (ex_seconds() - start);
        return result;
    }
    return open_technique(r, ms, error);
}

static int draw(run *r, char *error)
{
    memset(r->frame.rgb, 0, 3 * (size_t)r->gbuffer.width * r->gbuffer.height * sizeof *r->frame.rgb);
    return r->args->technique->frame(r->state, &r->job, &r->frame, error);
}

/* What drivers put off until the first use is theirs, not the technique's. */
static int warm_up(run *r, char *error)
{
    int times = rd_setting_integer(&r->args->settings, "warm_up");
    r->job.frame = 0;
    r->job.seed = r->args->seed;
    for (; times > 0; times--)
        if (draw(r, error) != 0)
            return -1;
    return 0;
}

static int render_frames(run *r, char *error)
{
    size_t values = 3 * (size_t)r->gbuffer.width * r->gbuffer.height;
    int average = r->args->technique->averages && !r->scene.animated;
    double weight = average ? 1.0 / r->args->frames : 1;
    if (warm_up(r, error) != 0)
        return -1;
    for (uint32_t i = r->first; i < r->args->frames; i++) {
        double start, update_ms;
        r->job.frame = i;
        r->job.seed = r->args->seed + i;
        if (advance(r, &update_ms, error) != 0)
            return -1;
        start = ex_seconds();
        if (draw(r, error) != 0)
            return -1;
        r->frame_ms[i - r->first] = update_ms + 1000 * (ex_seconds() - start);
        for (size_t k = 0; k < values; k++)
            r->sum[k] = (average && i ? r->sum[k] : 0) + weight * (double)r->frame.rgb[k];
    }
    return 0;
}

/* Direction of the ray through the centre of a G-buffer pixel. */
static void ray_direction(const run *r, uint32_t x, uint32_t y, float out[3])
{
    const ex_camera *camera = &r->scene.camera;
    double back[3], right[3], up[3], length = 0, half = tan(0.5 * (double)camera->fovy);
    double height = r->gbuffer.height, sx = (2 * x + 1.0 - r->gbuffer.width) / height * half;
    double sy = (height - 2 * y - 1.0) / height * half;
    for (int k = 0; k < 3; k++)
        back[k] = (double)camera->eye[k] - (double)camera->target[k];
    for (int k = 0; k < 3; k++)
        right[k] = (double)camera->up[(k + 1) % 3] * back[(k + 2) % 3] -
                   (double)camera->up[(k + 2) % 3] * back[(k + 1) % 3];
    for (int k = 0; k < 3; k++)
        up[k] = back[(k + 1) % 3] * right[(k + 2) % 3] - back[(k + 2) % 3] * right[(k + 1) % 3];
    sx /= sqrt(right[0] * right[0] + right[1] * right[1] + right[2] * right[2]);
    sy /= sqrt(up[0] * up[0] + up[1] * up[1] + up[2] * up[2]);
    length = sqrt(back[0] * back[0] + back[1] * back[1] + back[2] * back[2]);
    for (int k = 0; k < 3; k++)
        back[k] = sx * right[k] + sy * up[k] - back[k] / length;
    length = sqrt(back[0] * back[0] + back[1] * back[1] + back[2] * back[2]);
    for (int k = 0; k < 3; k++)
        out[k] = (float)(back[k] / length);
}

static void add_seen_light(run *r)
{
    int background = rd_setting_integer(&r->args->settings, "background");
    int emission = rd_setting_integer(&r->args->settings, "emission");
    for (size_t i = 0; i < (size_t)r->gbuffer.width * r->gbuffer.height; i++) {
        const ex_pixel *pixel = &r->gbuffer.pixels[i];
        float radiance[3] = { 0, 0, 0 }, direction[3];
        if (pixel->object != UINT32_MAX && emission) {
            memcpy(radiance, pixel->emission, sizeof radiance);
        } else if (pixel->object == UINT32_MAX && background) {
            ray_direction(r, (uint32_t)(i % r->gbuffer.width), (uint32_t)(i / r->gbuffer.width), direction);
            ex_sky_radiance(&r->scene.sky, direction, radiance);
        }
        for (size_t k = 0; k < 3; k++)
            r->sum[3 * i + k] += (double)radiance[k];
    }
}

static void average_sub_pixels(run *r)
{
    size_t aa = r->job.aa, wide = r->gbuffer.width;
    for (size_t y = 0; y < r->args->height; y++)
        for (size_t x = 0; x < r->args->width; x++)
            for (size_t k = 0; k < 3; k++) {
                double sum = 0;
                for (size_t i = 0; i < aa * aa; i++)
                    sum += r->sum[3 * ((y * aa + i / aa) * wide + x * aa + i % aa) + k];
                r->picture.rgb[3 * (y * r->args->width + x) + k] = (float)(sum / (double)(aa * aa));
            }
}

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, uint32_t count)
{
    qsort(values, count, sizeof *values, compare_doubles);
    return 0.5 * (values[count / 2] + values[(count - 1) / 2]);
}

/* What is said of a picture however it was come by. */
static void say_picture(rd_json *json, const run *r, double ev)
{
    const rd_args *args = r->args;
    rd_json_text(json, "technique", args->technique->name);
    rd_json_text(json, "backend", args->use_gl ? "gl" : "cpu");
    rd_json_text(json, "gl_renderer", r->job.gl ? r->gl.renderer : NULL);
    rd_json_text(json, "path", !r->job.gl ? NULL : r->gl.compute ? "compute" : "core");
    rd_json_text(json, "scene", args->scene);
    rd_json_integer(json, "triangles", ex_scene_triangles(&r->scene));
    rd_json_integer(json, "width", args->width);
    rd_json_integer(json, "height", args->height);
    rd_json_integer(json, "samples", r->kept.picture.rgb ? r->kept.samples : args->samples);
    rd_json_number(json, "ev", ev);
}

static int write_json(run *r, double ev, char *error)
{
    rd_json json = { NULL, 0, 0, 0 };
    int result;
    say_picture(&json, r, ev);
    if (r->kept.picture.rgb) {
        rd_json_number(&json, "kept_ms", r->kept.milliseconds);
        rd_json_number(&json, "noise", r->kept.noise);
    } else {
        rd_json own = { NULL, 0, 0, 0 };       /* the sizes come first, but one call reports both */
        rd_report report = { 0, 0, &own };
        rd_json_number(&json, "precompute_ms", r->precompute_ms);
        rd_json_number(&json, "frame_ms", median(r->frame_ms, r->args->frames - r->first));
        r->args->technique->report(r->state, &report);
        rd_json_integer(&json, "memory_bytes", report.memory_bytes);
        rd_json_integer(&json, "peak_bytes", report.peak_bytes);
        rd_json_append(&json, &own);
        rd_json_free(&own);
    }
    result = rd_json_write(&json, r->args->json, error);
    rd_json_free(&json);
    return result;
}

static int allocate(run *r, char *error)
{
    r->frame_ms = calloc(r->args->frames, sizeof *r->frame_ms);
    r->sum = calloc((size_t)r->gbuffer.width * r->gbuffer.height, 3 * sizeof *r->sum);
    if (r->frame_ms && r->sum && ex_image_alloc(&r->frame, r->gbuffer.width, r->gbuffer.height) == 0 &&
        ex_image_alloc(&r->picture, r->args->width, r->args->height) == 0)
        return 0;
    snprintf(error, EX_ERROR_SIZE, "out of memory");
    return -1;
}

/* The picture is there but for its exposure: writes it, and what there is to say. */
static int write(run *r, char *error)
{
    const rd_args *args = r->args;
    float ev = rd_setting_is(&args->settings, "ev", "auto") ? ex_image_auto_ev(&r->picture)
                                                            : (float)rd_setting_number(&args->settings, "ev");
    if (ex_image_write(&r->picture, args->out, ev, error) != 0)
        return -1;
    return args->json ? write_json(r, (double)ev, error) : 0;
}

/* --hash and --kept: what the last frame shows. Returns 1 where nothing is left to do, 0, or -1. */
static int find_kept(run *r, char *error)
{
    const rd_args *args = r->args;
    uint64_t hash;
    if (!args->hash && !args->kept)
        return 0;
    if (args->frames > 1 && r->scene.animated &&
        rd_move(&r->scene, &r->job, &r->emitters, frame_time(args, args->frames - 1), error) != 0)
        return -1;
    hash = rd_picture_hash(args, &r->job);
    if (args->hash)
        return printf("%016" PRIx64 "\n", hash), 1;
    if (rd_kept_read(&r->kept, args->kept, hash, args->width, args->height, error) != 0)
        return -1;
    if (!r->kept.picture.rgb)
        return args->frames > 1 && r->scene.animated
                   ? rd_move(&r->scene, &r->job, &r->emitters, frame_time(args, 0), error) : 0;
    memcpy(r->picture.rgb, r->kept.picture.rgb, 3 * (size_t)args->width * args->height * sizeof(float));
    return write(r, error) == 0 ? 1 : -1;
}

static int render(run *r, char *error)
{
    const rd_args *args = r->args;
    int found;
    if (load(r, 0, error) != 0 || allocate(r, error) != 0)
        return -1;
    r->job.scene = &r->scene;
    r->job.gbuffer = &r->gbuffer;
    r->job.settings = &args->settings;
    r->job.baked = args->baked;
    r->job.baked_count = args->baked_count;
    r->job.aa = (uint32_t)rd_setting_integer(&args->settings, "aa");
    r->job.samples = (args->samples + r->job.aa * r->job.aa - 1) / (r->job.aa * r->job.aa);
    r->job.frames = args->frames;
    r->job.seed = args->seed;
    r->first = r->scene.animated && args->technique->last_alone ? args->frames - 1 : 0;
    found = find_kept(r, error);
    if (found != 0)
        return found > 0 ? 0 : -1;
    r->job.pool = ex_pool_create(args->threads);
    if (!r->job.pool) {
        snprintf(error, EX_ERROR_SIZE, "out of memory");
        return -1;
    }
    r->job.threads = ex_pool_threads(r->job.pool);
    if (open_gl(r, error) != 0 || open_technique(r, &r->precompute_ms, error) != 0 || render_frames(r, error) != 0)
        return -1;
    add_seen_light(r);
    average_sub_pixels(r);
    return write(r, error);
}

static void release(run *r)
{
    if (r->state)
        close_technique(r);
    glbk_free(&r->gl);
    ex_gl_free(r->context);
    ex_pool_free(r->job.pool);
    ex_image_free(&r->kept.picture);
    ex_image_free(&r->picture);
    ex_image_free(&r->frame);
    ex_gbuffer_free(&r->gbuffer);
    ex_scene_free(&r->scene);
    free(r->emitters);
    free(r->sum);
    free(r->frame_ms);
}

static int complain(const char *error)
{
    ex_complain("render", error);
    return -1;
}

int main(int count, char **values)
{
    char error[EX_ERROR_SIZE] = "";
    rd_args args;
    run r;
    int status = FAILED;
    if (count == 2 && strcmp(values[1], "--help") == 0)
        return print_help(), DONE;
    if (count == 2 && strcmp(values[1], "--list") == 0)
        return print_list(), DONE;
    if (count == 2 && strcmp(values[1], "--version") == 0)
        return printf("render %s\n", dapple_version), DONE;
    memset(&r, 0, sizeof r);
    r.args = &args;
    if (rd_args_parse(&args, count, values, error) != 0) {
        complain(error);
        status = BAD_ARGUMENTS;
    } else if (args.technique->missing) {
        snprintf(error, sizeof error, "%s: %s", args.technique->name, args.technique->missing);
        complain(error);
    } else if (args.use_gl && !rd_technique_has_gl(args.technique)) {
        snprintf(error, sizeof error, "--backend gl: technique %s has no GL path", args.technique->name);
        complain(error);
    } else if (render(&r, error) != 0) {
        complain(error);
    } else {
        status = DONE;
    }
    release(&r);
    rd_args_free(&args);
    return status;
}
