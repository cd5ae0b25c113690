// The directions of the texels of a tile, which all VPLs share but lobes and skies.
// uses: ism_map ism_bindings
// with: screen.vert
layout(location = 0) out glbk_color result;

void main()
{
    uint p = glbk_ism_frame.maps.w == ISM_PROJECTION_LOBE ? ISM_PROJECTION_COSINE : glbk_ism_frame.maps.w;
    result = glbk_pack(vec4(ism_map_direction(p, 1.0, gl_FragCoord.xy / float(glbk_ism_frame.maps.y)), 0.0));
}
