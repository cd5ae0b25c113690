// ism_blur.frag as a compute shader. All that a group of 16 x 16 pixels looks at, up to four more pixels at
// each side, lies in shared memory.
// uses: ism_blur
layout(local_size_x = 16, local_size_y = 16) in;
#define ISM_TILE 24

shared vec3 ism_places[ISM_TILE * ISM_TILE], ism_normals[ISM_TILE * ISM_TILE];      // normal 0: nothing
shared vec4 ism_lights[ISM_TILE * ISM_TILE];

// Returns the first pixel that the group looks at.
ivec2 ism_corner() { return ivec2(gl_WorkGroupID.xy) * 16 - int(glbk_ism_view.interleave) / 2; }

bool ism_neighbour(ivec2 at, out ism_receiver r, out vec4 light)
{
    ivec2 texel = at - ism_corner();
    int i = texel.y * ISM_TILE + texel.x;
    r.p = ism_places[i];
    r.n = r.ng = ism_normals[i];
    light = ism_lights[i];
    return r.n != vec3(0.0);
}

// Loads wide x wide pixels into shared memory. A barrier has to follow.
void ism_load(int wide)
{
    for (int i = int(gl_LocalInvocationIndex); i < wide * wide; i += 256) {
        ivec2 texel = ivec2(i % wide, i / wide), at = ism_corner() + texel;
        int to = texel.y * ISM_TILE + texel.x;
        ism_receiver r;
        ism_normals[to] = vec3(0.0);
        if (clamp(at, ivec2(0), ism_picture_side() - 1) != at) continue;
        if (!ism_read_receiver(at, r)) continue;
        ism_places[to] = r.p;
        ism_normals[to] = r.n;
        ism_lights[to] = texelFetch(glbk_ism_light, at, 0);
    }
}

void main()
{
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    int side = int(glbk_ism_view.interleave);
    ism_receiver c;
    if (side > 1) ism_load(16 + side / 2 * 2);
    barrier();
    if (any(greaterThanEqual(at, ism_picture_side()))) return;
    imageStore(glbk_ism_light_out, at, ism_read_receiver(at, c) ? ism_finished(at, c) : vec4(0.0));
}
