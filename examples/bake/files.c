/* files.c - see bake.h */
#define _POSIX_C_SOURCE 200809L
#include "bake.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

int bk_read(const char *path, void **data, size_t *size, char *error)
{
    FILE *file = fopen(path, "rb");
    char *bytes = NULL;
    size_t room = 0, got = 1;
    *data = NULL;
    *size = 0;
    while (file && got) {
        if (*size == room) {
            char *grown = realloc(bytes, room = 2 * room + 65536);
            if (!grown)
                break;
            bytes = grown;
        }
        *size += got = fread(bytes + *size, 1, room - *size, file);
    }
    if (file && !got && !ferror(file)) {
        fclose(file);
        *data = bytes;
        return 0;
    }
    snprintf(error, EX_ERROR_SIZE, "cannot read %.150s: %s", path, errno ? strerror(errno) : "error");
    if (file)
        fclose(file);
    free(bytes);
    return -1;
}

int bk_write(const char *path, const void *data, size_t size, char *error)
{
    char *name = malloc(strlen(path) + 32);
    FILE *file;
    int good;
    if (!name) {
        snprintf(error, EX_ERROR_SIZE, "out of memory");
        return -1;
    }
    sprintf(name, "%s.%ld.tmp", path, (long)getpid());
    errno = 0;
    file = fopen(name, "wb");
    good = file && fwrite(data, 1, size, file) == size && fflush(file) == 0 && fsync(fileno(file)) == 0;
    good = (!file || fclose(file) == 0) && good && rename(name, path) == 0;
    if (!good) {
        snprintf(error, EX_ERROR_SIZE, "cannot write %.150s: %s", path, errno ? strerror(errno) : "error");
        remove(name);
    }
    free(name);
    return good ? 0 : -1;
}
