// cohsm_light - samples a light and finds where a ray hits it: its function A (what emits), shape by shape.
// D, that is where the maps are, stands in the blocks. C twins: lsamp_light_sample and lsamp_light_hit of
// lightsampling.h. It needs what cohsm_emission.glsl needs.
// uses: cohsm_emission cohsm_octa

// ---- environment ----

// Sets the emission of a texel of the sky in direction w; returns whether there is any.
bool cohsm_environment_found(const in cohsm_light l, uvec2 cell, vec2 x, vec3 w, inout cohsm_emission e)
{
    vec4 texel = cohsm_light_texel(l, cell.x, cell.y);
    if ((l.flags & 4u) != 0u)
        texel.xyz = cohsm_texel_at(l, vec2(cohsm_clamp_unit(x.x), cohsm_clamp_unit(x.y))).xyz;
    x.x -= l.turn;
    e.coords.xy = vec2(cohsm_clamp_unit(x.x - floor(x.x)), cohsm_clamp_unit(x.y));
    e.range = COHSM_INFINITY;
    e.pdf = texel.w;
    e.direction = w;
    return cohsm_emit(l, texel.xyz, 1.0, e) && e.pdf > 0.0;
}

// Returns cos(pi y / h), near the poles to the last digits too.
float cohsm_row_edge(uint y, uint h)
{
    uint m = min(y, h - y);
    float s = cohsm_sincos(1.57079633 * float(m) / float(h)).x;
    s = 1.0 - 2.0 * s * s;
    return m == y ? s : -s;
}

bool cohsm_environment_draw(const in cohsm_light l, vec2 u, inout cohsm_emission e)
{
    vec2 inside;
    uvec2 cell = cohsm_pick_cell(l, u, inside);
    float x = (float(cell.x) + inside.x) / float(l.width), top = cohsm_row_edge(cell.y, l.height);
    float y = top + (cohsm_row_edge(cell.y + 1u, l.height) - top) * inside.y;
    float r = cohsm_safe_sqrt((1.0 - y) * (1.0 + y));
    vec2 sc = cohsm_sincos(2.0 * COHSM_PI * (x - l.turn - 0.5));
    vec2 coords = vec2(x, cohsm_acos(y) / COHSM_PI);
    return cohsm_environment_found(l, cell, coords, vec3(r * sc.y, y, r * sc.x), e);
}

bool cohsm_environment_hit(const in cohsm_light l, vec3 w, inout cohsm_emission e)
{
    vec2 x = vec2(0.5 + cohsm_atan2(w.z, w.x) / (2.0 * COHSM_PI) + l.turn, cohsm_acos(w.y) / COHSM_PI);
    x.x -= floor(x.x);
    return cohsm_environment_found(l, uvec2(cohsm_index(x.x, l.width), cohsm_index(x.y, l.height)), x, w, e);
}

// ---- what depends on the point alone ----

// Prepares sampling a rectangle by solid angle (Urena, Fajardo and King 2013), unless the angle is small.
void cohsm_rectangle_aim(const in cohsm_light l, inout cohsm_aim a)
{
    vec3 d = l.origin - a.p;
    float x0 = dot(d, l.ex) * l.lx, y0 = dot(d, l.ey) * l.ly, x1 = x0 + l.lx, y1 = y0 + l.ly, z = dot(d, l.n);
    float z2 = z * z, n0 = -y0 / sqrt(z2 + y0 * y0), n1 = x1 / sqrt(z2 + x1 * x1);
    float n2 = y1 / sqrt(z2 + y1 * y1), n3 = -x0 / sqrt(z2 + x0 * x0);
    float k = 2.0 * COHSM_PI - cohsm_acos(-n2 * n3) - cohsm_acos(-n3 * n0);
    a.edges = vec4(x0, x1, y0, y1);
    a.cap = vec4(z, n0, n2, k);
    a.solid = cohsm_acos(-n0 * n1) + cohsm_acos(-n1 * n2) - k;
    if (a.solid > 0.05 && cohsm_finite(a.solid)) a.solid_pdf = 1.0 / a.solid;
}

