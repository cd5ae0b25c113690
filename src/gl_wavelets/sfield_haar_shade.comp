// Lights pixels by wavelets, a work group each, as the fragment shaders do, but from lists of coefficients:
// these are added up in W, which becomes texels where it hides; T becomes coefficients in W where a light is
// added. A face of W has its texels row by row, with a rim round them for what reads between texels; in place
// of texels the four numbers of each square, its sum and its three wavelets, stand at the first texels of its
// quarters.
// With gloss T begins as the solid angle, and light is added times each kernel of the BRDF.
// uses: sfield_haar_turn sfield_haar_list sfield_haar_gloss gbuffer
// sets: SFIELD_BANDS=1 SFIELD_SIDE=16 SFIELD_GLOSS=0 | SFIELD_BANDS=1 SFIELD_SIDE=32 SFIELD_GLOSS=0
// sets: SFIELD_BANDS=1 SFIELD_SIDE=16 SFIELD_GLOSS=1 | SFIELD_BANDS=1 SFIELD_SIDE=32 SFIELD_GLOSS=1
#ifndef SFIELD_SIDE
#define SFIELD_SIDE 16
#endif
#define SFIELD_FACE uint(SFIELD_SIDE * SFIELD_SIDE)
#define SFIELD_GROUP 64u
#define SFIELD_RIM uint(SFIELD_SIDE + 2)                // texels of a row of W
#define SFIELD_EACH(i, count) (uint i = gl_LocalInvocationIndex; i < count; i += SFIELD_GROUP)
#define SFIELD_HAS(faces, face) ((faces >> (face) & 1u) != 0u)
layout(local_size_x = 64) in;

shared float sfield_w[6 * (SFIELD_SIDE + 2) * (SFIELD_SIDE + 2)];
#if SFIELD_SIDE > 16
#define SFIELD_PLANES (1u + 3u * uint(SFIELD_GLOSS))    // of texels in the buffer: T, kernels
#define SFIELD_T(i) glbk_haar_left[sfield_plane(0u) + (i)]
#else
#define SFIELD_PLANES (3u * uint(SFIELD_GLOSS))
shared float sfield_t[6 * SFIELD_SIDE * SFIELD_SIDE];
#define SFIELD_T(i) sfield_t[i]
#endif
#if SFIELD_GLOSS
#define SFIELD_CHAINS 3u
#define SFIELD_K(k, i) glbk_haar_left[sfield_plane((k) + SFIELD_PLANES - 3u) + (i)]
shared vec4 sfield_shines[64];
#else
#define SFIELD_CHAINS 1u
#define SFIELD_K(k, i) 1.0
#endif
shared uint sfield_least, sfield_next, sfield_covered, sfield_faces;
shared uvec3 sfield_samples[16];        // lists: first texel, words, weight as the bits of a float
shared vec4 sfield_parts[64];

// Waits until all invocations have come here and see what the others wrote.
void sfield_wait()
{
    memoryBarrierShared();
    barrier();
}

// Returns where a plane of the work group's texels begins in the buffer.
uint sfield_plane(uint number)
{
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    return (group * SFIELD_PLANES + number) * 6u * SFIELD_FACE;
}

// Returns where a texel of a face stands in W. Rows and columns begin at -1.
uint sfield_at(uint face, uint x, uint y) { return (face * SFIELD_RIM + y + 1u) * SFIELD_RIM + x + 1u; }

float sfield_tap(uint cube, uint face, ivec2 texel)
{
    return sfield_w[cube + sfield_at(face, uint(texel.x), uint(texel.y))];
}

// Returns where texel i of a cube stands on its face, and in W.
ivec2 sfield_texel_of(uint i)
{
    return ivec2(i % uint(SFIELD_SIDE), i / uint(SFIELD_SIDE) % uint(SFIELD_SIDE));
}

uint sfield_w_of(uint i)
{
    ivec2 texel = sfield_texel_of(i);
    return sfield_at(i / SFIELD_FACE, uint(texel.x), uint(texel.y));
}

// Returns texel i of the sky: radiance, solid angle.
vec4 sfield_sky(uint i) { return uintBitsToFloat(SFIELD_MOVING(glbk_sfield_contents.sky_texel + i)); }

// Returns the number in the low half of a word.
float sfield_short(uint word) { return float(int(word << 16) >> 16); }

