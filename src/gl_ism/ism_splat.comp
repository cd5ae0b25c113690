// Does the work of ism_splat.vert and .frag as a compute shader. A group draws all surfels of a VPL into up
// to 64 x 64 texels of its tile, in shared memory. It draws them twice: first for the depths alone, then to
// find out which surfel has each depth, the first one of several, as the depth test decides. Discs of many
// texels go to a list, where 32 invocations draw each of them, so that no 31 invocations wait for one.
// uses: ism_disc
// sets: ISM_PROJECTION=1 | ISM_PROJECTION=4
layout(local_size_x = 512) in;
#define ISM_THREADS 512u
#define ISM_SIDE 64
#define ISM_WIDE 64             // discs of more texels go to the list
#define ISM_LIST 112u           // discs of the list, for which 32 KiB of shared memory leave room
#define ISM_HOPE 0x80000000u    // says that the disc was the nearest in a texel once

shared uint ism_depths[ISM_SIDE * ISM_SIDE];            // bits of floats, in whose order positive floats lie
shared uint ism_owners[ISM_SIDE * ISM_SIDE / 2];        // numbers of surfels, 16 bits each
shared vec4 ism_list[4u * ISM_LIST];                    // of each disc four: at and radius2; g; cut1; cut2
shared uint ism_numbers[ISM_LIST], ism_listed;
shared uint ism_boxes[ISM_LIST];                        // four bytes of each disc, and ISM_HOPE

uint ism_v;             // the VPL
ism_vpl ism_l;
ivec4 ism_part;         // the first and the last texel of its tile that the group draws
uint ism_hopes[4];      // a bit for each surfel of this invocation that had a texel once

// Finds surfel i of the VPL, counted phase after phase, and its texels in this part. Returns false if it has
// none.
bool ism_find(uint i, out ism_surfel s)
{
    uint each = ISM_F.phase_surfel_count;
    uint index = (i / each * ISM_F.vpl_capacity + ism_v) * each + i % each;
    if (!ism_surfel_of(index, ism_v, ism_l, s)) return false;
    s.box = ivec4(max(s.box.xy, ism_part.xy), min(s.box.zw, ism_part.zw));
    return s.box.x <= s.box.z && s.box.y <= s.box.w;
}

// Returns which surfel a texel belongs to.
uint ism_owner(uint texel) { return ism_owners[texel >> 1] >> (16u * (texel & 1u)) & 0xffffu; }

// Gives a texel to a surfel, unless one of a lower number has it: the atomic minimum of 16 bits.
void ism_own(uint texel, uint surfel)
{
    uint shift = 16u * (texel & 1u), was = ism_owners[texel >> 1];
    while ((was >> shift & 0xffffu) > surfel) {
        uint now = atomicCompSwap(ism_owners[texel >> 1], was, (was & ~(0xffffu << shift)) | surfel << shift);
        if (now == was) break;
        was = now;
    }
}

// Draws every `pace`th texel of a disc, beginning at `from`, in one loop, which invocations that draw beside
// each other leave together. Returns whether the disc was the nearest in one of the texels.
bool ism_draw(int turn, uint i, ism_surfel s, ivec2 from, ivec2 pace)
{
    ivec2 at = s.box.xy + from;
    bool nearest = false;
    while (at.x <= s.box.z && at.y <= s.box.w) {
        uint texel = uint((at.y - ism_part.y) * ISM_SIDE + at.x - ism_part.x), depth = ism_depths[texel];
        float t = ism_meet(ism_l.sky, s, ism_texel_direction(ism_l.grid, at), uintBitsToFloat(depth));
        if (t < ISM_FAR) {
            uint bits = floatBitsToUint(t);
            if (turn == 0) nearest = atomicMin(ism_depths[texel], bits) >= bits || nearest;
            else if (depth == bits) ism_own(texel, i);
        }
        at.x += pace.x;
        if (at.x > s.box.z) at = ivec2(s.box.x + from.x, at.y + pace.y);
    }
    return nearest;
}

