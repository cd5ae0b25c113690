/* techniques.c - the table of techniques. */
#include "technique.h"

#include <string.h>

/* A technique that lives in a file of its own declares its rd_technique in technique.h, as rd_reference does. */
#define NOT_YET(name, summary) \
    static const rd_technique name = { #name, summary, "not in this build yet", 0, 0, 0, 0, 0, \
                                       NULL, NULL, NULL, NULL, NULL, NULL };

NOT_YET(shadowfield, "precomputed shadow fields of moving objects")

const rd_technique *const *rd_techniques(void)
{
    static const rd_technique *const all[] = { &rd_csm, &shadowfield, &rd_envshadow, &rd_rsm, &rd_ism,
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
    static const rd_technique *const with_gl[] = { &rd_csm, NULL };
    for (size_t i = 0; with_gl[i]; i++)
        if (with_gl[i] == technique)
            return 1;
    return 0;
}
