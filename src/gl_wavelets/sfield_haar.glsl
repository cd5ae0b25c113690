// sfield_haar - wavelets: what the passes of a batch of points share. C twins: shadowfield.h.
//
// A function of direction has side x side texels on each of six faces. Each sample of a field has a tree for
// each face (docs/gpu-layouts.md): a node has the values of its square's quarters, and leads to nodes of
// those quarters that are not of one value. So a tree has the squares in which wavelets lie, and no others.
// uses: table sfield_bindings sfield_contents haar_bindings
#define SFIELD_TEXEL(i) texelFetch(glbk_sfield_table, glbk_table_at(i), 0)
#define SFIELD_MOVING(i) texelFetch(glbk_sfield_moving, glbk_table_at(i), 0)
#define SFIELD_EMPTY 0u             // kinds of what stands at a place of a point's list
#define SFIELD_OCCLUDER 1u
#define SFIELD_LIGHT 2u             // and the channel
#define SFIELD_OWN 5u               // self-visibility
#define SFIELD_NOBODY 0xffffffffu   // no entity, no rotation

// Returns texel k of an entity, counted from 0.
uvec4 sfield_entity(uint entity, uint k)
{
    return SFIELD_MOVING(glbk_sfield_contents.entity_texel + 7u * entity + k);
}

// Returns v, a vector of the world, in the space of an entity's fields.
vec3 sfield_turn(uint entity, vec3 v)
{
    return vec3(dot(uintBitsToFloat(sfield_entity(entity, 2u).xyz), v),
                dot(uintBitsToFloat(sfield_entity(entity, 3u).xyz), v),
                dot(uintBitsToFloat(sfield_entity(entity, 4u).xyz), v));
}

// Returns whether what an entity's fields say has to be turned into the world.
bool sfield_is_turned(uint entity)
{
    return entity != SFIELD_NOBODY && sfield_entity(entity, 5u).z != SFIELD_NOBODY;
}

// Returns the pixel of a point of the batch, which is a rectangle of pixels.
ivec2 sfield_pixel(uint point)
{
    return ivec2(glbk_haar_batch.left + point % glbk_haar_batch.width,
                 glbk_haar_batch.bottom + point / glbk_haar_batch.width);
}

// Returns where a square of a cube stands in a texture of so many cubes in a row. size: squares of a face, in
// both directions.
ivec2 sfield_square(uint cube, uint columns, uint face, uvec2 at, uvec2 size)
{
    return ivec2(uvec2(cube % columns * 6u + face, cube / columns) * size + at);
}

// Returns the direction of a place on a face, s and t within -1..1.
vec3 sfield_from_face(uint face, vec2 st)
{
    float s = st.x, t = st.y, sign_of = (face & 1u) == 0u ? 1.0 : -1.0;
    vec3 x = vec3(sign_of, -t, -sign_of * s), y = vec3(s, sign_of, sign_of * t);
    vec3 z = vec3(sign_of * s, -t, sign_of);
    return face < 2u ? x : face < 4u ? y : z;
}

// Returns the middle of a texel of a face, which may lie past the face's edge.
vec2 sfield_middle(ivec2 texel) { return (2.0 * vec2(texel) + 1.0) / float(glbk_haar_batch.side) - 1.0; }

// Returns the number of sample i of the 16 round a point, and its weight. side: positions a side of a face.
uint sfield_share(uvec4 what, vec4 corner, uvec4 weight, uint side, uint i, out float share)
{
    bool right = (i & 1u) != 0u, up = (i & 2u) != 0u, outer = (i & 4u) != 0u, after = (i & 8u) != 0u;
    vec4 shells = uintBitsToFloat(weight);
    share = up ? (right ? corner.w : corner.z) : (right ? corner.y : corner.x);
    share *= (outer ? shells.y : shells.x) * (after ? shells.z : 1.0 - shells.z);
    return what.y + (right ? 1u : 0u) + (up ? side : 0u) + (outer ? 6u * side * side : 0u) +
           (after ? weight.w : 0u);
}