// Packs the texels of a disc.
uint ism_pack(ivec4 box)
{
    uvec4 b = uvec4(box - ism_part.xyxy);
    return b.x | b.y << 8 | b.z << 16 | b.w << 24;
}

// Returns disc k of the list.
ism_surfel ism_unlist(uint k)
{
    vec4 a = ism_list[4u * k], b = ism_list[4u * k + 1u];
    uint box = ism_boxes[k];
    ivec4 texels = ivec4(box & 63u, box >> 8 & 63u, box >> 16 & 63u, box >> 24 & 63u) + ism_part.xyxy;
    return ism_surfel(a.xyz, b.xyz, a.w, 0.0, vec2(0.0), ism_list[4u * k + 2u], ism_list[4u * k + 3u],
                      texels);
}

// Draws the discs that invocations have for the list, as many at a time as the list holds. Returns whether
// the disc of this invocation was the nearest in a texel. All invocations call it.
bool ism_draw_list(int turn, uint i, ism_surfel s, bool waits)
{
    uint thread = gl_LocalInvocationIndex, count;
    ivec2 mine = ivec2(thread & 7u, thread / 8u & 3u);      // of the 8 x 4 texels that 32 draw at a time
    bool nearest = false;
    do {
        uint k = waits ? atomicAdd(ism_listed, 1u) : ISM_LIST;
        bool listed = k < ISM_LIST;
        if (listed) {
            ism_list[4u * k] = vec4(s.at, s.radius2);
            ism_list[4u * k + 1u] = vec4(s.g, 0.0);
            ism_list[4u * k + 2u] = s.cut1;
            ism_list[4u * k + 3u] = s.cut2;
            ism_boxes[k] = ism_pack(s.box);
            ism_numbers[k] = i;
        }
        waits = waits && !listed;
        barrier();
        count = ism_listed;
        for (uint d = thread / 32u; d < min(count, ISM_LIST); d += ISM_THREADS / 32u)
            if (ism_draw(turn, ism_numbers[d], ism_unlist(d), mine, ivec2(8, 4)))
                atomicOr(ism_boxes[d], ISM_HOPE);
        barrier();
        if (thread == 0u) ism_listed = 0u;
        if (listed && (ism_boxes[k] & ISM_HOPE) != 0u) nearest = true;
        barrier();
    } while (count > ISM_LIST);
    return nearest;
}

// Draws all surfels, one of each invocation at a time. The second turn passes by those that had no texel in
// the first.
void ism_draw_all(int turn, uint count)
{
    for (uint start = 0u; start < count; start += ISM_THREADS) {
        uint i = start + gl_LocalInvocationIndex, lap = start / ISM_THREADS;
        uint word = lap >> 5, bit = 1u << (lap & 31u);
        ism_surfel s;
        bool there = i < count && (turn == 0 || (ism_hopes[word] & bit) != 0u) && ism_find(i, s);
        ivec2 wide = there ? s.box.zw - s.box.xy + 1 : ivec2(0);
        bool waits = wide.x * wide.y > ISM_WIDE;
        bool nearest = there && !waits && ism_draw(turn, i, s, ivec2(0), ivec2(1));
        if (ism_draw_list(turn, i, s, waits) || nearest) ism_hopes[word] |= bit;
    }
}

void main()
{
    uint thread = gl_LocalInvocationIndex, count;
    int side = min(int(ISM_F.tile_side), ISM_SIDE);
    ivec2 begin = ivec2(gl_WorkGroupID.xy) * side;
    ism_surfel s;
    ism_hopes = uint[4](0u, 0u, 0u, 0u);
    ism_v = ism_tile_of(begin);
    ism_part = (begin - ism_tile_at(ism_v)).xyxy + ivec4(0, 0, side - 1, side - 1);
    count = ISM_F.triangle_count != 0u ? ISM_F.surfel_count : 0u;
    if (ism_v >= ISM_F.vpl_count) count = 0u;
    ism_l = ism_read_vpl(min(ism_v, ISM_F.vpl_capacity - 1u));
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
        imageStore(glbk_ism_planes_out, begin + texel, surfel);
    }
}
