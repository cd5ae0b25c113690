// mesh_fragment - which pixels of your meshes are there, and their colour, if a function of yours decides
// (glbk_attributes.fragment). In passes that draw nothing but depth, glbk_is_hole asks it.
#ifdef GLBK_OWN_FRAGMENT
bool glbk_fragment(vec2 uv, inout vec4 color);
#else
bool glbk_fragment(vec2 uv, inout vec4 color) { return true; }
#endif
#ifdef GLBK_PLACE
#ifdef GLBK_OWN_FRAGMENT
in vec2 glbk_uv;
#else
const vec2 glbk_uv = vec2(0.0);
#endif

bool glbk_is_hole()
{
    vec4 color = vec4(1.0);
    return !glbk_fragment(glbk_uv, color);
}
#endif