// Returns about the solid angle of a flat light whose centre lies at d.
float cohsm_flat_solid(vec3 n, vec3 d, float area)
{
    float d2 = dot(d, d), cosine = abs(dot(n, d)) / sqrt(d2 > 0.0 ? d2 : 1.0);
    float near2 = area * (1.0 / (2.0 * COHSM_PI));
    return area * (cosine * d2 + near2) / ((d2 + near2) * (d2 + near2));
}

// Returns the coordinates of a rectangle that u picks by solid angle.
vec2 cohsm_rectangle_pick(const in cohsm_aim a, vec2 u)
{
    float z = a.cap.x, b0 = a.cap.y;
    vec2 sc = cohsm_sincos(u.x * a.solid + a.cap.w);
    float f = (sc.y * b0 - a.cap.z) / sc.x, c = 1.0 / sqrt(f * f + b0 * b0);
    c = clamp(f > 0.0 ? c : -c, -1.0, 1.0);
    float x = clamp(-(c * z) / sqrt(max(1.0 - c * c, 1e-12)), a.edges.x, a.edges.y);
    float d = sqrt(x * x + z * z), h0 = a.edges.z / sqrt(d * d + a.edges.z * a.edges.z);
    float h1 = a.edges.w / sqrt(d * d + a.edges.w * a.edges.w), h = h0 + u.y * (h1 - h0);
    float y = cohsm_if(h * h < 1.0 - 1e-6, h * d / sqrt(1.0 - h * h), a.edges.w);
    return (vec2(x, y) - a.edges.xz) / (a.edges.yw - a.edges.xz);
}

// Prepares samples of a light at a point p, and returns whether the light reaches p.
bool cohsm_aim_at(const in cohsm_light l, vec3 p, out cohsm_aim a)
{
    vec3 d = l.origin - p;
    float r = l.radius;
    a = cohsm_aim(p, vec3(0.0), 0.0, 0.0, 0.0, 0.0, vec4(0.0), vec4(0.0));
    if (COHSM_SHAPE_OF(l) == COHSM_SHAPE_RECTANGLE) {
        if (!(dot(l.n, d) < 0.0)) return false;
        if ((l.flags & 2u) != 0u && !cohsm_light_textured(l)) cohsm_rectangle_aim(l, a);
        if (!(a.solid_pdf > 0.0)) a.solid = cohsm_flat_solid(l.n, d + (l.u + l.v) * 0.5, l.area);
        return true;
    }
    if (COHSM_SHAPE_OF(l) == COHSM_SHAPE_DISC) {
        a.solid = cohsm_flat_solid(l.n, d, l.area);
        return dot(l.n, d) < 0.0;
    }
    if (COHSM_SHAPE_OF(l) == COHSM_SHAPE_SPHERE) {
        a.range = sqrt(dot(d, d));
        if (!(a.range > r)) return false;
        a.axis = d * (1.0 / a.range);
        float s = (r / a.range) * (r / a.range);
        a.spread = s / (1.0 + sqrt(1.0 - s));
        a.solid = 2.0 * COHSM_PI * a.spread;
        if (!cohsm_light_textured(l) && a.spread > 0.0) a.solid_pdf = 1.0 / a.solid;
        return true;
    }
    if (COHSM_SHAPE_OF(l) == COHSM_SHAPE_LINE) {
        float s = dot(d, l.n);
        d = l.n * s - d;
        a.range = sqrt(dot(d, d));
        if (!(a.range > r)) return false;
        a.axis = d * (1.0 / a.range);
        a.spread = cohsm_safe_sqrt(1.0 - (r / a.range) * (r / a.range));
        vec2 ends = vec2(s, s + l.lx);
        ends /= sqrt(a.range * a.range + ends * ends);
        a.solid = 2.0 * r / a.range * (ends.y - ends.x);
    }
    return true;
}

// ---- shapes ----

