/* timer_test - times of benchmarks: by timer queries on real GPUs, by glFinish on software drivers and on ES, which is
   decided by names and by what a fake GL has. */
#define _POSIX_C_SOURCE 200809L
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <time.h>

#include <cmocka.h>

#include "gl_timer.h"

/* ---- a GL with queries alone ---- */

static struct { int made, begun, ended, read, finished; const char *missing; } fake;

static void GLBK_CALL gen(int32_t count, uint32_t *names)
{
    assert_int_equal(count, 1);
    *names = 7;
    fake.made++;
}

static void GLBK_CALL destroy(int32_t count, const uint32_t *names)
{
    assert_true(count == 1 && *names == 7);
    fake.made--;
}

static void GLBK_CALL begin(uint32_t target, uint32_t name)
{
    assert_true(target == 0x88BF /* TIME_ELAPSED */ && name == 7);
    fake.begun++;
}

static void GLBK_CALL end(uint32_t target)
{
    assert_int_equal(target, 0x88BF);
    assert_int_equal(fake.begun, fake.ended + 1);
    fake.ended++;
}

static void GLBK_CALL result(uint32_t name, uint32_t what, uint64_t *out)
{
    assert_true(name == 7 && what == 0x8866 /* QUERY_RESULT, which waits */);
    assert_int_equal(fake.begun, fake.ended);
    fake.read++;
    *out = 5000000000u;                     /* 5 s: more than 32 bits of nanoseconds */
}

/* 20 ms of work are waited for. */
static void GLBK_CALL finish(void)
{
    const struct timespec wait = { 0, 20000000 };
    if (fake.finished++ % 2) nanosleep(&wait, NULL);
}

static glbk_proc_fn get(const char *name, void *user)
{
    assert_ptr_equal(user, &fake);
    if (fake.missing && strcmp(name, fake.missing) == 0) return NULL;
    if (strcmp(name, "glGenQueries") == 0) return (glbk_proc_fn)gen;
    if (strcmp(name, "glDeleteQueries") == 0) return (glbk_proc_fn)destroy;
    if (strcmp(name, "glBeginQuery") == 0) return (glbk_proc_fn)begin;
    if (strcmp(name, "glEndQuery") == 0) return (glbk_proc_fn)end;
    if (strcmp(name, "glGetQueryObjectui64v") == 0) return (glbk_proc_fn)result;
    fail_msg("%s", name);
    return NULL;
}

static double time_once(const char *renderer, int es, const char *missing)
{
    glbk_context gl;
    ex_gl_timer timer;
    double seconds;
    memset(&gl, 0, sizeof gl);
    memset(&fake, 0, sizeof fake);
    fake.missing = missing;
    gl.renderer = renderer;
    gl.es = es;
    gl.gl.Finish = finish;
    ex_gl_timer_open(&timer, &gl, get, &fake);
    ex_gl_timer_start(&timer);
    seconds = ex_gl_timer_stop(&timer);
    ex_gl_timer_close(&timer);
    assert_int_equal(fake.made, 0);
    return seconds;
}

static void real_gpus_are_asked(void **state)
{
    static const char *const names[] = { "NVIDIA H100 80GB HBM3/PCIe/SSE2", "AMD Radeon RX 7900 XT (radeonsi, navi31)",
                                         "Mesa Intel(R) UHD Graphics 620 (KBL GT2)", "GeForce 8800 GTX/PCIe/SSE2" };
    (void)state;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        assert_true(time_once(names[i], 0, NULL) == 5.0);
        assert_true(fake.begun == 1 && fake.ended == 1 && fake.read == 1 && fake.finished == 0);
    }
}

static void others_are_waited_for(void **state)
{
    static const struct { const char *renderer; int es; const char *missing; } others[] = {
        { "llvmpipe (LLVM 15.0.6, 256 bits)", 0, NULL }, { "softpipe", 0, NULL },
        { "Google SwiftShader", 0, NULL }, { NULL, 1, NULL },
        { "NVIDIA H100", 1, NULL }, { "NVIDIA H100", 0, "glGenQueries" }, { "NVIDIA H100", 0, "glGetQueryObjectui64v" }
    };
    (void)state;
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) {
        double seconds = time_once(others[i].renderer, others[i].es, others[i].missing);
        assert_true(fake.begun == 0 && fake.read == 0 && fake.finished == 2);
        assert_true(seconds >= 0.02 && seconds < 2);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(real_gpus_are_asked),
                                        cmocka_unit_test(others_are_waited_for) };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
