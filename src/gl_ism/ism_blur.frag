// Blurs the light over the classes of pixels.
// uses: ism_blur
// with: screen.vert
layout(location = 0) out glbk_color result;

bool ism_neighbour(ivec2 at, out ism_receiver r, out vec4 light)
{
    bool inside = clamp(at, ivec2(0), ism_picture_side() - 1) == at;
    if (!inside || !ism_read_receiver(at, r)) return false;
    light = glbk_unpack(texelFetch(glbk_ism_light, at, 0));
    return true;
}

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    ism_receiver c;
    result = glbk_pack(ism_read_receiver(at, c) ? ism_finished(at, c) : vec4(0.0));
}
