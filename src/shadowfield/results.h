/* ---- results ---- */

SFIELD_DEF const char *sfield_result_text(sfield_result result)
{
    static const char *const texts[] = {
#define SFIELD__TEXT(name, text) text,
        SFIELD_RESULTS(SFIELD__TEXT)
#undef SFIELD__TEXT
    };
    return (uint32_t)result < SFIELD_RESULT_COUNT ? texts[result] : "unknown result";
}