// Turns the faces of W whose bits are set into texels, or into coefficients: each square's four numbers by
// the same matrix, which is its own inverse.
void sfield_transform(bool to_texels, uint faces)
{
    for (uint step = 1u; step < uint(SFIELD_SIDE); step *= 2u) {
        uint quarter = to_texels ? uint(SFIELD_SIDE) / 2u / step : step;
        uint row = uint(SFIELD_SIDE) / 2u / quarter;    // squares of a row
        sfield_wait();
        for SFIELD_EACH(i, 6u * row * row) {
            uint face = i / (row * row), x = i % row, y = i / row % row;
            if (!SFIELD_HAS(faces, face)) continue;
            uint at = sfield_at(face, 2u * quarter * x, 2u * quarter * y), up = at + quarter * SFIELD_RIM;
            float a = sfield_w[at] + sfield_w[at + quarter], b = sfield_w[at] - sfield_w[at + quarter];
            float c = sfield_w[up] + sfield_w[up + quarter], d = sfield_w[up] - sfield_w[up + quarter];
            sfield_w[at] = 0.5 * (a + c);
            sfield_w[at + quarter] = 0.5 * (b + d);
            sfield_w[up] = 0.5 * (a - c);
            sfield_w[up + quarter] = 0.5 * (b - d);
        }
    }
    sfield_wait();
}

void sfield_clear(uint faces)
{
    sfield_wait();
    for SFIELD_EACH(i, 6u * SFIELD_FACE)
        if (SFIELD_HAS(faces, i / SFIELD_FACE)) sfield_w[sfield_w_of(i)] = 0.0;
}

// Adds lists up in W, which is all 0, and turns it into texels. channel: of a light, or 3 of what hides;
// turned: the rims are wanted, too.
void sfield_expand(uint count, uint channel, bool turned)
{
    for (uint k = 0u; k < count; k++) {
        uvec3 list = sfield_samples[k];
        if (list.y == 0u) continue;
        sfield_wait();                          // a place is once in a list, and in several lists
        for SFIELD_EACH(i, (list.y + 3u) / 4u) {
            uvec4 words = SFIELD_TEXEL(list.x + i);
            for (int n = 0; n < 4; n++) {
                if (4u * i + uint(n) >= list.y || (channel < 3u && (n & 1) != 0)) continue;
                uint value = channel == 1u ? words[n | 1] >> 16 : channel == 2u ? words[n | 1] : words[n];
                sfield_w[words[n] >> 16] += uintBitsToFloat(list.z) * sfield_short(value);
            }
        }
    }
    sfield_transform(true, sfield_faces);
    if (!turned) return;
    for SFIELD_EACH(i, 24u * (SFIELD_RIM - 1u)) {
        uint face = i / (4u * (SFIELD_RIM - 1u)), from = face, along = i % (SFIELD_RIM - 1u);
        uint side = i / (SFIELD_RIM - 1u) % 4u, last = SFIELD_RIM - 1u;
        uvec2 at = side < 2u ? uvec2(along + side, side * last)
                             : uvec2((side - 2u) * last, along + 3u - side);
        ivec2 texel = sfield_wrap(from, ivec2(at) - 1);
        sfield_w[(face * SFIELD_RIM + at.y) * SFIELD_RIM + at.x] = sfield_tap(0u, from, texel);
    }
    sfield_wait();
}

// Returns this invocation's share of the light that lists send to T, whose coefficients are in W.
vec3 sfield_shine(uint count)
{
    vec3 sum = vec3(0.0);
    for (uint k = 0u; k < count; k++) {
        uvec3 list = sfield_samples[k];
        for SFIELD_EACH(i, (list.y + 3u) / 4u) {
            uvec4 words = SFIELD_TEXEL(list.x + i);
            for (int n = 0; n < 4; n += 2) {
                vec3 rgb = vec3(sfield_short(words[n]), sfield_short(words[n + 1] >> 16),
                                sfield_short(words[n + 1]));
                if (4u * i + uint(n) < list.y)
                    sum += sfield_w[words[n] >> 16] * uintBitsToFloat(list.z) * rgb;
            }
        }
    }
    return sum;
}

// Returns the turn of an entity, by which vectors of the world come into its fields' space.
mat3 sfield_turn_of(uint entity)
{
    return transpose(mat3(uintBitsToFloat(sfield_entity(entity, 2u).xyz),
                          uintBitsToFloat(sfield_entity(entity, 3u).xyz),
                          uintBitsToFloat(sfield_entity(entity, 4u).xyz)));
}

