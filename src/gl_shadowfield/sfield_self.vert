// Draws self-visibility x cosine of objects that were drawn into the G-buffer, at the same places. Four
// attributes have four coefficients each.
// uses: sfield_bindings mesh_vertex
// sets: GLBK_PLACE
#ifndef SFIELD_SELF0
#define SFIELD_SELF0 4
#define SFIELD_SELF1 5
#define SFIELD_SELF2 6
#define SFIELD_SELF3 7
#endif
layout(location = SFIELD_SELF0) in vec4 self0;
layout(location = SFIELD_SELF1) in vec4 self1;
layout(location = SFIELD_SELF2) in vec4 self2;
layout(location = SFIELD_SELF3) in vec4 self3;
invariant gl_Position;
out vec4 sfield_self0, sfield_self1, sfield_self2, sfield_self3;

void main()
{
    vec3 place = (glbk_sfield_object.transform * vec4(glbk_vertex_place(), 1.0)).xyz; // computed as in gbuffer_draw.vert
    sfield_self0 = self0;
    sfield_self1 = self1;
    sfield_self2 = self2;
    sfield_self3 = self3;
    gl_Position = glbk_sfield_object.clip * vec4(place, 1.0);
}
