// Lights each pixel by its own class of VPLs: every interleave^2-th of them (interleaved sampling, section
// 6.2).
// uses: ism_gbuffer ism_light
// with: screen.vert
// sets: ISM_PROJECTION=1 ISM_NEAR=1 | ISM_PROJECTION=2 ISM_NEAR=2 | ISM_PROJECTION=3 ISM_NEAR=3
// sets: ISM_PROJECTION=4 ISM_NEAR=4 | ISM_NEAR=5 | ISM_NEAR=6
layout(location = 0) out glbk_color result;

void main()
{
    ivec2 at = ISM_HERE;
    uint side = glbk_ism_view.interleave;
    uvec2 place = uvec2(at) % side;
    ism_receiver r;
    vec4 light = vec4(0.0);
    if (ism_read_receiver(at, r)) light = ism_light(r.p, r.n, r.ng, place.y * side + place.x, side * side);
    result = glbk_pack(light);
}
