// ism_pvpl - reads the texels of a source, which might become VPLs (pVPLs).
// uses: cohsm_math ism_choice
struct ism_pvpl {
    vec3  position, normal, flux;
    float area;
    float luminance;            // mean of the flux's channels; 0: the texel is never chosen
};

// Reads texel (x, y) of the faces' picture, in which face lies above face. Texels are never chosen if their
// flux is not 0..1e30 or their vectors cannot be used. cohsm_finite3 looks at bits, since compilers need not
// make a comparison with what is no number false.
ism_pvpl ism_read_pvpl(ivec2 at)
{
    int side = int(ISM_C.face_height), face = at.y / side;
    ivec3 to = ivec3(at.x, at.y - face * side, 3 * face);
    vec4 place = ISM_FLOATS(glbk_ism_texels, to);
    vec4 normal = ISM_FLOATS(glbk_ism_texels, to + ivec3(0, 0, 1));
    vec4 flux = ISM_FLOATS(glbk_ism_texels, to + ivec3(0, 0, 2));
    float length2 = dot(normal.xyz, normal.xyz);
    bool usable = cohsm_finite3(place.xyz) && cohsm_finite3(normal.xyz) && cohsm_finite3(flux.xyz);
    usable = usable && clamp(length2, 0.9409, 1.0609) == length2 && clamp(flux.xyz, 0.0, 1e30) == flux.xyz;
    float luminance = 0.0;
    if (usable) luminance = (flux.x + flux.y + flux.z) * (1.0 / 3.0);
    return ism_pvpl(place.xyz, normal.xyz, flux.xyz, flux.w, luminance);
}

// Finds where a place lies in clip space. Returns false if that is at infinity, far outside, or unknown.
bool ism_to_clip(vec3 p, out vec2 at)
{
    vec4 c = ISM_C.world_to_clip * vec4(p, 1.0);
    bool known = abs(c.w) > 1e-20;
    at = vec2(0.0);
    if (known) at = c.xy / c.w;
    return known && abs(at.x) < 8.0 && abs(at.y) < 8.0;
}
