/* masked.h - a scene of our own in a file: a board with holes by an alpha mask over a ground. Include after program.h;
   masked.gltf comes into its scratch folder. */
#ifndef MASKED_H
#define MASKED_H

/* With the ground in it, seen from above. */
#define MASKED "masked.gltf --camera 0,7,6,0,0,0,45 --set ground=0"

/* A board of 3 x 3, holes and colour in a chequer of 2 x 2, above a ground of 6 x 6. Base 64 of corners, texture
   coordinates and indices, and of an RGBA PNG of 8 x 8. */
static inline void need_masked(void)
{
    char path[256];
    FILE *file;
    if (!DAPPLE_HAVE_TINYGLTF) {
        printf("skip: needs tinygltf\n");
        skip();
    }
    snprintf(path, sizeof path, "%s/masked.gltf", folder);
    file = fopen(path, "wb");
    assert_non_null(file);
    fprintf(file, "%s", "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":140,"
        "\"uri\":\"data:application/octet-stream;base64,"
        "AABAwAAAAAAAAEDAAABAwAAAAAAAAEBAAABAQAAAAAAAAEBAAABAQAAAAAAAAEDAAADAvwAAwD8AAMC/AADAvwAAwD8AAMA/AADAPwAAwD8AAMA/"
        "AADAPwAAwD8AAMC/AAAAAAAAAAAAAAAAAACAPwAAgD8AAIA/AACAPwAAAAAAAAEAAgAAAAIAAwA=\"}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":96},{\"buffer\":0,\"byteOffset\":96,\"byteLength\":32},"
        "{\"buffer\":0,\"byteOffset\":128,\"byteLength\":12}],\"accessors\":["
        "{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"
        "{\"bufferView\":0,\"byteOffset\":48,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"
        "{\"bufferView\":1,\"componentType\":5126,\"count\":4,\"type\":\"VEC2\"},"
        "{\"bufferView\":2,\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"}],"
        "\"images\":[{\"uri\":\"data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAgAAAAICAYAAADED76LAAAAHElEQVR42mM4saCCAQ3/"
        "R8YM9FHwHw2jaKCDAgB1SpfhcYPh0gAAAABJRU5ErkJggg==\"}],\"textures\":[{\"source\":0}],"
        "\"materials\":[{\"doubleSided\":true,\"alphaMode\":\"MASK\",\"pbrMetallicRoughness\":"
        "{\"baseColorTexture\":{\"index\":0}}}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},"
        "\"indices\":3}]},{\"primitives\":[{\"attributes\":{\"POSITION\":1,\"TEXCOORD_0\":2},\"indices\":3,"
        "\"material\":0}]}],\"nodes\":[{\"mesh\":0},{\"mesh\":1}],\"scenes\":[{\"nodes\":[0,1]}],\"scene\":0}");
    assert_int_equal(fclose(file), 0);
}

#endif
