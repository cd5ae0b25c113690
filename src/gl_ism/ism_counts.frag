// Draws how many surfels each VPL has: those with less than a half or a quarter of the mean flux have a half or a
// quarter of them, if ism_desc.vary_surfels says so.
// uses: ism_access ism_fold
// with: screen.vert
layout(location = 0) out uint result;

float ism_luminance_of(uint v)
{
    vec3 flux = ISM_TEXEL(4u * v + 2u).xyz;
    return (flux.x + flux.y + flux.z) * (1.0 / 3.0);
}

void main()
{
    uint count = ISM_F.vpl_count, n = ISM_S.surfel_count;
    uint v = ism_unfold(ISM_F.vpl_capacity).x;
    float mean = 0.0;
    result = n;
    if (ISM_S.vary_surfels == 0u || v >= count) return;
    for (uint i = 0u; i < count; i++) mean += ism_luminance_of(i);
    mean /= float(count);
    float flux = ism_luminance_of(v);
    if (flux < 0.5 * mean) result = n / 2u;
    if (flux < 0.25 * mean) result = n / 4u;
}