// Sets a line's emission at x, its normal off the aim's axis by an angle of that sine; returns whether any.
bool cohsm_line_at(const in cohsm_light l, const in cohsm_aim a, float x, float sine, inout cohsm_emission e)
{
    float cosine = cohsm_safe_sqrt(1.0 - sine * sine);
    vec3 n = a.axis * cosine + cross(l.n, a.axis) * sine;
    vec3 q = (l.origin + l.n * (x * l.lx)) + n * l.radius;
    return cohsm_emit_area(l, a, q, n, vec2(x, 0.0), cosine / (2.0 * a.spread * l.radius * l.lx), e);
}

// Sets the emission of a sphere where its normal is n; returns whether the aim's point sees any.
bool cohsm_sphere_at(const in cohsm_light l, const in cohsm_aim a, vec3 n, inout cohsm_emission e)
{
    vec2 x = vec2(cohsm_clamp_unit(0.5 + cohsm_atan2(n.z, n.x) / (2.0 * COHSM_PI)),
                  cohsm_clamp_unit(0.5 * (1.0 - n.y)));
    return cohsm_emit_area(l, a, l.origin + n * l.radius, n, x, 1.0 / l.area, e);
}

bool cohsm_sphere_draw(const in cohsm_light l, const in cohsm_aim a, vec2 u, inout cohsm_emission e)
{
    if (!(a.solid_pdf > 0.0)) {
        vec2 x = cohsm_pick_coords(l, u);
        float y = 1.0 - 2.0 * x.y, ring = cohsm_safe_sqrt(1.0 - y * y);
        vec2 sc = cohsm_sincos(2.0 * COHSM_PI * (x.x - 0.5));
        return cohsm_sphere_at(l, a, cohsm_normalize(vec3(ring * sc.y, y, ring * sc.x) * l.radius), e);
    }
    // The direction is drawn in a cone about the axis; the law of sines gives the normal where the ray meets
    // the sphere.
    float r = l.radius, c = u.x * a.spread, s2 = c * (2.0 - c);
    c = 1.0 - c;
    float reach = cohsm_safe_sqrt(r * r - a.range * a.range * s2), along = a.range * s2 + c * reach;
    float x = cohsm_safe_sqrt(s2) * (a.range * c - reach) / r;
    vec2 sc = cohsm_sincos(2.0 * COHSM_PI * u.y);
    vec3 t, b;
    cohsm_basis(a.axis, t, b);
    return cohsm_sphere_at(l, a, cohsm_normalize(t * (x * sc.y) + b * (x * sc.x) + a.axis * (-along / r)), e);
}

// Sets the emission of a sun, point or spot; returns whether the aim's point sees any.
bool cohsm_delta_draw(const in cohsm_light l, const in cohsm_aim a, inout cohsm_emission e)
{
    float scale = 1.0;
    e.pdf = 1.0;
    e.range = COHSM_INFINITY;
    e.direction = l.n;
    if (COHSM_SHAPE_OF(l) != COHSM_SHAPE_SUN) {
        vec3 d = l.origin - a.p;
        float range = sqrt(dot(d, d));
        if (!(range > 0.0) || !cohsm_finite(range)) return false;
        e.direction = d * (1.0 / range);
        if (COHSM_SHAPE_OF(l) == COHSM_SHAPE_SPOT && -dot(e.direction, l.n) < l.cos_cone) return false;
        scale = 1.0 / (range * range);
        e.range = range;
    }
    return cohsm_emit(l, vec3(scale), 1.0, e);
}

// Returns corner i of a mesh's triangles, or point i of a surface, counted along its rows.
vec3 cohsm_light_corner(const in cohsm_light l, uint i) { return cohsm_floats(l.triangles_at + i).xyz; }

