// Draws one object into the G-buffer, with maps of its colour, its gloss and its normals.
// uses: gbuffer_bindings gbuffer_drawn gbuffer_write mesh_fragment
// with: gbuffer_draw.vert
// sets: | GBUFFER_POSITION=5 GBUFFER_NORMAL=-1 GBUFFER_UV=-1 GBUFFER_TANGENT=-1
in vec3 glbk_place, glbk_facing;
in vec2 glbk_uv;
in vec4 glbk_along;

const uint has_color_map = 1u, has_gloss_map = 2u, has_normal_map = 4u;

bool has(uint map) { return (glbk_gbuffer_drawn.maps & map) != 0u; }

// Maps are fetched before anything is discarded: their levels of detail come from all pixels of a quad.
void main()
{
    glbk_point p;
    p.position = glbk_place;
    p.geometric = glbk_unit(cross(dFdx(glbk_place), dFdy(glbk_place)));
    if (dot(p.geometric, p.geometric) == 0.0)       // so far from the origin that neighbours have one place
        p.geometric = glbk_unit(glbk_facing);
    if (dot(p.geometric, glbk_gbuffer_drawn.eye.xyz - glbk_place) < 0.0) p.geometric = -p.geometric;
    vec3 n = dot(glbk_facing, glbk_facing) > 0.0 ? glbk_unit(glbk_facing) : p.geometric;
    if (dot(n, p.geometric) < 0.0) n = -n;
    p.tangent = glbk_unit(glbk_along.xyz - n * dot(glbk_along.xyz, n));
    if (has(has_normal_map)) {
        vec3 bump = texture(glbk_gbuffer_normal_map, glbk_uv).xyz * 2.0 - 1.0;
        bump.y *= glbk_along.w < 0.0 ? -1.0 : 1.0;
        if (dot(p.tangent, p.tangent) > 0.0)
            n = glbk_unit(p.tangent * bump.x + cross(n, p.tangent) * bump.y + n * bump.z);
    }
    p.normal = n;
    vec4 color = glbk_gbuffer_drawn.diffuse;
    vec3 map = vec3(1.0);
    if (has(has_color_map)) color *= texture(glbk_gbuffer_color_map, glbk_uv);
    if (has(has_gloss_map)) map = texture(glbk_gbuffer_gloss_map, glbk_uv).xyz;
    bool there = glbk_fragment(glbk_uv, color);
    if (!there || color.a < glbk_gbuffer_drawn.alpha_cutoff) discard;
    p.diffuse = color.xyz;
    glbk_set_gloss(p, glbk_gbuffer_drawn.gloss, map);
    p.kind = glbk_gbuffer_drawn.kind;
    p.entity = glbk_gbuffer_drawn.entity;
    p.plane = glbk_gbuffer_drawn.plane;
    p.occlusion = glbk_gbuffer_drawn.occlusion;
    p.lobe = glbk_gbuffer_drawn.first_lobe;
    p.lobe_count = glbk_gbuffer_drawn.lobe_count;
    glbk_write_point(p);
}
