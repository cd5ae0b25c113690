// mesh_hole - which pixels are holes, in passes that draw nothing but depth.
// uses: mesh_fragment
#ifdef GLBK_OWN_FRAGMENT
in vec2 glbk_uv;
#endif

bool glbk_is_hole()
{
#ifdef GLBK_OWN_FRAGMENT
    vec4 color = vec4(1.0);
    return !glbk_fragment(glbk_uv, color);
#else
    return false;
#endif
}
