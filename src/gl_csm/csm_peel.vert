// Draws into a view of a builder. The depth is a varying, so that nothing is cut off in front or behind; two
// programs compare it exactly, hence invariant.
// uses: csm_bindings mesh_vertex
// sets: GLBK_PLACE
invariant gl_Position;
invariant out float csm_depth;

void main()
{
    vec4 p = glbk_csm_peel.view * vec4(glbk_vertex_place(), 1.0);
    float w = glbk_csm_peel.depth_scale > 0.0 ? p.w : 1.0;
    csm_depth = glbk_csm_peel.depth_scale > 0.0 ? w * glbk_csm_peel.depth_scale : p.z;
    gl_Position = vec4(p.xy * glbk_csm_peel.clip_per_pixel - w, 0.0, w);
}
