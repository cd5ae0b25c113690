/* tree.h - a tree of cut-out leaves over a floor before a wall, as files: cards with a picture of ten leaves, of which
   an alpha mask takes three quarters away. Include after program.h; tree.gltf and whole_tree.gltf, whose cards have no
   mask, come into its scratch folder. */
#ifndef TREE_H
#define TREE_H

#include "common.h"

#include <math.h>
#include <stdint.h>

#define TREE "--camera 0,2.5,8,0,1.6,0,40 --set ground=0 --light sun:0.3,0.8,0.5"

enum { TREE_CARDS = 300, TREE_SIDE = 64 };

static inline double tree_next(uint64_t *seed)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(*seed >> 40) / 16777216.0;
}

static inline FILE *tree_open(const char *name)
{
    char path[256];
    FILE *file;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    file = fopen(path, "wb");
    assert_non_null(file);
    return file;
}

/* Ten leaves, ellipses at random, in RGBA. */
static inline void tree_draw(uint8_t *pixels)
{
    uint64_t seed = 11;
    memset(pixels, 0, 4 * TREE_SIDE * TREE_SIDE);
    for (int leaf = 0; leaf < 10; leaf++) {
        double cx = 8 + 48 * tree_next(&seed), cy = 8 + 48 * tree_next(&seed), turn = 3.14 * tree_next(&seed);
        double length = 7 + 5 * tree_next(&seed);
        for (int y = 0; y < TREE_SIDE; y++)
            for (int x = 0; x < TREE_SIDE; x++) {
                double u = (x - cx) * cos(turn) + (y - cy) * sin(turn), v = (y - cy) * cos(turn) - (x - cx) * sin(turn);
                uint8_t *texel = pixels + 4 * (TREE_SIDE * y + x);
                texel[0] = 90;
                texel[1] = 150;
                texel[2] = 60;
                if (u * u + v * v / 0.2 < length * length) texel[3] = 255;
            }
    }
}

static inline void tree_write_picture(void)
{
    static uint8_t pixels[4 * TREE_SIDE * TREE_SIDE];
    size_t size;
    void *png;
    FILE *file = tree_open("tree.png");
    tree_draw(pixels);
    png = ex_png_encode(TREE_SIDE, TREE_SIDE, 4, 8, pixels, &size);
    assert_non_null(png);
    assert_int_equal(fwrite(png, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
    free(png);
}

/* Corners of the cards and then of floor and wall, texture coordinates, indices. Little-endian, as glTF has it. */
static inline void tree_write_corners(void)
{
    static const float room[8][3] = { { -4, 0, -4 }, { 4, 0, -4 }, { 4, 0, 4 }, { -4, 0, 4 },
                                      { -4, 0, -4 }, { 4, 0, -4 }, { 4, 4, -4 }, { -4, 4, -4 } };
    static const int at[4][2] = { { -1, -1 }, { 1, -1 }, { 1, 1 }, { -1, 1 } };
    static float corners[4 * TREE_CARDS][3], places[4 * TREE_CARDS][2];
    static uint32_t indices[6 * TREE_CARDS + 12] = { 0 };
    static const uint32_t two[6] = { 0, 2, 1, 0, 3, 2 };
    uint64_t seed = 3;
    FILE *file = tree_open("tree.bin");
    for (uint32_t card = 0; card < TREE_CARDS; card++) {
        double c[3], d[3], e[3], length = 2, along = 0;
        for (int tries = 0; length > 1; tries++) {
            length = 0;
            for (int k = 0; k < 3; k++) {
                c[k] = 2 * tree_next(&seed) - 1;
                length += c[k] * c[k];
            }
        }
        for (int k = 0; k < 3; k++) {
            d[k] = tree_next(&seed) - 0.5;
            e[k] = tree_next(&seed) - 0.5;
        }
        length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        for (int k = 0; k < 3; k++) along += (d[k] /= length) * e[k];
        for (int k = 0; k < 3; k++) e[k] -= along * d[k];
        length = sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2]);
        for (uint32_t i = 0; i < 4; i++) {
            for (int k = 0; k < 3; k++) {
                double off = 0.28 * (at[i][0] * d[k] + at[i][1] * e[k] / length);
                corners[4 * card + i][k] = (float)(1.2 * c[k] + off + (k == 1 ? 2.2 : 0));
            }
            for (int k = 0; k < 2; k++) places[4 * card + i][k] = 0.5f * (float)(at[i][k] + 1);
        }
        for (int i = 0; i < 6; i++) indices[6 * card + (uint32_t)i] = 4 * card + two[i];
    }
    for (uint32_t i = 0; i < 12; i++) indices[6 * TREE_CARDS + i] = 4 * (i / 6) + two[i % 6];
    assert_int_equal(fwrite(corners, sizeof corners, 1, file), 1);
    assert_int_equal(fwrite(room, sizeof room, 1, file), 1);
    assert_int_equal(fwrite(places, sizeof places, 1, file), 1);
    assert_int_equal(fwrite(indices, sizeof indices, 1, file), 1);
    assert_int_equal(fclose(file), 0);
}

