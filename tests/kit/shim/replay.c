/* replay - main() for a fuzz target without a fuzzer: runs it on the files named, or on the folder's files that the
   shell expands. Exit status 77 (skipped) where there are none. */

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static int run_file(const char *path)
{
    FILE *f = fopen(path, "rb");
    uint8_t *data;
    long size;

    if (!f) return 0;
    fseek(f, 0, SEEK_END);
    size = ftell(f);
    rewind(f);
    /* Exactly size bytes, so that a sanitizer sees the first one read beyond. */
    data = size < 0 ? NULL : (uint8_t *)malloc(size > 0 ? (size_t)size : 1);
    if (!data || fread(data, 1, (size_t)size, f) != (size_t)size) {
        free(data);
        fclose(f);
        return 0;
    }
    fclose(f);
    LLVMFuzzerTestOneInput(data, (size_t)size);
    free(data);
    return 1;
}

int main(int argc, char **argv)
{
    int i;

    for (i = 1; i < argc; i++) {
        if (!run_file(argv[i])) {
            fprintf(stderr, "replay: cannot read %s\n", argv[i]);
            return 1;
        }
    }
    if (argc < 2) {
        printf("skip: no corpus\n");
        return 77;
    }
    printf("replayed %d files\n", argc - 1);
    return 0;
}
