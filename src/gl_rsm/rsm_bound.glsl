// rsm_bound - returns the light whose map glbk_rsm_bind bound.
// uses: rsm_map
rsm_light rsm_bound()
{
    rsm_light l;
    l.position = glbk_rsm_light.position.xyz;
    l.right = glbk_rsm_light.right.xyz;
    l.up = glbk_rsm_light.up.xyz;
    l.axis = glbk_rsm_light.axis.xyz;
    l.value = glbk_rsm_light.value.xyz;
    l.extent = glbk_rsm_light.extent;
    l.cos_half = glbk_rsm_light.cos_half;
    l.side = float(glbk_rsm_light.side);
    l.faces = int(glbk_rsm_light.face_count);
    l.kind = int(glbk_rsm_light.kind);
    return l;
}
