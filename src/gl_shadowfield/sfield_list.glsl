// sfield_list - finds the entities that a work group needs, for compute shaders, before sfield_shade: all
// that hide anything of its points and all that shine, nearest first, with their texels and rotations in
// shared memory.
// uses: sfield_access
#ifndef SFIELD_GROUP
#define SFIELD_GROUP 64u            // invocations of a work group, a power of two
#endif
#define SFIELD_ENTITY 7u
#define SFIELD_LISTED 128u          // entities of the list; if more are needed, all are gone through
#define SFIELD_STAGED 768u          // texels of rotations, 28 of 4 bands or 3 of 8; the table has the others
#define SFIELD_TURNED 0x80000000u   // says that a rotation is in shared memory

shared uvec4 sfield_texels[SFIELD_LISTED * SFIELD_ENTITY + SFIELD_STAGED];
shared uint sfield_numbers[SFIELD_LISTED], sfield_turns[SFIELD_LISTED], sfield_listed, sfield_turned;
shared vec2 sfield_spans[SFIELD_LISTED];

// Returns whether more entities are needed than the list holds, so that all are gone through.
bool sfield_all() { return sfield_listed > SFIELD_LISTED; }

// Returns the name of entity i of the list, or of all: its number in the table << 8, and its place in the
// list or 255.
uint sfield_name(uint i) { return sfield_all() ? i << 8 | 255u : sfield_numbers[i] << 8 | i; }

// Returns texel k of an entity.
uvec4 sfield_record(uint name, uint k)
{
    if ((name & 255u) != 255u) return sfield_texels[(name & 255u) * SFIELD_ENTITY + k];
    return SFIELD_MOVING(glbk_sfield_contents.entity_texel + (name >> 8) * SFIELD_ENTITY + k);
}

// Returns texel i of a rotation, from shared memory if it is there.
uvec4 sfield_rotation_texel(uint i)
{
    if (i < SFIELD_TURNED) return SFIELD_MOVING(i);
    return sfield_texels[SFIELD_LISTED * SFIELD_ENTITY + (i & ~SFIELD_TURNED)];
}

#define SFIELD_COUNT (sfield_all() ? glbk_sfield_contents.entity_count : sfield_listed)
#define SFIELD_NAME(i) sfield_name(i)
#define SFIELD_NUMBER(name) (name >> 8)
#define SFIELD_RECORD(name, k) sfield_record(name, k)
#define SFIELD_NEAR(i) (sfield_all() ? 0.0 : sfield_spans[i].x)
#define SFIELD_FAR(i) (sfield_all() ? 3e38 : sfield_spans[i].y)
#define SFIELD_ROTATION(i) sfield_rotation_texel(i)

// Waits until all invocations have come here and see what the others wrote.
void sfield_wait()
{
    memoryBarrierShared();
    barrier();
}

// These are boxes round the points of a work group and round their normals.
struct sfield_box {
    vec3 low;
    vec3 high;
    vec3 normal_low;
    vec3 normal_high;
};

// Returns the boxes round the points that are seen.
sfield_box sfield_bound(vec3 position, vec3 normal, bool seen)
{
    uint me = gl_LocalInvocationIndex;
    bool counts = seen && all(lessThan(abs(position), vec3(1e18)));
    vec3 least[4] = vec3[4](position, -position, normal, -normal);
    for (uint k = 0u; k < 4u; k++)
        sfield_texels[k * SFIELD_GROUP + me] = floatBitsToUint(vec4(counts ? least[k] : vec3(3e38), 0.0));
    for (uint rest = SFIELD_GROUP / 2u; rest > 0u; rest >>= 1u) {
        sfield_wait();
        for (uint k = 0u; k < 4u && me < rest; k++) {
            uint at = k * SFIELD_GROUP + me;
            vec4 a = uintBitsToFloat(sfield_texels[at]), b = uintBitsToFloat(sfield_texels[at + rest]);
            sfield_texels[at] = floatBitsToUint(min(a, b));
        }
    }
    sfield_wait();
    for (uint k = 0u; k < 4u; k++) least[k] = uintBitsToFloat(sfield_texels[k * SFIELD_GROUP].xyz);
    sfield_wait();                  // until all have read, and others may write there
    return sfield_box(least[0], -least[1], least[2], -least[3]);
}

