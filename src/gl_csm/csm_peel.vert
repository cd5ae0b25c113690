// A view of a csm builder: attribute 0 is the position. Depth is a varying, so that nothing is cut in front or behind;
// two programs peel with it and compare it exactly, hence invariant.
// uses: csm_bindings
layout(location = 0) in vec3 position;
invariant gl_Position;
invariant out float csm_depth;

void main()
{
    vec4 p = glbk_csm_peel.view * vec4(position, 1.0);
    float w = glbk_csm_peel.values.y > 0.0 ? p.w : 1.0;
    csm_depth = glbk_csm_peel.values.y > 0.0 ? w * glbk_csm_peel.values.y : p.z;
    gl_Position = vec4(p.xy * glbk_csm_peel.values.x - w, 0.0, w);
}
