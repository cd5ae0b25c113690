// The directions of the texels of a tile, which all VPLs share but lobes and skies.
// uses: ism_map ism_bindings
// with: screen.vert
// sets: ISM_PROJECTION=1 | ISM_PROJECTION=2 | ISM_PROJECTION=3 | ISM_PROJECTION=4
layout(location = 0) out glbk_color result;

void main()
{
    result = glbk_pack(vec4(ism_map_direction(ism_projection_of(1.0), 1.0, gl_FragCoord.xy / float(glbk_ism_frame.maps.y)), 0.0));
}
