/* room.h - a scene of our own in a file: a closed room with one window and a pane in it, whose material the test
   chooses. Include after program.h; room.gltf and room.bin come into its scratch folder. */
#ifndef ROOM_H
#define ROOM_H

enum { ROOM_BOXES = 10 };      /* walls as thick as the penumbra filter asks for, then the pane */

static inline void room_put(const char *name, const char *text, const void *data, size_t size)
{
    char path[256];
    FILE *file;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    file = fopen(path, "wb");
    assert_non_null(file);
    if (text) assert_true(fputs(text, file) >= 0);
    else assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

/* pane: members of its glTF material. The camera looks from the back at the window and the floor before it. */
static inline void room_write(const char *pane)
{
    static const float boxes[ROOM_BOXES][6] = {
        { -2.4f, -0.4f, -2.4f, 2.4f, 0, 2.4f },  { -2.4f, 2.6f, -2.4f, 2.4f, 3, 2.4f },
        { -2.4f, 0, -2.4f, -2, 2.6f, 2.4f },     { 2, 0, -2.4f, 2.4f, 2.6f, 2.4f },
        { -2, 0, 2, 2, 2.6f, 2.4f },             { -2, 0, -2.4f, 2, 0.9f, -2 },
        { -2, 2.1f, -2.4f, 2, 2.6f, -2 },        { -2, 0.9f, -2.4f, -1, 2.1f, -2 },
        { 1, 0.9f, -2.4f, 2, 2.1f, -2 },         { -1, 0.9f, -2.22f, 1, 2.1f, -2.18f } };
    static const uint16_t cube[36] = { 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                       2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5 };
    struct { float corners[ROOM_BOXES][8][3]; uint16_t indices[ROOM_BOXES][36]; } data;
    char json[3000];
    for (int b = 0; b < ROOM_BOXES; b++) {
        for (int i = 0; i < 8; i++)
            for (int k = 0; k < 3; k++)
                data.corners[b][i][k] = boxes[b][(i >> k & 1) ? 3 + k : k];
        for (int i = 0; i < 36; i++)
            data.indices[b][i] = (uint16_t)(cube[i] + (b < ROOM_BOXES - 1 ? 8 * b : 0));
    }
    snprintf(json, sizeof json,
             "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":1680,\"uri\":\"room.bin\"}],"
             "\"bufferViews\":[{\"buffer\":0,\"byteLength\":864},{\"buffer\":0,\"byteOffset\":864,\"byteLength\":96},"
             "{\"buffer\":0,\"byteOffset\":960,\"byteLength\":648},"
             "{\"buffer\":0,\"byteOffset\":1608,\"byteLength\":72}],"
             "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":72,\"type\":\"VEC3\"},"
             "{\"bufferView\":1,\"componentType\":5126,\"count\":8,\"type\":\"VEC3\"},"
             "{\"bufferView\":2,\"componentType\":5123,\"count\":324,\"type\":\"SCALAR\"},"
             "{\"bufferView\":3,\"componentType\":5123,\"count\":36,\"type\":\"SCALAR\"}],"
             "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.8,0.7,0.6,1]}},{%s}],"
             "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":2,\"material\":0},"
             "{\"attributes\":{\"POSITION\":1},\"indices\":3,\"material\":1}]}],"
             "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":1.1,\"znear\":0.1}}],"
             "\"nodes\":[{\"mesh\":0},{\"camera\":0,\"translation\":[0.9,1.7,1.8],"
             "\"rotation\":[-0.1951,0.0958,0.0192,0.9759]}],\"scenes\":[{\"nodes\":[0,1]}]}", pane);
    room_put("room.gltf", json, NULL, 0);
    room_put("room.bin", NULL, &data, sizeof data);
}

/* Skips where this build reads no glTF. */
static inline void room_need(void)
{
    room_write("\"doubleSided\":true");
    if (run("render", "--technique csm --scene room.gltf --size 8x8 --set side=1 --set map_side=4 --out a.pfm") == 0)
        return;
    if (!strstr(output, "libtinygltf-dev")) fail_msg("%s", output);
    printf("skip: needs tinygltf\n");
    skip();
}

#endif
