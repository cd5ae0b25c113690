/* What tools/mutate links into every test: which mutant is awake (MUTANT=7, none without), and a note of each one whose
   place a run came to, in the file MUTANT_HITS. The file is mapped, so that a run that aborts, and processes that a
   test starts, leave their notes too. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

enum { MOST = 4096 };
__attribute__((aligned(4096))) unsigned char mutate_hit[MOST];
int mutate_active = -1;

__attribute__((constructor)) static void wake(void)
{
    const char *number = getenv("MUTANT"), *path = getenv("MUTANT_HITS");
    int file = path ? open(path, O_RDWR | O_CREAT, 0666) : -1;
    if (number) mutate_active = atoi(number);
    if (file < 0) return;
    if (ftruncate(file, MOST) != 0 ||
        mmap(mutate_hit, MOST, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_FIXED, file, 0) == MAP_FAILED)
        _exit(99);
    close(file);
}
