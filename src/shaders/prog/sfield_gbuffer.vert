// Attributes 0 position, 1 normal, 2 to 5 the coefficients of own visibility x cosine at the vertex.
// uses: sfield_bindings
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 self0;
layout(location = 3) in vec4 self1;
layout(location = 4) in vec4 self2;
layout(location = 5) in vec4 self3;
out vec3 sfield_place_at, sfield_facing;
out vec4 sfield_self0, sfield_self1, sfield_self2, sfield_self3;

void main()
{
    mat3 m = mat3(glbk_sfield_object.world);
    sfield_place_at = (glbk_sfield_object.world * vec4(position, 1.0)).xyz;
    sfield_facing = m * normal;                 // entities scale evenly
    sfield_self0 = self0;
    sfield_self1 = self1;
    sfield_self2 = self2;
    sfield_self3 = self3;
    gl_Position = glbk_sfield_object.clip * vec4(sfield_place_at, 1.0);
}