// Draws a point of a mesh. Each triangle has three texels: a corner each and, in w of the first, the share of
// all area up to the end of that triangle. Returns whether the aim's point sees any light of it.
bool cohsm_mesh_draw(const in cohsm_light l, const in cohsm_aim a, vec3 u, inout cohsm_emission e)
{
    uint lo = 0u, hi = l.triangle_count - 1u;
    while (lo < hi) {
        uint middle = (lo + hi) / 2u;
        bool later = cohsm_floats(l.triangles_at + 3u * middle).w <= u.x;
        lo = cohsm_if(later, middle + 1u, lo);
        hi = later ? hi : middle;
    }
    lo *= 3u;
    vec3 v0 = cohsm_light_corner(l, lo), v1 = cohsm_light_corner(l, lo + 1u);
    vec3 v2 = cohsm_light_corner(l, lo + 2u);
    float root = sqrt(u.y), c = root * u.z;
    vec3 q = v0 * (1.0 - root) + v1 * (root * (1.0 - u.z)) + v2 * c;
    e.coords.z = u.z;
    vec3 n = cohsm_normalize(cross(v1 - v0, v2 - v0));
    return cohsm_emit_area(l, a, q, n, u.xy, 1.0 / l.area, e);
}

// Writes what is at coordinates x of a surface, a grid of points between which it is bilinear: the point, a
// normal of any length, d area / dx.
void cohsm_surface_point(const in cohsm_light l, vec2 x, out vec3 q, out vec3 n, out float area)
{
    uint width = l.triangle_count & 0xffffu, rows = (l.triangle_count >> 16) - 1u;
    uint columns = cohsm_if((l.flags & 16u) != 0u, width, width - 1u);
    uint i = cohsm_index(x.x, columns), j = cohsm_index(x.y, rows);
    uint next = cohsm_if(i + 1u < width, i + 1u, 0u), at = j * width;
    vec2 f = vec2(x.x * float(columns) - float(i), x.y * float(rows) - float(j));
    vec3 p0 = cohsm_light_corner(l, at + i), p1 = cohsm_light_corner(l, at + next);
    vec3 p2 = cohsm_light_corner(l, at + width + i), p3 = cohsm_light_corner(l, at + width + next);
    vec3 along = (p1 - p0) * (1.0 - f.y) + (p3 - p2) * f.y;
    vec3 across = (p2 - p0) * (1.0 - f.x) + (p3 - p1) * f.x;
    q = (p0 + (p1 - p0) * f.x) + across * f.y;
    n = cross(along * float(columns), across * float(rows));
    area = sqrt(dot(n, n));
}

// Draws a point of a surface, or of the user's own shape, for which u.z counts; returns whether it is seen.
bool cohsm_shape_draw(const in cohsm_light l, const in cohsm_aim a, vec3 u, inout cohsm_emission e)
{
    vec2 x = cohsm_pick_coords(l, u.xy);
    vec3 q, n;
    float area;
    e.coords.xy = x;
#ifdef COHSM_OWN_LIGHT
    if (COHSM_SHAPE_OF(l) == COHSM_SHAPE_OWN) {
        e.coords.z = u.z;
        glbk_light_point(l.own, e.coords, q, n, area);
    } else cohsm_surface_point(l, x, q, n, area);
#else
    cohsm_surface_point(l, x, q, n, area);
#endif
    if (!cohsm_finite3(q) || !cohsm_finite3(n) || !cohsm_finite(area) || !(area > 0.0)) return false;
    return cohsm_emit_area(l, a, q, cohsm_normalize(n), x, 1.0 / area, e);
}

// Draws a point of the light in proportion to its texture (P_L), and returns whether the aim's point gets any
// light from it. u lies in [0, 1); its z serves meshes.
bool cohsm_light_draw(const in cohsm_light l, const in cohsm_aim a, vec3 u, out cohsm_emission e)
{
    e = cohsm_emission(vec3(0.0), 0.0, vec3(0.0), vec3(0.0), 0.0);
    if (COHSM_SHAPE_OF(l) == COHSM_SHAPE_ENVIRONMENT) return cohsm_environment_draw(l, u.xy, e);
    if (cohsm_light_is_delta(l)) return cohsm_delta_draw(l, a, e);
    if (COHSM_SHAPE_OF(l) == COHSM_SHAPE_SPHERE) return cohsm_sphere_draw(l, a, u.xy, e);
    if (COHSM_SHAPE_OF(l) == COHSM_SHAPE_MESH) return cohsm_mesh_draw(l, a, u, e);
    if (COHSM_SHAPE_OF(l) == COHSM_SHAPE_SURFACE || COHSM_SHAPE_OF(l) == COHSM_SHAPE_OWN)
        return cohsm_shape_draw(l, a, u, e);
    vec2 x = a.solid_pdf > 0.0 ? cohsm_rectangle_pick(a, u.xy) : cohsm_pick_coords(l, u.xy);
    if (COHSM_SHAPE_OF(l) == COHSM_SHAPE_LINE)
        return cohsm_line_at(l, a, x.x, (2.0 * u.y - 1.0) * a.spread, e);
    vec3 q;
    if (COHSM_SHAPE_OF(l) == COHSM_SHAPE_DISC) {
        vec2 p = cohsm_concentric(x);
        q = l.origin + (l.ex * p.x + l.ey * p.y) * l.radius;
    } else
        q = l.origin + (l.u * x.x + l.v * x.y);
    return cohsm_emit_area(l, a, q, l.n, x, 1.0 / l.area, e);
}

