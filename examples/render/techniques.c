/* techniques.c - the table of techniques. */
#include "technique.h"

#include <string.h>

const rd_technique *const *rd_techniques(void)
{
    static const rd_technique *const all[] = { &rd_csm, &rd_shadowfield, &rd_envshadow, &rd_rsm, &rd_ism,
                                               &rd_reference, NULL };
    return all;
}

const rd_technique *rd_technique_find(const char *name)
{
    const rd_technique *const *all = rd_techniques();
    while (*all && strcmp((*all)->name, name) != 0)
        all++;
    return *all;
}

/* Techniques whose functions look at job->gl add themselves here: "&rd_csm, ". */
int rd_technique_has_gl(const rd_technique *technique)
{
    static const rd_technique *const with_gl[] = { &rd_csm, &rd_shadowfield, &rd_envshadow, &rd_rsm, &rd_ism, NULL };
    for (size_t i = 0; with_gl[i]; i++)
        if (with_gl[i] == technique)
            return 1;
    return 0;
}
