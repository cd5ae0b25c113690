// Draws 1 for each surfel of a layer of the table whose triangle is gone, and 0 for the others.
// uses: ism_bindings
// with: screen.vert
layout(location = 0) out uint result;

void main()
{
    uvec4 surfel = texelFetch(glbk_ism_surfels, ivec3(gl_FragCoord.xy, glbk_ism_scattering.layer), 0);
    result = surfel.x < glbk_ism_scattering.triangle_count ? 0u : 1u;
}