static inline void tree_write_scene(const char *name, const char *material)
{
    enum { CORNERS = 48 * TREE_CARDS, ROOM = 96, PLACES = 32 * TREE_CARDS, CARDS = 24 * TREE_CARDS, WALLS = 48 };
    FILE *file = tree_open(name);
    fprintf(file, "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":%d,\"uri\":\"tree.bin\"}],"
            "\"bufferViews\":["
            "{\"buffer\":0,\"byteLength\":%d},{\"buffer\":0,\"byteOffset\":%d,\"byteLength\":%d},"
            "{\"buffer\":0,\"byteOffset\":%d,\"byteLength\":%d},{\"buffer\":0,\"byteOffset\":%d,\"byteLength\":%d},"
            "{\"buffer\":0,\"byteOffset\":%d,\"byteLength\":%d}],\"accessors\":[",
            CORNERS + ROOM + PLACES + CARDS + WALLS, CORNERS, CORNERS, ROOM, CORNERS + ROOM, PLACES,
            CORNERS + ROOM + PLACES, CARDS, CORNERS + ROOM + PLACES + CARDS, WALLS);
    fprintf(file, "{\"bufferView\":0,\"componentType\":5126,\"count\":%d,\"type\":\"VEC3\"},"
            "{\"bufferView\":1,\"componentType\":5126,\"count\":8,\"type\":\"VEC3\"},"
            "{\"bufferView\":2,\"componentType\":5126,\"count\":%d,\"type\":\"VEC2\"},"
            "{\"bufferView\":3,\"componentType\":5125,\"count\":%d,\"type\":\"SCALAR\"},"
            "{\"bufferView\":4,\"componentType\":5125,\"count\":12,\"type\":\"SCALAR\"}],",
            4 * TREE_CARDS, 4 * TREE_CARDS, 6 * TREE_CARDS);
    fprintf(file, "\"images\":[{\"uri\":\"tree.png\"}],\"textures\":[{\"source\":0}],\"materials\":[{%s},"
            "{\"doubleSided\":true,\"pbrMetallicRoughness\":"
            "{\"baseColorFactor\":[0.7,0.6,0.5,1],\"metallicFactor\":0}}],"
            "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":2},\"indices\":3,"
            "\"material\":0}]},"
            "{\"primitives\":[{\"attributes\":{\"POSITION\":1},\"indices\":4,\"material\":1}]}],"
            "\"nodes\":[{\"mesh\":0},{\"mesh\":1}],\"scenes\":[{\"nodes\":[0,1]}],\"scene\":0}", material);
    assert_int_equal(fclose(file), 0);
}

static inline void need_tree(void)
{
    if (!DAPPLE_HAVE_TINYGLTF) {
        printf("skip: needs tinygltf\n");
        skip();
    }
    tree_write_picture();
    tree_write_corners();
    tree_write_scene("tree.gltf", "\"doubleSided\":true,\"alphaMode\":\"MASK\",\"pbrMetallicRoughness\":"
                     "{\"metallicFactor\":0,\"baseColorTexture\":{\"index\":0}}");
    tree_write_scene("whole_tree.gltf", "\"doubleSided\":true,\"pbrMetallicRoughness\":"
                     "{\"metallicFactor\":0,\"baseColorFactor\":[0.1,0.3,0.05,1]}");
}

#endif