// Returns W, whose faces have bits if they are not empty, in the direction of texel i of the world.
float sfield_seen(uint i, mat3 turn, uint faces)
{
    vec3 d = turn * sfield_from_face(i / SFIELD_FACE, sfield_middle(sfield_texel_of(i)));
    vec2 st;
    uint face = sfield_to_face(d, st);
    bool inside = max(abs(st.x), abs(st.y)) < 1.0 - 1.0 / float(SFIELD_SIDE);      // reads no rim
    float seen = 0.0;
    if (!inside || SFIELD_HAS(faces, face)) seen = sfield_between(0u, d);
    return seen;
}

// Multiplies T by what an entity that hides leaves.
void sfield_hide(uint count, uint entity)
{
    bool turned = sfield_is_turned(entity);
    uint faces = sfield_faces;
    if (faces == 0u) return;
    sfield_expand(count, 3u, turned);
    if (turned) {
        mat3 turn = sfield_turn_of(entity);
        for SFIELD_EACH(i, 6u * SFIELD_FACE)
            if (SFIELD_T(i) != 0.0) {
                float hidden = sfield_seen(i, turn, faces);
                if (hidden != 0.0) SFIELD_T(i) *= 1.0 - hidden;
            }
    } else {
        for SFIELD_EACH(i, 6u * SFIELD_FACE)
            if (SFIELD_HAS(faces, i / SFIELD_FACE)) SFIELD_T(i) *= 1.0 - sfield_w[sfield_w_of(i)];
    }
    sfield_clear(faces);
}

// Adds this invocation's share of a light to the sums of each kernel; without gloss there is one.
void sfield_light(uint entity, inout mat3 sums)
{
    uint faces = sfield_faces;
    vec3 tint = uintBitsToFloat(sfield_entity(entity, 6u).xyz);
    if (faces == 0u) return;
    if (sfield_is_turned(entity)) {
        mat3 turn = sfield_turn_of(entity);
        for (uint c = 0u; c < 3u; c++) {
            vec3 channel = tint * vec3(equal(uvec3(c), uvec3(0u, 1u, 2u)));
            sfield_expand(16u, c, true);
            for SFIELD_EACH(i, 6u * SFIELD_FACE)
                if (SFIELD_T(i) != 0.0) {
                    vec3 rgb = SFIELD_T(i) * sfield_seen(i, turn, faces) * channel;
                    sums[0] += SFIELD_K(0u, i) * rgb;
#if SFIELD_GLOSS
                    sums[1] += SFIELD_K(1u, i) * rgb;
                    sums[2] += SFIELD_K(2u, i) * rgb;
#endif
                }
            sfield_clear(faces);
        }
    } else {
        for (uint k = 0u; k < SFIELD_CHAINS; k++) {
            for SFIELD_EACH(i, 6u * SFIELD_FACE)
                if (SFIELD_HAS(faces, i / SFIELD_FACE))
                    sfield_w[sfield_w_of(i)] = SFIELD_T(i) * SFIELD_K(k, i);
            sfield_transform(false, faces);
            vec3 rgb = sfield_shine(16u) * tint;
            sums[0] += k == 0u ? rgb : vec3(0.0);
            sums[1] += k == 1u ? rgb : vec3(0.0);
            sums[2] += k == 2u ? rgb : vec3(0.0);
            sfield_clear(faces);
        }
    }
}

// Chooses what all invocations meet next of what each has found, and returns whether there is any.
bool sfield_choose(float mine, uint id, out float d2, out uint chosen)
{
    if (gl_LocalInvocationIndex == 0u) {
        sfield_least = sfield_next = SFIELD_NONE;
        sfield_covered = sfield_faces = 0u;
    }
    sfield_wait();
    if (id != SFIELD_NONE) atomicMin(sfield_least, floatBitsToUint(mine));  // bits of numbers >= 0 sort alike
    sfield_wait();
    if (id != SFIELD_NONE && floatBitsToUint(mine) == sfield_least) atomicMin(sfield_next, id);
    sfield_wait();
    d2 = uintBitsToFloat(sfield_least);
    chosen = sfield_next;
    return chosen != SFIELD_NONE;
}

// Finds the lists round the point of what has been chosen.
void sfield_collect(vec3 position, float d2, uint id)
{
    uvec4 what, corner, weight, head = uvec4(0u);
    float share;
    if (gl_LocalInvocationIndex >= 16u) return;
    sfield_surround(position, d2, id, what, corner, weight);
    uint at = sfield_share(what, uintBitsToFloat(corner), weight, SFIELD_TEXEL(what.w).w,
                           gl_LocalInvocationIndex, share);
    if (share > 0.0) head = SFIELD_TEXEL(SFIELD_TEXEL(what.w + 1u).y + at);
    share *= uintBitsToFloat(head.z);
    sfield_samples[gl_LocalInvocationIndex] = uvec3(head.xy, floatBitsToUint(share));
    atomicOr(sfield_faces, head.w);
}

