// ism_densities - which share of all points triangles and clusters have by what the picture sees of them.
// uses: ism_fold

// Returns the share of what has this area and this solid angle: of solid angles, and a little of areas, so
// that triangles that are seen from their edge are drawn too.
float ism_density(vec2 sizes)
{
    vec2 all = ISM_FLOATS(glbk_ism_totals, ivec2(0)).xy;
    float by_area = 1.0, by_solid = 0.0;
    if (all.y > 0.0) {
        by_area = ISM_S.area_share;
        by_solid = (1.0 - by_area) / all.y;
    }
    return sizes.x * (by_area / max(all.x, 1e-37)) + sizes.y * by_solid;
}
