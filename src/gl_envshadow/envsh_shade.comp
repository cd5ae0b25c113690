// envsh_shade.frag as a compute shader, with the sum of all lights in registers. Each group of 8 x 8 pixels
// takes 64 lights at a time into shared memory. Invocation i finds out about light i whether it is below the
// horizon of all normals of the group, and whether the cells say that all of the group is lit or dark. Only
// the lights that are left are asked for pixel by pixel.
// uses: envsh_chunk envsh_light envsh_group gbuffer
// sets: ENVSH_FILTER=1 ENVSH_RGBA=0 | ENVSH_FILTER=2 ENVSH_RGBA=1
// sets: ENVSH_FILTER=3 ENVSH_RGBA=0 | ENVSH_FILTER=4 ENVSH_RGBA=1
layout(local_size_x = 8, local_size_y = 8) in;

shared uint envsh_all_lit[2], envsh_asked[2];   // lights of the chunk, a bit for each

struct envsh_pixel { bool seen; vec3 p, n, flat_n; };

// Returns the bounds of the pixels of the group. They are the least of p, n, flat_n and of these three
// negated, which six rounds of halving find, where the chunk of lights will be.
envsh_group envsh_bounds(envsh_pixel pixel)
{
    uint thread = gl_LocalInvocationIndex;
    vec3 least[6] = vec3[6](pixel.p, pixel.n, pixel.flat_n, -pixel.p, -pixel.n, -pixel.flat_n);
    for (uint i = 0u; i < 6u; i++)
        envsh_chunk[64u * i + thread] = floatBitsToUint(vec4(pixel.seen ? least[i] : vec3(3e38), 0.0));
    for (uint left = 32u; left > 0u; left >>= 1) {
        barrier();
        for (uint i = thread; thread < left && i < 384u; i += 64u) {
            vec4 a = uintBitsToFloat(envsh_chunk[i]), b = uintBitsToFloat(envsh_chunk[i + left]);
            envsh_chunk[i] = floatBitsToUint(min(a, b));
        }
    }
    barrier();
    for (uint i = 0u; i < 6u; i++) least[i] = uintBitsToFloat(envsh_chunk[64u * i].xyz);
    return envsh_group(least[0], -least[3], least[1], -least[4], least[2], -least[5]);
}

// Loads lights from .. to - 1, at most 64, and sorts them: envsh_all_lit gets those that light all of the
// group, envsh_asked those that each pixel has to ask for.
void envsh_sort_lights(envsh_query q, envsh_group g, uint from, uint to)
{
    uint thread = gl_LocalInvocationIndex, bit = 1u << (thread & 31u);
    barrier();                                  // all have read the chunk before
    envsh_load_chunk(from, to);
    if (thread < 2u) envsh_all_lit[thread] = envsh_asked[thread] = 0u;
    barrier();
    if (from + thread < to) {
        int known = envsh_group_visible(q, g, from + thread);
        if (known > 0) atomicOr(envsh_all_lit[thread >> 5], bit);
        if (known < 0) atomicOr(envsh_asked[thread >> 5], bit);
    }
    barrier();
}

// Returns the number of the first bit that is set, and clears that bit.
uint envsh_take_first(inout uvec2 left)
{
    uint half_of = left.x != 0u ? 0u : 1u, bit = uint(findLSB(left[half_of]));
    left[half_of] &= left[half_of] - 1u;
    return 32u * half_of + bit;
}

void main()
{
    ivec2 at = ivec2(gl_GlobalInvocationID.xy), size = textureSize(glbk_gbuffer_place, 0);
    uint first = glbk_envsh_query.first_light, index = uint(at.y) * uint(size.x) + uint(at.x);
    bool inside = all(lessThan(at, size));
    envsh_query q = envsh_bound_query();
    envsh_pixel pixel;
    glbk_point point;
    pixel.seen = glbk_read_point(min(at, size - 1), point) && inside;
    pixel.p = point.position;
    pixel.n = pixel.seen ? point.normal : vec3(0.0);
    pixel.flat_n = pixel.seen ? point.geometric : vec3(0.0);
    envsh_group g = envsh_bounds(pixel);
    uint end = g.low.x < 3e38 ? glbk_envsh_query.end_light : first;     // no light where nothing is seen
    vec3 sum = inside && glbk_envsh_query.adds != 0u ? imageLoad(glbk_envsh_total, at).xyz : vec3(0.0);
    for (uint from = first; from < end; from += 64u) {
        envsh_sort_lights(q, g, from, end);
        for (uvec2 left = uvec2(envsh_all_lit[0], envsh_all_lit[1]); left != uvec2(0u);) {
            uint light = from + envsh_take_first(left);
            vec3 d = envsh_direction(light);
            if (dot(pixel.flat_n, d) > 0.0) sum += max(dot(pixel.n, d), 0.0) * envsh_power(light);
        }
        for (uvec2 left = uvec2(envsh_asked[0], envsh_asked[1]); left != uvec2(0u);) {
            uint light = from + envsh_take_first(left);
            sum += envsh_irradiance(q, light, light + 1u, pixel.p, pixel.n, pixel.flat_n, index);
        }
    }
    if (inside) imageStore(glbk_envsh_total, at, vec4(sum, 0.0));
}
