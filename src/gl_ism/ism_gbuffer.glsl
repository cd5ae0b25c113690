// ism_gbuffer - what is shaded: four textures of positions, shading normals, face normals and albedos.
// uses: cohsm_math ism_bindings
struct ism_receiver { vec3 p, n, ng; };

// false: background, whose normal is not near unit length.
bool ism_read_receiver(ivec2 at, out ism_receiver r)
{
    r.p = glbk_unpack(texelFetch(glbk_ism_place, at, 0)).xyz;
    r.n = glbk_unpack(texelFetch(glbk_ism_normal, at, 0)).xyz;
    r.ng = glbk_unpack(texelFetch(glbk_ism_geometric, at, 0)).xyz;
    if (!cohsm_finite3(r.ng)) r.ng = r.n;
    float n2 = dot(r.n, r.n);
    return cohsm_finite3(r.p) && cohsm_finite3(r.n) && n2 > 0.25 && n2 < 4.0;
}
