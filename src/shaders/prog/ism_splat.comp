// ism_splat.vert and .frag as a compute shader: a group draws all points of a VPL into up to 64 x 64 texels of its tile
// in shared memory, twice: first the depths alone, then which point it is that has them, the first one of several, as
// the depth test has it. Discs of many texels go to a list that 32 invocations a disc draw, so that no 31 wait for one.
// uses: ism_disc
// sets: ISM_PROJECTION=1 | ISM_PROJECTION=4
layout(local_size_x = 512) in;
#define ISM_THREADS 512u
#define ISM_SIDE 64
#define ISM_WIDE 64         // texels: discs of more go to the list
#define ISM_LIST 1024u
#define ISM_HOPE 0x10000u     // beside a point's number in the list

shared uint ism_depths[ISM_SIDE * ISM_SIDE];            // as bits, which are in the order of positive floats
shared uint ism_owners[ISM_SIDE * ISM_SIDE / 2];        // 16 bits each: maps of more points are not drawn by compute
shared uint ism_list[ISM_LIST], ism_listed;

uint ism_v;             // the VPL
ism_vpl ism_l;
ivec4 ism_part;         // first and last texel, of its tile
uint ism_hopes[4];      // bits: which of this invocation's points had a texel once

// Point number i of the VPL, phase after phase, with its texels in this part; false: it has none.
bool ism_find(uint i, out ism_surfel s)
{
    uint each = glbk_ism_frame.points.y;
    if (!ism_surfel_of((i / each * glbk_ism_frame.points.x + ism_v) * each + i % each, ism_v, ism_l, s)) return false;
    s.box = ivec4(max(s.box.xy, ism_part.xy), min(s.box.zw, ism_part.zw));
    return s.box.x <= s.box.z && s.box.y <= s.box.w;
}

uint ism_owner(uint texel) { return ism_owners[texel >> 1] >> (16u * (texel & 1u)) & 0xffffu; }

// The atomic minimum of 16 bits.
void ism_own(uint texel, uint point)
{
    uint shift = 16u * (texel & 1u), was = ism_owners[texel >> 1];
    while ((was >> shift & 0xffffu) > point) {
        uint now = atomicCompSwap(ism_owners[texel >> 1], was, (was & ~(0xffffu << shift)) | point << shift);
        if (now == was) break;
        was = now;
    }
}

// From a buffer: of textures of four floats GPUs fetch fewer at a time.
vec3 ism_texel_way(ivec2 texel)
{
    if (ism_l.sky || ism_projection_of(ism_l.exponent) == ISM_PROJECTION_LOBE)
        return ism_texel_direction(ism_l.sky ? -1.0 : ism_l.exponent, texel);
    return glbk_ism_ways[texel.y * int(glbk_ism_frame.maps.y) + texel.x].xyz;
}

// Its texels from the one at `from` on, every `pace`th; one loop, which those who draw beside it leave together. true: it
// was the nearest in one of them.
bool ism_draw(int turn, uint i, ism_surfel s, ivec2 from, ivec2 pace)
{
    ivec2 at = s.box.xy + from;
    bool nearest = false;
    while (at.x <= s.box.z && at.y <= s.box.w) {
        uint texel = uint((at.y - ism_part.y) * ISM_SIDE + at.x - ism_part.x), depth = ism_depths[texel];
        float t = ism_meet(ism_l.sky, s, ism_texel_way(at), uintBitsToFloat(depth));
        if (t < ISM_FAR) {
            if (turn == 0) nearest = atomicMin(ism_depths[texel], floatBitsToUint(t)) >= floatBitsToUint(t) || nearest;
            else if (depth == floatBitsToUint(t)) ism_own(texel, i);
        }
        at.x += pace.x;
        if (at.x > s.box.z) at = ivec2(s.box.x + from.x, at.y + pace.y);
    }
    return nearest;
}

// Of each invocation two points at a time, which the list holds if need be. The second turn passes by those that had no
// texel in the first. All invocations come here.
void ism_draw_all(int turn, uint count)
{
    uint thread = gl_LocalInvocationIndex, i;
    ism_surfel s;
    for (uint start = 0u; start < count; start += 2u * ISM_THREADS) {
        uint listed[2] = uint[2](ISM_LIST, ISM_LIST), word = start / ISM_THREADS >> 5, bit = start / ISM_THREADS & 31u;
        for (uint k = 0u; k < 2u; k++) {
            i = start + k * ISM_THREADS + thread;
            if (i >= count || turn != 0 && (ism_hopes[word] >> (bit + k) & 1u) == 0u || !ism_find(i, s)) continue;
            ivec2 wide = s.box.zw - s.box.xy + 1;
            if (wide.x * wide.y > ISM_WIDE) {
                listed[k] = atomicAdd(ism_listed, 1u);
                ism_list[listed[k]] = i;
            } else if (ism_draw(turn, i, s, ivec2(0), ivec2(1))) {
                ism_hopes[word] |= 1u << (bit + k);
            }
        }
        barrier();
        for (uint k = thread / 32u; k < ism_listed; k += ISM_THREADS / 32u) {
            i = ism_list[k] & 0xffffu;
            if (ism_find(i, s) && ism_draw(turn, i, s, ivec2(thread & 7u, thread / 8u & 3u), ivec2(8, 4)))
                atomicOr(ism_list[k], ISM_HOPE);
        }
        barrier();
        if (thread == 0u) ism_listed = 0u;
        for (uint k = 0u; k < 2u; k++)
            if (listed[k] < ISM_LIST && (ism_list[listed[k]] & ISM_HOPE) != 0u) ism_hopes[word] |= 1u << (bit + k);
        barrier();
    }
}

void main()
{
    uint thread = gl_LocalInvocationIndex, count;
    int side = min(int(glbk_ism_frame.maps.y), ISM_SIDE);
    ivec2 begin = ivec2(gl_WorkGroupID.xy) * side;
    ism_surfel s;
    ism_hopes = uint[4](0u, 0u, 0u, 0u);
    ism_v = ism_tile_of(begin);
    ism_part = (begin - ism_tile_at(ism_v)).xyxy + ivec4(0, 0, side - 1, side - 1);
    count = ism_v < glbk_ism_frame.maps.x && glbk_ism_frame.points.w != 0u ? glbk_ism_frame.maps.w : 0u;
    ism_l = ism_read_vpl(min(ism_v, glbk_ism_frame.points.x - 1u));
    for (uint i = thread; i < uint(ISM_SIDE * ISM_SIDE); i += ISM_THREADS) {
        ism_depths[i] = floatBitsToUint(ISM_FAR);
        ism_owners[i >> 1] = 0xffffffffu;
    }
    if (thread == 0u) ism_listed = 0u;
    barrier();
    for (int turn = 0; turn < 2; turn++) ism_draw_all(turn, count);
    for (uint i = thread; i < uint(ISM_SIDE * ISM_SIDE); i += ISM_THREADS) {
        ivec2 texel = ivec2(i % uint(ISM_SIDE), i / uint(ISM_SIDE));
        vec4 surfel = vec4(0.0, 0.0, 0.0, ISM_FAR);
        if (max(texel.x, texel.y) >= side) continue;
        if (ism_depths[i] != floatBitsToUint(ISM_FAR) && ism_find(ism_owner(i), s))
            surfel = vec4(s.g, uintBitsToFloat(ism_depths[i]));
        imageStore(glbk_ism_surfels_out, begin + texel, surfel);
    }
}
