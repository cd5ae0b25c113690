// rsm_sampling - says how points about a receiver are taken, from what glbk_rsm_bind binds.
// uses: rsm_gather
rsm_sampling rsm_bound_sampling()
{
    rsm_sampling s;
    s.r_max = glbk_rsm_frame.r_max;
    s.offset = glbk_rsm_frame.offset;
    s.clamp_at = glbk_rsm_frame.clamp_at;
    s.near_limit = glbk_rsm_frame.near_limit;
    s.near_field = glbk_rsm_frame.near_field;
    s.set_count = glbk_rsm_frame.set_count;
    s.mixed = glbk_rsm_frame.mixed;
    s.picked = glbk_rsm_frame.picked;
    s.glossy = glbk_rsm_frame.material_count != 0u;
    return s;
}
