// ism_directions.frag as a compute shader, into the texture and a buffer.
// uses: ism_map ism_bindings
// sets: ISM_PROJECTION=1 | ISM_PROJECTION=2 | ISM_PROJECTION=3 | ISM_PROJECTION=4
layout(local_size_x = 8, local_size_y = 8) in;

void main()
{
    uvec2 at = gl_GlobalInvocationID.xy;        // tiles are multiples of 8
    vec2 uv = (vec2(at) + 0.5) / float(glbk_ism_frame.maps.y);
    vec4 w = vec4(ism_map_direction(ism_projection_of(1.0), 1.0, uv), 0.0);
    glbk_ism_ways[at.y * glbk_ism_frame.maps.y + at.x] = w;
    imageStore(glbk_ism_directions_out, ivec2(at), w);
}
