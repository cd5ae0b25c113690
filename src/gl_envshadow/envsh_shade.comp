// envsh_shade.frag as a compute shader, all lights with the sum in registers. Each group of 8 x 8 pixels takes 64
// lights at a time into shared memory; thread i finds out for light i whether it is under all normals of the group, lit
// or dark all over it by the cells, and only what is left is asked for pixel by pixel.
// uses: envsh_chunk envsh_light envsh_group gbuffer
// sets: ENVSH_FILTER=1 ENVSH_RGBA=0 | ENVSH_FILTER=2 ENVSH_RGBA=1 | ENVSH_FILTER=3 ENVSH_RGBA=0 | ENVSH_FILTER=4 ENVSH_RGBA=1
layout(local_size_x = 8, local_size_y = 8) in;

shared uint envsh_all_lit[2], envsh_asked[2];   // lights of the chunk, a bit each

struct envsh_pixel { bool seen; vec3 p, n, flat_n; };

// Bounds as least values of p, n, flat_n and of what they are negated, halved six times where the chunk will be.
envsh_group envsh_bounds(envsh_pixel pixel)
{
    uint thread = gl_LocalInvocationIndex;
    vec3 values[6] = vec3[6](pixel.p, pixel.n, pixel.flat_n, -pixel.p, -pixel.n, -pixel.flat_n);
    for (uint i = 0u; i < 6u; i++)
        envsh_chunk[64u * i + thread] = floatBitsToUint(vec4(pixel.seen ? values[i] : vec3(3e38), 0.0));
    for (uint left = 32u; left > 0u; left >>= 1) {
        barrier();
        for (uint i = thread; thread < left && i < 384u; i += 64u) {
            vec4 a = uintBitsToFloat(envsh_chunk[i]), b = uintBitsToFloat(envsh_chunk[i + left]);
            envsh_chunk[i] = floatBitsToUint(min(a, b));
        }
    }
    barrier();
    for (uint i = 0u; i < 6u; i++) values[i] = uintBitsToFloat(envsh_chunk[64u * i].xyz);
    return envsh_group(values[0], -values[3], values[1], -values[4], values[2], -values[5]);
}

void envsh_sort_lights(envsh_query q, envsh_group g, uint from, uint to)
{
    uint thread = gl_LocalInvocationIndex, bit = 1u << (thread & 31u);
    barrier();                                  // the chunk is no longer read
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

// The first of those bits, which is taken away.
uint envsh_take(inout uvec2 left)
{
    uint half_of = left.x != 0u ? 0u : 1u, bit = uint(findLSB(left[half_of]));
    left[half_of] &= left[half_of] - 1u;
    return 32u * half_of + bit;
}

void main()
{
    ivec2 at = ivec2(gl_GlobalInvocationID.xy), size = textureSize(glbk_gbuffer_place, 0);
    uvec4 range = glbk_envsh_query.range;       // lights from, to; width; 0 = the sum begins here
    uint index = uint(at.y) * range.z + uint(at.x);
    bool inside = all(lessThan(at, size));
    envsh_query q = envsh_bound_query();
    envsh_pixel pixel;
    glbk_point point;
    pixel.seen = glbk_read_point(min(at, size - 1), point) && inside;
    pixel.p = point.position;
    pixel.n = pixel.seen ? point.normal : vec3(0.0);
    pixel.flat_n = pixel.seen ? point.geometric : vec3(0.0);
    envsh_group g = envsh_bounds(pixel);
    uint to = g.low.x < 3e38 ? range.y : range.x;       // no light where nothing is seen
    vec3 sum = inside && range.w != 0u ? imageLoad(glbk_envsh_total, at).xyz : vec3(0.0);
    for (uint from = range.x; from < to; from += 64u) {
        envsh_sort_lights(q, g, from, to);
        for (uvec2 left = uvec2(envsh_all_lit[0], envsh_all_lit[1]); left != uvec2(0u);) {
            uint light = from + envsh_take(left);
            vec3 d = envsh_direction(light);
            if (dot(pixel.flat_n, d) > 0.0) sum += max(dot(pixel.n, d), 0.0) * envsh_power(light);
        }
        for (uvec2 left = uvec2(envsh_asked[0], envsh_asked[1]); left != uvec2(0u);) {
            uint light = from + envsh_take(left);
            sum += envsh_irradiance(q, light, light + 1u, pixel.p, pixel.n, pixel.flat_n, index);
        }
    }
    if (inside) imageStore(glbk_envsh_total, at, vec4(sum, 0.0));
}
