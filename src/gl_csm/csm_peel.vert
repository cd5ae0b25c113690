// Draws into a view of a builder; the position stands where glbk_csm_builder_desc says. The depth is a
// varying, so that nothing is cut off in front or behind; two programs compare it exactly, hence invariant.
// uses: csm_bindings
#ifndef GBUFFER_POSITION
#define GBUFFER_POSITION 0
#endif
layout(location = GBUFFER_POSITION) in vec3 position;
invariant gl_Position;
invariant out float csm_depth;

void main()
{
    vec4 p = glbk_csm_peel.view * vec4(position, 1.0);
    float w = glbk_csm_peel.depth_scale > 0.0 ? p.w : 1.0;
    csm_depth = glbk_csm_peel.depth_scale > 0.0 ? w * glbk_csm_peel.depth_scale : p.z;
    gl_Position = vec4(p.xy * glbk_csm_peel.clip_per_pixel - w, 0.0, w);
}
