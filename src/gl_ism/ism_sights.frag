// Draws those receivers of 64 blocks of the picture that lie farthest in eight directions, such as the corners of a
// wall: a window that holds them holds nearly all others. FROM=0 each block in 32 slices, two pictures of four
// directions each: 1 + the pixel's number, or 0; FROM=1 blocks whole, a row a direction: place and 1, or 0; normal.
// uses: ism_pvpl gbuffer
// with: screen.vert
// sets: FROM=0 | FROM=1
#ifndef FROM
#define FROM 0
#endif
layout(location = 0) out uvec4 first;
layout(location = 1) out uvec4 second;

// Returns how far a place lies in four directions, whose unequal weights let no two points of a grid lie equally far.
vec4 ism_reach(vec3 p, float z)
{
    return p.x * vec4(-1.0, 1.0, -1.0, 1.0) + 0.9 * (p.y * vec4(-1.0, -1.0, 1.0, 1.0)) + 1.1 * z;
}

// Keeps of each direction the pixel that lies farther.
void ism_keep(uint pixel, vec4 reach, inout uvec4 best, inout vec4 most)
{
    bvec4 better = greaterThan(reach, most);
    best += (uvec4(pixel) - best) * uvec4(better);
    most = max(reach, most);
}

void main()
{
    ivec2 at = ISM_HERE, side = ivec2(ISM_C.view_width, ISM_C.view_height);
    glbk_point p;
    first = second = uvec4(0u);
#if FROM == 0
    int rows = side.y < 8 ? 1 : 8;
    ivec2 blocks = ivec2(64 / rows, rows), block = ivec2(at.x % blocks.x, at.x / blocks.x);
    ivec2 from = side * block / blocks, to = side * (block + 1) / blocks;
    vec4 most0 = vec4(-3e38), most1 = most0;
    int y = from.y + (to.y - from.y) * at.y / 32, end = from.y + (to.y - from.y) * (at.y + 1) / 32;
    for (; y < end; y++)
        for (int x = from.x; x < to.x; x++) {
            bool seen = glbk_read_point(ivec2(x, y), p);
            if (seen && cohsm_finite3(p.position) && dot(p.normal, p.normal) > 0.25) {
                uint pixel = uint(y * side.x + x) + 1u;
                ism_keep(pixel, ism_reach(p.position, -p.position.z), first, most0);
                ism_keep(pixel, ism_reach(p.position, p.position.z), second, most1);
            }
        }
#else
    float most = -3e38;
    for (int k = 0; k < 32; k++) {
        int pixel = int(texelFetch(glbk_ism_sights, ivec3(at.x, k, at.y >> 2), 0)[at.y & 3]) - 1, i = max(pixel, 0);
        bool seen = glbk_read_point(ivec2(i % side.x, i / side.x), p);
        float reach = ism_reach(p.position, p.position.z * (at.y < 4 ? -1.0 : 1.0))[at.y & 3];
        if (seen && pixel >= 0 && reach > most) {
            most = reach;
            first = floatBitsToUint(vec4(p.position, 1.0));
            second = floatBitsToUint(vec4(p.geometric, 0.0));
        }
    }
#endif
}