// Returns the least and greatest square of the distance of a point from the box, with a little more room than
// rounding takes.
vec2 sfield_span(sfield_box b, vec3 p)
{
    vec3 near = max(max(b.low - p, p - b.high), 0.0), far = max(abs(b.low - p), abs(b.high - p));
    return vec2(0.99999 * dot(near, near), 1.00001 * dot(far, far));
}

// Returns whether any of a sphere may be above the horizon of any point; where in doubt, it may.
bool sfield_above(sfield_box b, vec3 p, float radius)
{
    vec3 from = p - b.high, to = p - b.low;
    vec3 most = max(max(from * b.normal_low, from * b.normal_high),
                    max(to * b.normal_low, to * b.normal_high));
    vec3 room = 1e-6 * max(abs(from), abs(to));
    return most.x + most.y + most.z + room.x + room.y + room.z > -radius;
}

// Finds the entities. All invocations call it once, with seen = false where one has no point of its own.
void sfield_list(vec3 position, vec3 normal, bool seen)
{
    const uint rotation_texels[8] = uint[8](1u, 3u, 13u, 27u, 54u, 87u, 139u, 199u);
    const uint turn = rotation_texels[SFIELD_BANDS - 1], turns = min(SFIELD_STAGED / turn, SFIELD_LISTED);
    uint me = gl_LocalInvocationIndex;
    sfield_listed = sfield_turned = 0u;         // before the first wait
    sfield_box box = sfield_bound(position, normal, seen);
    if (box.low.x > box.high.x) return;
    for (uint e = me; e < glbk_sfield_contents.entity_count; e += SFIELD_GROUP) {
        uint at = glbk_sfield_contents.entity_texel + e * SFIELD_ENTITY;
        vec4 occluder = uintBitsToFloat(SFIELD_MOVING(at)), source = uintBitsToFloat(SFIELD_MOVING(at + 1u));
        vec2 span = sfield_span(box, occluder.xyz), light = vec2(0.0);
        float radius = uintBitsToFloat(SFIELD_MOVING(at + 3u).w);
        bool hides = span.x < occluder.w && sfield_above(box, occluder.xyz, radius);
        if (source.w > 0.0) light = sfield_span(box, source.xyz);
        if (!hides && !(source.w > 0.0)) continue;
        span = vec2(source.w > 0.0 ? light.x : span.x, hides ? max(span.y, light.y) : light.y);
        uint slot = atomicAdd(sfield_listed, 1u);
        if (slot < SFIELD_LISTED) sfield_texels[slot] = uvec4(e, floatBitsToUint(span), 0u);
    }
    sfield_wait();
    uint listed = sfield_listed;
    if (listed > SFIELD_LISTED) return;
    for (uint i = me; i < listed; i += SFIELD_GROUP) {          // bits of numbers >= 0 sort as these do
        uvec4 mine = sfield_texels[i];
        uint rank = 0u;
        for (uint k = 0u; k < listed; k++) {
            uvec4 other = sfield_texels[k];
            if (other.y < mine.y || (other.y == mine.y && other.x < mine.x)) rank++;
        }
        sfield_numbers[rank] = mine.x;
        sfield_spans[rank] = uintBitsToFloat(mine.yz);
    }
    sfield_wait();
    for (uint i = me; i < listed * SFIELD_ENTITY; i += SFIELD_GROUP) {
        uint entity = glbk_sfield_contents.entity_texel + sfield_numbers[i / SFIELD_ENTITY] * SFIELD_ENTITY;
        sfield_texels[i] = SFIELD_MOVING(entity + i % SFIELD_ENTITY);
    }
    sfield_wait();
    for (uint i = me; i < listed; i += SFIELD_GROUP) {
        uint at = i * SFIELD_ENTITY + 5u, rotation = sfield_texels[at].z;
        if (rotation == 0xffffffffu) continue;                  // the entity has none
        uint slot = atomicAdd(sfield_turned, 1u);
        if (slot >= turns) continue;
        sfield_turns[slot] = rotation;
        sfield_texels[at].z = SFIELD_TURNED | slot * turn;
    }
    sfield_wait();
    for (uint i = me; i < min(sfield_turned, turns) * turn; i += SFIELD_GROUP)
        sfield_texels[SFIELD_LISTED * SFIELD_ENTITY + i] = SFIELD_MOVING(sfield_turns[i / turn] + i % turn);
    sfield_wait();
}
