// Does the work of sfield_sum.frag as a compute shader: a work group counts the samples of a row of texels of
// a tile. Each invocation adds up columns, neighbours side by side (two columns of alpha, by gathers of 2 x
// 2), then texels are made of columns.
// uses: sfield_bindings
// sets: SFIELD_SOURCE=0 | SFIELD_SOURCE=1
layout(local_size_x = 32) in;
#if SFIELD_SOURCE
shared vec3 sfield_columns[256];
#else
shared uint sfield_columns[256];
#endif

void main()
{
    uvec4 place = glbk_sfield_views.places[gl_WorkGroupID.y];
    uint width = glbk_sfield_views.width, side = glbk_sfield_views.side, scale = width / side;
    uint me = gl_LocalInvocationID.x;
    ivec2 from = ivec2(place.zw * width + uvec2(0u, gl_WorkGroupID.x * scale));
    ivec2 to = ivec2(place.x * side, place.y * side + gl_WorkGroupID.x);
    float share = 1.0 / float(scale * scale);
#if SFIELD_SOURCE
    for (uint x = me; x < width; x += 32u) {
        vec3 sum = vec3(0.0);
        for (uint y = 0u; y < scale; y++)
            sum += uintBitsToFloat(texelFetch(glbk_sfield_seen, from + ivec2(x, y), 0).xyz);
        sfield_columns[x] = sum;
    }
    memoryBarrierShared();
    barrier();
    for (uint x = me; x < side; x += 32u) {
        vec3 sum = vec3(0.0);
        for (uint k = 0u; k < scale; k++) sum += sfield_columns[x * scale + k];
        imageStore(glbk_sfield_cube_image, to + ivec2(x, 0), uvec4(floatBitsToUint(sum * share), 0u));
    }
#else
    vec2 unit = 1.0 / vec2(textureSize(glbk_sfield_seen, 0));
    for (uint x = me; x < width / 2u; x += 32u) {
        uvec4 sum = uvec4(0u);
        for (uint y = 0u; y < scale; y += 2u)
            sum += textureGather(glbk_sfield_seen, vec2(from + ivec2(2u * x + 1u, y + 1u)) * unit);
        sfield_columns[x] = sum.x + sum.y + sum.z + sum.w;
    }
    memoryBarrierShared();
    barrier();
    for (uint x = me; x < side / 4u; x += 32u) {
        uvec4 sum = uvec4(0u);
        for (uint k = 0u; k < scale / 2u; k++)
            for (uint i = 0u; i < 4u; i++) sum[i] += sfield_columns[(4u * x + i) * (scale / 2u) + k];
        ivec2 at = ivec2(place.x * side / 4u + x, to.y);
        imageStore(glbk_sfield_cube_image, at, floatBitsToUint(vec4(sum) * share));
    }
#endif
}
