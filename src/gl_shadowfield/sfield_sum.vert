// Covers the texels of a tile, an instance each, by a strip of four vertices over one face of one eye's cube.
// uses: sfield_bindings
// sets: SFIELD_SOURCE=0 | SFIELD_SOURCE=1
flat out uint sfield_tile;

void main()
{
    uvec4 place = glbk_sfield_views.places[gl_InstanceID];
    uint side = glbk_sfield_views.side;
    vec2 corner = vec2(float(gl_VertexID & 1) + float(place.x), float(gl_VertexID >> 1) + float(place.y));
    sfield_tile = uint(gl_InstanceID);
    gl_Position = vec4(2.0 * corner / vec2(6.0, float(glbk_sfield_views.batch)) - 1.0, 0.0, 1.0);
}
