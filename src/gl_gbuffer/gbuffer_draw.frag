// One object into the G-buffer, with maps of its colour, its gloss and its normals.
// uses: gbuffer_bindings gbuffer_drawn gbuffer_write
// with: gbuffer_draw.vert
// sets: | GBUFFER_POSITION=5 GBUFFER_NORMAL=-1 GBUFFER_UV=-1 GBUFFER_TANGENT=-1
in vec3 glbk_place, glbk_facing;
in vec2 glbk_uv;
in vec4 glbk_along;

void main()
{
    uvec4 numbers = glbk_gbuffer_drawn.numbers;     // kind, entity, plane, maps as bits
    vec3 view = glbk_gbuffer_drawn.eye.xyz - glbk_place;
    vec3 flat_n = glbk_unit(cross(dFdx(glbk_place), dFdy(glbk_place)));
    if (dot(flat_n, flat_n) == 0.0) flat_n = glbk_unit(glbk_facing);        // so far out, all one place
    if (dot(flat_n, view) < 0.0) flat_n = -flat_n;
    vec3 n = dot(glbk_facing, glbk_facing) > 0.0 ? glbk_unit(glbk_facing) : flat_n;
    if (dot(n, flat_n) < 0.0) n = -n;
    vec3 t = glbk_unit(glbk_along.xyz - n * dot(glbk_along.xyz, n)), map = vec3(1.0);
    vec4 color = glbk_gbuffer_drawn.diffuse;
    if ((numbers.w & 4u) != 0u) {                   // fetched where all of a quad do, for the level
        vec3 bump = texture(glbk_gbuffer_normal_map, glbk_uv).xyz * 2.0 - 1.0;
        bump.y *= glbk_along.w < 0.0 ? -1.0 : 1.0;
        if (dot(t, t) > 0.0) n = glbk_unit(t * bump.x + cross(n, t) * bump.y + n * bump.z);
    }
    if ((numbers.w & 1u) != 0u) color *= texture(glbk_gbuffer_color_map, glbk_uv);
    if ((numbers.w & 2u) != 0u) map = texture(glbk_gbuffer_gloss_map, glbk_uv).xyz;
    if (color.a < glbk_gbuffer_drawn.values.x) discard;
    glbk_write_surface(glbk_place, n, flat_n, t, numbers, glbk_gbuffer_drawn.lobes, color.xyz,
                       glbk_gbuffer_drawn.gloss, map, glbk_gbuffer_drawn.values.y);
}
