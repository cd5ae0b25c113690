/* dapple.c - what dapple.mjs calls: maps of a mesh, and those maps for shaders of a page's own, on a WebGL 2 context
   that belongs to the page. All functions return 0, or -1 (NULL) with a line that dp_error returns. */
#define CSM_IMPLEMENTATION
#include "../csm.h"
#define GL_BACKEND_IMPLEMENTATION
#define GL_PROGRAMS_IMPLEMENTATION
#define GL_GBUFFER_IMPLEMENTATION
#define GL_CSM_IMPLEMENTATION
#include "../gl_backend/gl_csm.h"

#include <emscripten.h>
#include <emscripten/html5.h>
#include <stdio.h>
#ifdef __EMSCRIPTEN_PTHREADS__
#include "common.h"                 /* its pool of threads */
#endif

static char error[256];

/* The page is told how far a build is; not 0 ends it. */
EM_JS(int, tell_progress, (float fraction), { return Module.onProgress && Module.onProgress(fraction) ? 1 : 0; })

static int progress(void *user, float fraction)
{
    (void)user;
    return tell_progress(fraction);
}

static void hear(void *user, const char *message)
{
    (void)user;
    snprintf(error, sizeof error, "%s", message);
}

static int fail(const char *text)
{
    if (!error[0]) snprintf(error, sizeof error, "%s", text);
    return -1;
}

static glbk_proc_fn get_proc(const char *name, void *user)
{
    (void)user;
    return (glbk_proc_fn)emscripten_webgl_get_proc_address(name);
}

EMSCRIPTEN_KEEPALIVE const char *dp_error(void) { return error; }

/* ---- maps of a mesh ---- */

#ifdef __EMSCRIPTEN_PTHREADS__
static ex_pool *pool;
static int build_number;
static int took_part;               /* threads that ran a task of this build */

/* How many threads, the caller's included, builds have from now on; 1 ends the others. Returns how many there are. The
   page must have started a worker for each but the caller, since none starts before the caller returns to the browser. */
EMSCRIPTEN_KEEPALIVE int dp_threads(int threads)
{
    ex_pool_free(pool);
    pool = threads > 1 ? ex_pool_create(threads) : NULL;
    return ex_pool_threads(pool);
}

EMSCRIPTEN_KEEPALIVE int dp_took_part(void) { return took_part; }

typedef struct counted_task { cohsm_task task; void *context; } counted_task;

static void run_counted(void *context, size_t index)
{
    static __thread int counted;    /* the last build that this thread was counted in */
    const counted_task *one = (const counted_task *)context;
    if (counted != build_number) __atomic_add_fetch(&took_part, 1, __ATOMIC_RELAXED);
    counted = build_number;
    one->task(one->context, index);
}

static void run_in_pool(void *user, size_t count, cohsm_task task, void *context)
{
    counted_task one = { task, context };
    ex_pool_run(user, count, run_counted, &one);
}

static void use_threads(cohsm_system *system)
{
    build_number++;
    took_part = 0;
    if (!pool) return;
    system->parallel_for = run_in_pool;
    system->user = pool;
}
#else
static void use_threads(cohsm_system *system) { (void)system; }
#endif

/* positions: x, y, z of each vertex; indices may be NULL. side 0 and map_side 0: 128. */
EMSCRIPTEN_KEEPALIVE cohsm_maps *dp_build(const float *positions, unsigned vertex_count, const uint32_t *indices,
                                          unsigned index_count, unsigned side, unsigned map_side, int layers)
{
    cohsm_desc desc;
    cohsm_mesh mesh;
    cohsm_maps *maps = NULL;
    cohsm_result result;
    memset(&desc, 0, sizeof desc);
    memset(&mesh, 0, sizeof mesh);
    error[0] = 0;
    desc.system.progress = progress;
    desc.system.log = hear;
    use_threads(&desc.system);
    desc.domain.side[0] = desc.domain.side[1] = side;
    desc.map_side = map_side;
    desc.layers = (cohsm_layers)layers;
    desc.order = COHSM_ORDER_HILBERT;       /* the trial of orders would take a quarter of the time again */
    mesh.positions = positions;
    mesh.vertex_count = vertex_count;
    mesh.indices = indices;
    mesh.index_count = index_count;
    result = cohsm_build(&desc, &mesh, &maps, NULL);
    if (result != COHSM_OK) fail(cohsm_result_text(result));
    return maps;
}

/* A file of csm.h, which may come from anywhere. */
EMSCRIPTEN_KEEPALIVE cohsm_maps *dp_open(const void *data, unsigned bytes)
{
    cohsm_system system;
    cohsm_maps *maps = NULL;
    cohsm_result result;
    memset(&system, 0, sizeof system);
    error[0] = 0;
    system.log = hear;
    result = cohsm_open(data, bytes, &system, &maps);
    if (result != COHSM_OK) fail(cohsm_result_text(result));
    return maps;
}

EMSCRIPTEN_KEEPALIVE const void *dp_block(const cohsm_maps *maps)
{
    size_t bytes;
    return cohsm_data(maps, &bytes);
}

EMSCRIPTEN_KEEPALIVE unsigned dp_block_bytes(const cohsm_maps *maps)
{
    size_t bytes = 0;
    cohsm_data(maps, &bytes);
    return (unsigned)bytes;
}

EMSCRIPTEN_KEEPALIVE void dp_free(cohsm_maps *maps) { cohsm_free(maps); }

