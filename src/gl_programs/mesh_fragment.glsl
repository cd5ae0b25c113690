// mesh_fragment - which pixels of your meshes are there, and their colour, if a function of yours decides
// (glbk_attributes.fragment).
#ifdef GLBK_OWN_FRAGMENT
bool glbk_fragment(vec2 uv, inout vec4 color);
#else
bool glbk_fragment(vec2 uv, inout vec4 color) { return true; }
#endif
