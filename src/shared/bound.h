/* unit bound, needs message: the line for a number that is beyond what an object or an earlier call allows */

/* Logs "FUNCTION: FIELD is VALUE; it must be RELATION BOUND, NAME", as in "cohsm_view: view is 9; it must be
   below 8, the number of views". */
static inline P_COLD void P_log_bound(const P_logger *logger, const char *field, uint64_t value,
                                      const char *relation, uint64_t bound, const char *name)
{
    P_message m;
    m.used = 0;
    P_message_text(&m, relation);
    P_message_text(&m, " ");
    P_message_count(&m, bound);
    P_message_text(&m, ", ");
    P_message_text(&m, name);
    P_log_value(logger, field, (double)value, m.text);
}
