/* ---- bindings ----

   Each part (this header, and each technique's) has four lists, empty where it needs none:

     GLBK_part_TEXTURES(X)   X(GLSL type, name, slot)
     GLBK_part_BLOCKS(X)     X(name, slot, MEMBERS), each with a list MEMBERS(X): X(GLSL type, name, count)
     GLBK_part_STORAGE(X)    X(qualifiers, GLSL type, name, slot), an array without size, for compute
     GLBK_part_IMAGES(X)     X(qualifiers, format, GLSL type, name, slot), for compute

   A list may consist of other lists, each named with (X) after it. Slots of textures count from 0 to
   GLBK_UNITS - 1, those of blocks, storage and images to 7, anew in each part. A program that uses several
   parts gives each a glbk_offset, so that they do not meet; the base is one too, whose slots stay. From the
   lists come GLBK_SLOT_name, the C struct of each block, and the library file "part_bindings". Members are
   read as block.member. Their layout is std140 and that of C at the same time: members are mat4, vec4, ivec4,
   uvec4, arrays of these, and float and uint, four of which fill the place of a vec4. tools/check-glsl
   compares both layouts. */

#define GLBK_BASE_TEXTURES(X) X(glbk_color_sampler, glbk_source, 0)
#define GLBK_BASE_BLOCKS(X)
#define GLBK_BASE_STORAGE(X)
#define GLBK_BASE_IMAGES(X)

#define GLBK__SLOT_TEXTURE(type, name, slot) GLBK_SLOT_##name = slot,
#define GLBK__SLOT_BLOCK(name, slot, members) GLBK_SLOT_##name = slot,
#define GLBK__SLOT_STORAGE(qualifiers, type, name, slot) GLBK_SLOT_##name = slot,
#define GLBK__SLOT_IMAGE(qualifiers, format, type, name, slot) GLBK_SLOT_##name = slot,
#define GLBK__MEMBER_mat4(name, count) float name[16 * (count)];
#define GLBK__MEMBER_vec4(name, count) float name[4 * (count)];
#define GLBK__MEMBER_ivec4(name, count) int32_t name[4 * (count)];
#define GLBK__MEMBER_uvec4(name, count) uint32_t name[4 * (count)];
#define GLBK__MEMBER_float(name, count) float name;     /* count is 1: std140 would spread an array */
#define GLBK__MEMBER_uint(name, count) uint32_t name;
#define GLBK__MEMBER(type, name, count) GLBK__MEMBER_##type(name, count)
#define GLBK__STRUCT(name, slot, members) typedef struct name { members(GLBK__MEMBER) } name;
#define GLBK__PART(PART)                        \
    enum {                                      \
        GLBK_##PART##_TEXTURES(GLBK__SLOT_TEXTURE)  \
        GLBK_##PART##_BLOCKS(GLBK__SLOT_BLOCK)      \
        GLBK_##PART##_STORAGE(GLBK__SLOT_STORAGE)   \
        GLBK_##PART##_IMAGES(GLBK__SLOT_IMAGE)      \
        GLBK__LAST_SLOT_##PART                  \
    };                                          \
    GLBK_##PART##_BLOCKS(GLBK__STRUCT)
GLBK__PART(BASE)
