// A texel whose ray meets the disc gets its plane and its depth there. No disc is widened to a whole texel.
// uses: ism_access
// with: ism_splat.vert
// sets: ISM_PROJECTION=1 ISM_QUADS=0 | ISM_PROJECTION=4 ISM_QUADS=1
flat in vec4 ism_at;
flat in vec4 ism_plane;
flat in ivec4 ism_box;
flat in vec4 ism_cut1;
flat in vec4 ism_cut2;
layout(location = 0) out glbk_color result;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    if (any(lessThan(at, ism_box.xy)) || any(greaterThan(at, ism_box.zw))) discard;
    bool sky = ism_plane.w < 0.0;
    vec3 w = ism_texel_direction(ism_plane.w, at & (int(glbk_ism_frame.maps.y) - 1));
    float t = ism_plane_depth(sky, ism_plane.xyz, w);
    if (!(t > 0.0 && t < ISM_FAR)) discard;
    vec3 d = (sky ? vec3(w.xy * glbk_ism_frame.sphere.w, t) : w * t) - ism_at.xyz;
    if (!(dot(d, d) <= ism_at.w)) discard;
    vec2 b = vec2(ism_cut1.w + dot(d, ism_cut1.xyz), ism_cut2.w + dot(d, ism_cut2.xyz));
    if (ism_cut1.w > -1.0 && !(min(b.x, b.y) >= -1e-4 && b.x + b.y <= 1.0001)) discard;
    result = glbk_pack(vec4(ism_plane.xyz, t));
    gl_FragDepth = t * 5.421010862427522e-20;      // 2^-64: every digit of t is kept
}
