// Does the work of rsm_smooth.frag as a compute shader. A group has 16 x 16 pixels, `step` apart, and brings
// them and those around them into shared memory, so that a pixel is fetched 1.27 times, not nine times. The
// groups of one part of the picture are step x step layers.
// uses: rsm_smooth
layout(local_size_x = 16, local_size_y = 16) in;
const int SIDE = 18;
shared vec4 rsm_places[SIDE * SIDE];        // place, and 1 if something is seen
shared vec4 rsm_lights[SIDE * SIDE];        // light, and alpha
shared vec3 rsm_normals[SIDE * SIDE];

// Returns where the neighbour `off` steps away lies in shared memory.
int rsm_here(ivec2 off)
{
    ivec2 at = ivec2(gl_LocalInvocationID.xy) + 1 + off;
    return at.y * SIDE + at.x;
}

bool rsm_neighbour(ivec2 at, ivec2 off, out rsm_receiver s, out vec3 light)
{
    int i = rsm_here(off);
    s = rsm_receiver(rsm_places[i].xyz, rsm_normals[i], 1.0);
    light = rsm_lights[i].xyz;
    return rsm_places[i].w > 0.0;
}

void main()
{
    int step = int(glbk_rsm_frame.step), layer = int(gl_WorkGroupID.z);
    ivec2 size = rsm_picture_side(), tile = ivec2(gl_WorkGroupID.xy) * 16;
    ivec2 from = ivec2(layer % step, layer / step);
    ivec2 at = (tile + ivec2(gl_LocalInvocationID.xy)) * step + from;
    for (int i = int(gl_LocalInvocationIndex); i < SIDE * SIDE; i += 256) {
        ivec2 there = (tile + ivec2(i % SIDE, i / SIDE) - 1) * step + from;
        rsm_receiver r = rsm_receiver(vec3(0.0), vec3(0.0), 0.0);
        bool seen = all(greaterThanEqual(there, ivec2(0))) && all(lessThan(there, size));
        if (seen) seen = rsm_read(there, r);
        rsm_places[i] = vec4(r.position, seen ? 1.0 : 0.0);
        rsm_normals[i] = r.normal;
        rsm_lights[i] = seen ? texelFetch(glbk_rsm_sum, there, 0) : vec4(0.0);
    }
    barrier();
    if (any(greaterThanEqual(at, size))) return;
    int here = rsm_here(ivec2(0));
    rsm_receiver r = rsm_receiver(rsm_places[here].xyz, rsm_normals[here], 1.0);
    vec4 sum = vec4(0.0);
    if (rsm_places[here].w > 0.0) sum = rsm_smooth(at, r, rsm_lights[here]);
    imageStore(glbk_rsm_picture, at, sum);
}
