/* file.c - a whole file into memory. */
#include "common.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void *ex_file_read(const char *path, size_t *size, char *error)
{
    FILE *file = fopen(path, "rb");
    char *data = NULL;
    size_t room = 0, got = 1;
    *size = 0;
    while (file && got) {
        if (*size == room) {
            char *grown = realloc(data, room = 2 * room + 65536);
            if (!grown)
                break;
            data = grown;
        }
        *size += got = fread(data + *size, 1, room - *size, file);
    }
    if (file && !got && !ferror(file)) {
        fclose(file);
        return data;
    }
    snprintf(error, EX_ERROR_SIZE, "cannot read %.150s: %s", path, errno ? strerror(errno) : "error");
    if (file)
        fclose(file);
    free(data);
    return NULL;
}
