/* unit message: one line for the caller's log that says why a call failed */

/* P_COLD stands before functions that are needed only by calls that fail: compilers make these functions
   small, and take branches to them for unlikely. */
#if defined(__GNUC__) && !defined(__TINYC__)
#define P_COLD __attribute__((cold))
#else
#define P_COLD
#endif

/* Where a message goes, and the name of the function that failed. If log is NULL, nothing is written. */
typedef struct P_logger {
    void (*log)(void *user, const char *message);
    void *user;
    const char *function;
} P_logger;

typedef struct P_message { char text[256]; size_t used; } P_message;

/* Appends a text; what does not fit is cut off. */
static inline P_COLD void P_message_text(P_message *m, const char *s)
{
    while (*s && m->used + 1 < sizeof m->text) m->text[m->used++] = *s++;
    m->text[m->used] = 0;
}

static inline P_COLD void P_message_count(P_message *m, uint64_t value)
{
    char digits[24];
    size_t at = sizeof digits - 1;
    digits[at] = 0;
    do digits[--at] = (char)('0' + (int)(value % 10));
    while ((value /= 10) != 0);
    P_message_text(m, digits + at);
}

/* Writes six significant digits without the zeros at their end. Returns how many digits are left and writes
   *exponent, the power of ten of the first one. value is finite and above 0. */
static inline P_COLD int P_message_digits(double value, char digits[8], int *exponent)
{
    uint32_t whole;
    int count = 6, i;

    for (*exponent = 5; value >= 999999.5; value /= 10.0) ++*exponent;
    for (; value < 99999.95; value *= 10.0) --*exponent;
    whole = (uint32_t)(value + 0.5);
    if (whole > 999999) {
        whole = 100000;
        ++*exponent;
    }
    for (; count > 1 && whole % 10 == 0; count--) whole /= 10;
    for (i = count; i > 0; whole /= 10) digits[--i] = (char)('0' + (int)(whole % 10));
    digits[count] = 0;
    return count;
}

/* Appends a number, in the same way in every locale: whole numbers below 2^53 with all their digits, others
   with six, as in 0.25, -3, 1.5e-7. */
static inline P_COLD void P_message_number(P_message *m, double value)
{
    char digits[8], first[2] = { 0, 0 };
    int exponent, count, i;

    if (value != value) {
        P_message_text(m, "not a number");
        return;
    }
    if (value < 0.0) P_message_text(m, "-");
    if (value < 0.0) value = -value;
    if (!(value > 0.0) || value > 1.7976931348623157e308) {
        P_message_text(m, value > 0.0 ? "infinity" : "0");
        return;
    }
    if (value < 9007199254740992.0 && value - (double)(uint64_t)value <= 0.0) {
        P_message_count(m, (uint64_t)value);
        return;
    }
    count = P_message_digits(value, digits, &exponent);
    first[0] = digits[0];
    if (exponent < -4 || exponent > 9) {
        P_message_text(m, first);
        if (count > 1) P_message_text(m, ".");
        P_message_text(m, digits + 1);
        P_message_text(m, exponent < 0 ? "e-" : "e");
        P_message_count(m, (uint64_t)(exponent < 0 ? -exponent : exponent));
        return;
    }
    if (exponent < 0) P_message_text(m, "0.");
    for (i = exponent; i < -1; i++) P_message_text(m, "0");
    for (i = 0; i < count; i++) {
        if (exponent >= 0 && i == exponent + 1) P_message_text(m, ".");
        first[0] = digits[i];
        P_message_text(m, first);
    }
    for (i = count; i <= exponent; i++) P_message_text(m, "0");
}

/* Begins a line: "FUNCTION: FIELD". */
static inline P_COLD void P_message_begin(P_message *m,
                                          const P_logger *logger, const char *field)
{
    m->used = 0;
    P_message_text(m, logger->function);
    P_message_text(m, ": ");
    P_message_text(m, field);
}

/* Logs "FUNCTION: FIELD TEXT", as in "cohsm_build: mesh.positions is NULL". */
static inline P_COLD void P_log_text(const P_logger *logger, const char *field, const char *text)
{
    P_message m;
    if (!logger->log) return;
    P_message_begin(&m, logger, field);
    P_message_text(&m, " ");
    P_message_text(&m, text);
    logger->log(logger->user, m.text);
}

/* Logs "FUNCTION: FIELD is VALUE; it must be WANTED", as in "cohsm_build: desc.map_side is 3; it must be 0 or
   4..1024". */
static inline P_COLD void P_log_value(const P_logger *logger, const char *field, double value,
                                      const char *wanted)
{
    P_message m;
    if (!logger->log) return;
    P_message_begin(&m, logger, field);
    P_message_text(&m, " is ");
    P_message_number(&m, value);
    P_message_text(&m, "; it must be ");
    P_message_text(&m, wanted);
    logger->log(logger->user, m.text);
}

/* Logs "FUNCTION: ARRAY[INDEX] WHAT VALUE; it must be WANTED", as in "rsm_gather: normals[17] has the length
   0.5; it must be 1 (0.97..1.03), or 0". */
static inline P_COLD void P_log_element(const P_logger *logger, const char *array, uint64_t index,
                                        const char *what, double value, const char *wanted)
{
    P_message m;
    if (!logger->log) return;
    P_message_begin(&m, logger, array);
    P_message_text(&m, "[");
    P_message_count(&m, index);
    P_message_text(&m, "] ");
    P_message_text(&m, what);
    P_message_text(&m, " ");
    P_message_number(&m, value);
    P_message_text(&m, "; it must be ");
    P_message_text(&m, wanted);
    logger->log(logger->user, m.text);
}

/* Logs "FUNCTION: ARRAY[INDEX] TEXT", as in "cohsm_merge: shards[3] is NULL". */
static inline P_COLD void P_log_element_text(const P_logger *logger, const char *array, uint64_t index,
                                             const char *text)
{
    P_message m;
    if (!logger->log) return;
    P_message_begin(&m, logger, array);
    P_message_text(&m, "[");
    P_message_count(&m, index);
    P_message_text(&m, "] ");
    P_message_text(&m, text);
    logger->log(logger->user, m.text);
}

/* Logs "FUNCTION: mesh: index 2 of triangle 17 is 90, but the mesh has 80 vertices". position counts the
   indices from 0. */
static inline P_COLD void P_log_index(const P_logger *logger, const char *mesh,
                                      uint64_t position, uint64_t index, uint64_t vertex_count)
{
    P_message m;
    if (!logger->log) return;
    P_message_begin(&m, logger, mesh);
    P_message_text(&m, ": index ");
    P_message_count(&m, position % 3);
    P_message_text(&m, " of triangle ");
    P_message_count(&m, position / 3);
    P_message_text(&m, " is ");
    P_message_count(&m, index);
    P_message_text(&m, ", but the mesh has ");
    P_message_count(&m, vertex_count);
    P_message_text(&m, vertex_count == 1 ? " vertex" : " vertices");
    logger->log(logger->user, m.text);
}