/* ---- maps for shaders ---- */

typedef struct dp_scene {           /* blocks on the GPU and where each begins */
    glbk_csm_maps maps;
    uint32_t     *starts;
    uint32_t      block_count;
} dp_scene;

/* On the context that is current. Units and bindings from these on are taken by what dp_bind binds, and no others. */
EMSCRIPTEN_KEEPALIVE glbk_context *dp_attach(unsigned first_unit, unsigned first_block)
{
    glbk_context *gl = (glbk_context *)calloc(1, sizeof *gl);
    glbk_desc desc;
    glbk_result result;
    memset(&desc, 0, sizeof desc);
    error[0] = 0;
    desc.get_proc_fn = get_proc;
    desc.system.log = hear;
    desc.first_unit = first_unit;
    desc.first_block = first_block;
    result = gl ? glbk_init(gl, &desc) : GLBK_ERR_ALLOC;
    if (result == GLBK_OK) return gl;
    fail(glbk_result_text(result));
    free(gl);
    return NULL;
}

/* The context is gone, and with it all objects: what is freed from now on calls GL no more. */
EMSCRIPTEN_KEEPALIVE void dp_lost(glbk_context *gl) { glbk_abandon(gl); }

EMSCRIPTEN_KEEPALIVE void dp_detach(glbk_context *gl)
{
    glbk_free(gl);
    free(gl);
}

EMSCRIPTEN_KEEPALIVE void dp_scene_free(glbk_context *gl, dp_scene *scene)
{
    if (!scene) return;
    glbk_csm_maps_free(gl, &scene->maps);
    free(scene->starts);
    free(scene);
}

/* blocks: maps whose blocks are uploaded; room for `capacity` instances of them. */
EMSCRIPTEN_KEEPALIVE dp_scene *dp_scene_create(glbk_context *gl, cohsm_maps **maps, unsigned count, unsigned capacity)
{
    dp_scene *scene = (dp_scene *)calloc(1, sizeof *scene);
    glbk_csm_block *blocks = (glbk_csm_block *)calloc(count + 1, sizeof *blocks);
    glbk_result result = GLBK_ERR_ALLOC;
    unsigned i;
    error[0] = 0;
    if (scene) scene->starts = (uint32_t *)calloc(count + 1, sizeof *scene->starts);
    if (scene && scene->starts && blocks) {
        for (i = 0; i < count; i++) blocks[i].data = cohsm_data(maps[i], &blocks[i].bytes);
        scene->block_count = count;
        result = glbk_csm_maps_create(gl, blocks, count, capacity, scene->starts, &scene->maps);
    }
    free(blocks);
    if (result == GLBK_OK) return scene;
    fail(glbk_result_text(result));
    dp_scene_free(gl, scene);
    return NULL;
}

/* matrices: 16 floats each, object to world; numbers: which block each instance has. */
EMSCRIPTEN_KEEPALIVE int dp_scene_place(glbk_context *gl, dp_scene *scene, const float *matrices,
                                        const uint32_t *numbers, unsigned count)
{
    glbk_csm_instance *instances = (glbk_csm_instance *)calloc(count + 1, sizeof *instances);
    glbk_result result = GLBK_ERR_ALLOC;
    unsigned i;
    error[0] = 0;
    for (i = 0; instances && i < count; i++) {
        if (numbers[i] >= scene->block_count) {
            free(instances);
            return fail("place: an instance names a block that there is not");
        }
        memcpy(instances[i].transform, matrices + 16 * (size_t)i, sizeof instances[i].transform);
        instances[i].start = scene->starts[numbers[i]];
    }
    if (instances) result = glbk_csm_maps_place(gl, &scene->maps, instances, count);
    free(instances);
    return result == GLBK_OK ? 0 : fail(glbk_result_text(result));
}

EMSCRIPTEN_KEEPALIVE const char *dp_scene_defines(const dp_scene *scene) { return scene->maps.defines; }

EMSCRIPTEN_KEEPALIVE void dp_bind(glbk_context *gl, const dp_scene *scene) { glbk_csm_bind(gl, &scene->maps, NULL); }

/* The library's functions as text, from the second line on: the first is #version, which the page's shader has. */
EMSCRIPTEN_KEEPALIVE const char *dp_glsl(const glbk_context *gl, const char *uses, const char *defines)
{
    static char *text;
    glbk_shader shader;
    const char *rest;
    size_t bytes;
    memset(&shader, 0, sizeof shader);
    error[0] = 0;
    shader.uses = uses;
    shader.defines = defines;
    shader.parts[0] = glbk_csm_part();
    bytes = glbk_write_glsl(GLBK_GLSL_300_ES, !gl->float_targets, &shader, NULL, 0);
    free(text);
    text = bytes ? (char *)malloc(bytes) : NULL;
    if (!text) {
        fail(bytes ? "out of memory" : "glsl: uses or defines name what there is not");
        return NULL;
    }
    glbk_write_glsl(GLBK_GLSL_300_ES, !gl->float_targets, &shader, text, bytes);
    rest = strchr(text, '\n');
    return rest ? rest + 1 : text;
}

EMSCRIPTEN_KEEPALIVE int dp_set_slots(glbk_context *gl, unsigned program)
{
    glbk_result result;
    error[0] = 0;
    result = glbk_set_slots(gl, glbk_csm_part(), NULL, program);
    return result == GLBK_OK ? 0 : fail(glbk_result_text(result));
}
