// rsm_bound - the light whose map glbk_rsm_bind bound.
// uses: rsm_map
rsm_light rsm_bound()
{
    return rsm_light(glbk_rsm_light.position.xyz, glbk_rsm_light.right.xyz, glbk_rsm_light.up.xyz,
                    glbk_rsm_light.axis.xyz, glbk_rsm_light.value.xyz, glbk_rsm_light.position.w,
                    glbk_rsm_light.axis.w, glbk_rsm_light.value.w, int(glbk_rsm_light.up.w),
                    int(glbk_rsm_light.right.w));
}
