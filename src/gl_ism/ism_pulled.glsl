// ism_pulled - reads the levels of pull that passes of fragments drew.
// uses: ism_bindings
int ism_pulled(int level, ivec2 cell)
{
    if (level == 1) return int(texelFetch(glbk_ism_pull1, cell, 0).x);
    if (level == 2) return int(texelFetch(glbk_ism_pull2, cell, 0).x);
    return int(texelFetch(glbk_ism_pull3, cell, 0).x);
}
