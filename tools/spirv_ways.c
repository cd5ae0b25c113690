/* spirv_ways - how long a compiler searches that walks the blocks of a loop breadth first and marks a block only when
   it is taken from the queue: each branch whose ways join again after as many blocks puts the rest twice into it.
   SwiftShader, the software renderer of Chromium, searches so, from the head of each loop, for where the loop was
   entered from (the merge block bars the way, so it walks the whole loop).

   spirv_ways MODULE.spv...     prints log2 of the most blocks that one search takes up, of all loops of all modules

   Calls must be in line: spirv-opt --inline-entry-points-exhaustive. tools/gpu-cost calls it. */

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {          /* opcodes of SPIR-V, as its specification numbers them */
    OP_LOOP_MERGE = 246, OP_LABEL = 248, OP_BRANCH = 249, OP_BRANCH_CONDITIONAL = 250, OP_SWITCH = 251,
    OP_UNREACHABLE = 255
};

typedef struct block {
    size_t   end;               /* its last instruction; 0: no block */
    uint32_t merge;             /* of the loop that it heads, or 0 */
} block;

typedef struct program {
    uint32_t *words, ids;
    size_t    count;
    block    *blocks;           /* by id */
    double   *now, *next;       /* how often a block stands in the queue: of this round, and of the next one */
    uint32_t *order, *following;    /* the blocks of either, in the order in which they first came */
    uint8_t  *seen;
} program;

static void fail(const char *what)
{
    fprintf(stderr, "spirv_ways: %s\n", what);
    exit(1);
}

static void *make(size_t count, size_t bytes)
{
    void *memory = calloc(count, bytes);
    if (!memory) fail("out of memory");
    return memory;
}

/* The blocks that block id branches to. */
static uint32_t outs(const program *p, uint32_t id, uint32_t *to, uint32_t room)
{
    const uint32_t *w = p->words + p->blocks[id].end;
    const uint32_t op = w[0] & 0xffffu, length = w[0] >> 16;
    uint32_t i, count = 0;
    if (op == OP_BRANCH) to[count++] = w[1];
    if (op == OP_BRANCH_CONDITIONAL) to[count++] = w[2], to[count++] = w[3];
    if (op == OP_SWITCH)
        for (i = 2; i < length && count < room; i += 2) to[count++] = w[i];
    return count;
}

/* Blocks that the search from a loop's head takes from its queue. Equal blocks of a round are taken together. */
static double search(program *p, uint32_t head)
{
    enum { ROOM = 256 };
    uint32_t count = 1, i, k, n, to[ROOM];
    double all = 0;
    memset(p->seen, 0, p->ids);
    p->seen[p->blocks[head].merge] = 1;
    p->order[0] = head;
    p->now[head] = 1;
    while (count > 0) {
        uint32_t following = 0, *swap;
        double *other;
        for (i = 0; i < count; i++) {
            const uint32_t id = p->order[i];
            n = outs(p, id, to, ROOM);
            for (k = 0; k < n; k++) {
                if (p->seen[to[k]]) continue;
                if (!(p->next[to[k]] > 0)) p->following[following++] = to[k];
                p->next[to[k]] += p->now[id];
            }
            p->seen[id] = 1;
            all += p->now[id];
            p->now[id] = 0;
        }
        swap = p->order, p->order = p->following, p->following = swap;
        other = p->now, p->now = p->next, p->next = other;
        count = following;
    }
    return all;
}

static double most_taken(const char *path)
{
    FILE *f = fopen(path, "rb");
    program p;
    uint32_t label = 0, id;
    double most = 1;
    long bytes;
    size_t i;
    if (!f || fseek(f, 0, SEEK_END) != 0 || (bytes = ftell(f)) < 20 || fseek(f, 0, SEEK_SET) != 0) fail(path);
    p.count = (size_t)bytes / 4;
    p.words = (uint32_t *)make(p.count, 4);
    if (fread(p.words, 4, p.count, f) != p.count || p.words[0] != 0x07230203u) fail(path);
    fclose(f);
    p.ids = p.words[3];
    p.blocks = (block *)make(p.ids, sizeof *p.blocks);
    p.now = (double *)make(2 * (size_t)p.ids, sizeof *p.now);
    p.next = p.now + p.ids;
    p.order = (uint32_t *)make(2 * (size_t)p.ids, sizeof *p.order);
    p.following = p.order + p.ids;
    p.seen = (uint8_t *)make(p.ids, 1);
    for (i = 5; i < p.count; i += p.words[i] >> 16) {
        const uint32_t op = p.words[i] & 0xffffu;
        if (p.words[i] >> 16 == 0) fail("a module that ends early");
        if (op == OP_LABEL) label = p.words[i + 1];
        if (op == OP_LOOP_MERGE) p.blocks[label].merge = p.words[i + 1];
        if (op >= OP_BRANCH && op <= OP_UNREACHABLE) p.blocks[label].end = i;
    }
    for (id = 0; id < p.ids; id++)
        if (p.blocks[id].merge) {
            const double taken = search(&p, id);
            most = taken > most ? taken : most;
        }
    return most;        /* the process ends soon: its memory is not given back */
}

int main(int argc, char **argv)
{
    double most = 1;
    int i;
    if (argc < 2) return fprintf(stderr, "usage: spirv_ways MODULE.spv...\n"), 2;
    for (i = 1; i < argc; i++) {
        const double taken = most_taken(argv[i]);
        most = taken > most ? taken : most;
    }
    printf("%.1f\n", log2(most));
    return 0;
}
