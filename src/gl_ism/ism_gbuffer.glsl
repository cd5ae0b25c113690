// ism_gbuffer - reads the receivers: the points of the G-buffer.
// uses: cohsm_math ism_bindings gbuffer
struct ism_receiver {
    vec3 p;                     // position
    vec3 n, ng;                 // unit normals, for shading and of the surface
};

// Returns width and height of the picture.
ivec2 ism_picture_side() { return ivec2(glbk_ism_view.width, glbk_ism_view.height); }

// Reads the point of a pixel. Returns false if nothing is seen there, or if the position is no number, which
// a blur would spread.
bool ism_read_receiver(ivec2 at, out ism_receiver r)
{
    glbk_point p;
    bool seen = glbk_read_point(at, p);
    r.p = p.position;
    r.n = p.normal;
    r.ng = p.geometric;
    return seen && cohsm_finite3(r.p);
}
