// ism_gbuffer - what is shaded: the points of the G-buffer.
// uses: cohsm_math ism_bindings gbuffer
struct ism_receiver { vec3 p, n, ng; };     // place; unit normals, for shading and the surface's own

// false: nothing is seen there, or a place that is no number, which a blur would spread.
bool ism_read_receiver(ivec2 at, out ism_receiver r)
{
    glbk_point p;
    bool seen = glbk_read_point(at, p);
    r.p = p.position;
    r.n = p.normal;
    r.ng = p.geometric;
    return seen && cohsm_finite3(r.p);
}