// Goes through all that the point meets, from near to far. Returns this invocation's share of all light, a
// column for each kernel.
mat3 sfield_walk(glbk_point p)
{
    mat3 sum = mat3(0.0);
    float mine = -1.0, d2;
    uint me = gl_LocalInvocationIndex, found = 0u, id;
    sfield_find(p.position, p.normal, p.entity, me, SFIELD_GROUP, mine, found);
    while (sfield_choose(mine, found, d2, id)) {
        bool hides = (id & 3u) == 3u;
        if (found == id) {
            if (!hides) found += 2u;            // all channels of a light are taken together
            sfield_find(p.position, p.normal, p.entity, me, SFIELD_GROUP, mine, found);
        }
        if (hides && sfield_hidden(p.position, p.normal, p.entity, me, SFIELD_GROUP, d2, id))
            atomicOr(sfield_covered, 1u);
        sfield_collect(p.position, d2, id);
        sfield_wait();
        if (hides && sfield_covered == 0u) sfield_hide(16u, id >> 2);
        if (!hides) sfield_light(id >> 2, sum);
        sfield_wait();
    }
    return sum;
}

void main()
{
    ivec2 at = ivec2(glbk_haar_batch.left, glbk_haar_batch.bottom) + ivec2(gl_WorkGroupID.xy);
    uint me = gl_LocalInvocationIndex, own = 0u;
    float open = 0.0;
    vec4 scale = vec4(1.0 / 3.14159265), light;
    mat3 sums = mat3(0.0);
    glbk_point p;
    bool seen = glbk_read_point(at, p);
#if SFIELD_GLOSS
    sfield_look look;
    seen = sfield_read_look(p, look) && seen;
    if (look.metal) scale.xyz = 1.0 - look.facing;
#endif
    if (seen) {
        for SFIELD_EACH(i, 6u * SFIELD_FACE) {
#if SFIELD_GLOSS
            vec3 kernels = sfield_kernels(look, i / SFIELD_FACE, sfield_texel_of(i));
            SFIELD_T(i) = any(greaterThan(kernels, vec3(0.0))) ? sfield_sky(i).w : 0.0;
            for (uint k = 0u; k < 3u; k++) SFIELD_K(k, i) = kernels[k];
#else
            vec3 direction = sfield_direction(i / SFIELD_FACE, sfield_texel_of(i));
            SFIELD_T(i) = max(dot(direction, p.normal), 0.0) * sfield_sky(i).w;
#endif
            sfield_w[sfield_w_of(i)] = 0.0;
        }
        if (glbk_haar_batch.own != 0u) own = texelFetch(glbk_sfield_self, ivec3(at, 0), 0).x;
        if (own != 0u) {
            bool turns = p.entity - 1u < glbk_sfield_contents.entity_count;
            uvec4 head = SFIELD_TEXEL(own);
            if (me == 0u) sfield_samples[0] = head.xyz;
            if (me == 0u) sfield_faces = head.w;
            sfield_wait();
            sfield_hide(1u, turns ? p.entity - 1u : SFIELD_NOBODY);
            sfield_wait();
        }
        sums = sfield_walk(p);
        for SFIELD_EACH(i, 6u * SFIELD_FACE)
            if (glbk_haar_batch.last != 0u) {
                vec3 sky = SFIELD_T(i) * sfield_sky(i).xyz;
                float t = SFIELD_T(i);
                sums[0] += SFIELD_K(0u, i) * sky;
#if SFIELD_GLOSS
                sums[1] += SFIELD_K(1u, i) * sky;
                sums[2] += SFIELD_K(2u, i) * sky;
                t *= max(dot(sfield_direction(i / SFIELD_FACE, sfield_texel_of(i)), p.normal), 0.0);
#endif
                open += t;
            }
    }
    light = vec4(sums[0], open);
    sfield_parts[me] = light;
#if SFIELD_GLOSS
    vec4 shine = vec4(sums[1] * look.facing + sums[2], 0.0);
    sfield_shines[me] = shine;
#endif
    sfield_wait();
    if (me != 0u) return;
    for (uint i = 1u; i < SFIELD_GROUP; i++) light += sfield_parts[i];
    imageStore(glbk_sfield_light_image, at, light * scale);
#if SFIELD_GLOSS
    for (uint i = 1u; i < SFIELD_GROUP; i++) shine += sfield_shines[i];
    imageStore(glbk_sfield_gloss_image, at, shine);
#endif
}