// Returns whether a ray sees light of a rectangle or disc, whose emission there is set.
bool cohsm_plane_hit(const in cohsm_light l, const in cohsm_aim a, vec3 w, inout cohsm_emission e)
{
    vec3 d = a.p - l.origin;
    float slope = -dot(l.n, w), height = dot(l.n, d);
    if (!(slope > 1e-7) || !(height > 0.0)) return false;
    d += w * (height / slope);
    vec2 x = vec2(dot(d, l.ex), dot(d, l.ey));
    if (COHSM_SHAPE_OF(l) == COHSM_SHAPE_DISC) {
        x /= l.radius;
        if (!(x.x * x.x + x.y * x.y < 1.0)) return false;
        x = cohsm_disc_square(x);
    } else if (!(x.x >= 0.0 && x.x < 1.0 && x.y >= 0.0 && x.y < 1.0))
        return false;
    return cohsm_emit_area(l, a, l.origin + d, l.n, x, 1.0 / l.area, e);
}

// Returns whether a ray sees light of a sphere or line, at the nearer root, by the foot of the perpendicular.
bool cohsm_round_hit(const in cohsm_light l, const in cohsm_aim a, vec3 w, inout cohsm_emission e)
{
    bool line = COHSM_SHAPE_OF(l) == COHSM_SHAPE_LINE;
    vec3 d = cohsm_if(line, a.axis * -a.range, l.origin - a.p), v = cohsm_if(line, w - l.n * dot(w, l.n), w);
    float square = dot(v, v);
    if (!(square > 1e-14)) return false;
    float along = dot(d, v) / square;
    vec3 n = v * along - d;
    float s = l.radius * l.radius - dot(n, n);
    if (!(along > 0.0) || !(s > 0.0)) return false;
    s = sqrt(s / square);
    n = (n - v * s) * (1.0 / l.radius);
    if (!line) return cohsm_sphere_at(l, a, cohsm_normalize(n), e);
    float x = dot((a.p - l.origin) + w * (along - s), l.n) / l.lx;
    if (!(x >= 0.0 && x < 1.0)) return false;
    return cohsm_line_at(l, a, x, dot(n, cross(l.n, a.axis)), e);
}

// Finds what a ray from the aim's point in direction w sees of the light, as if nothing else were there;
// returns whether it sees any.
bool cohsm_light_hit(const in cohsm_light l, const in cohsm_aim a, vec3 w, out cohsm_emission e)
{
    e = cohsm_emission(vec3(0.0), 0.0, vec3(0.0), vec3(0.0), 0.0);
    if (COHSM_SHAPE_OF(l) == COHSM_SHAPE_ENVIRONMENT) return cohsm_environment_hit(l, w, e);
    if (COHSM_SHAPE_OF(l) == COHSM_SHAPE_RECTANGLE || COHSM_SHAPE_OF(l) == COHSM_SHAPE_DISC)
        return cohsm_plane_hit(l, a, w, e);
    if (COHSM_SHAPE_OF(l) == COHSM_SHAPE_SPHERE || COHSM_SHAPE_OF(l) == COHSM_SHAPE_LINE)
        return cohsm_round_hit(l, a, w, e);
    return false;
}
