// Radiance of glbk_ism_shade, as colours.
// uses: ism_gbuffer picture
// with: screen.vert
layout(location = 0) out vec4 result;

void main()
{
    ivec2 at = glbk_picture_at();
    ism_receiver r = ism_receiver(vec3(0.0), vec3(0.0), vec3(0.0));
    bool seen = !glbk_picture_asks() || ism_read_receiver(at, r);
    glbk_picture_show(seen, r.p);
    result = glbk_unpack(texelFetch(glbk_ism_light, at, 0));
}
