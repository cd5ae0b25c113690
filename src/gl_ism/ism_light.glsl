// ism_light - sums the light of VPLs, by the maps of glbk_ism_draw. In your own shader, after glbk_ism_bind:
//
//     vec4 e = ism_light(position, normal, geometric, 0u, 1u);
//
// rgb of the result is irradiance, W/m^2; a is the irradiance that the rule near by took off. Two defines
// choose the code: ISM_NEAR is an ism_near (1 patch, 2 sphere, 3 clamp, 4 clamp to the mean, 5 none, 6 or 0
// gather), ISM_PROJECTION the maps' desc.projection.
// uses: ism_access
#ifndef ISM_NEAR
#define ISM_NEAR 6
#elif ISM_NEAR == 0
#undef ISM_NEAR
#define ISM_NEAR 6
#endif
#define ISM_GRAZING 1e-4        // a VPL of a smaller cosine counts as behind the receiver's plane

// Returns the mean of three channels.
float ism_luminance(vec3 f) { return (f.x + f.y + f.z) * (1.0 / 3.0); }

// Returns 1 if VPL v lights point p by its map, 0 if not. Depths are compared on the receiver's tangent
// plane, at the centre of the texel. ng is the surface's own unit normal, bias a share of the distance.
// GLBK_OWN_VISIBLE: a function of the user's says so, of near points that of their VPL.
#ifdef GLBK_OWN_VISIBLE
float glbk_visible(uint vpl, vec3 position, vec3 geometric_normal);
float ism_visible(uint v, ism_vpl l, vec3 p, vec3 ng, float bias) { return glbk_visible(v, p, ng); }
#else
float ism_visible(uint v, ism_vpl l, vec3 p, vec3 ng, float bias)
{
    mat3 basis = l.basis;
    int size = int(ISM_F.tile_side);
    ivec2 tile = ism_tile_at(v), texel;
    vec3 n = ng * basis;
    if (l.sky) {
        vec3 o = (p - ISM_F.sphere.xyz) * basis;
        float r = ISM_F.sphere.w, depth = o.z + r;
        vec2 uv = 0.5 * o.xy / r + 0.5;
        if (!(n.z < -ISM_GRAZING)) return 0.0;
        if (fract(uv) != uv) return 1.0;                // not within 0..1
        texel = min(ivec2(ism_to_tile(l.grid, uv)), size - 1);
        vec2 d = (2.0 * ism_from_tile(l.grid, vec2(texel) + 0.5) - 1.0) * r - o.xy;
        if (abs(n.z) > 0.1) depth -= dot(n.xy, d) / n.z;
        return depth - bias * r <= ISM_FLOATS(glbk_ism_atlas, tile + texel).x ? 1.0 : 0.0;
    }
    vec3 o = (p - l.position) * basis;
    float d = sqrt(dot(o, o));
    vec2 uv;
    if (!(o.z > 0.0) || !(d > 0.0)) return 1.0;
    if (!(dot(n, o) < -ISM_GRAZING * d)) return 0.0;
    if (!ism_map_coordinates(ism_projection_of(l.exponent), l.exponent, o / d, uv)) return 1.0;
    texel = min(ivec2(ism_to_tile(l.grid, uv)), size - 1);
    float t = ISM_FLOATS(glbk_ism_atlas, tile + texel).x;
    if (d * (1.0 - bias) <= t && t >= 2.0 * d) return 1.0;
    float along = dot(n, ism_texel_direction(l.grid, texel));
    along = along != 0.0 ? dot(n, o) / along : d;
    if (along > 0.5 * d && along < 2.0 * d) d = along;
    return d * (1.0 - bias) <= t ? 1.0 : 0.0;
}
#endif

// Returns the share that an edge has in Lambert's sum: angle(a, b) n . (b x a) / |b x a|.
float ism_edge(vec3 n, vec3 a, vec3 b)
{
    vec3 c = cross(b, a);
    float size = sqrt(dot(c, c));
    return size > 0.0 ? cohsm_atan2(size, dot(a, b)) * (dot(n, c) / size) : 0.0;
}

// Returns the form factor of the square d +- x +- y, clipped at the horizon of n. share gets the share of the
// square's area that is left. The square is convex, so the horizon cuts it at most once: the points at which
// the outline goes below and comes back are joined.
float ism_form_factor(vec3 n, vec3 d, vec3 x, vec3 y, out float share)
{
    vec3 leave = d, come = d, area = vec3(0.0);
    float sum = 0.0;
    bool cut = false;
    for (int i = 0; i < 4; i++) {
        vec3 a = d + (i == 0 || i == 3 ? -x : x) + (i < 2 ? -y : y);
        vec3 b = d + (i < 2 ? x : -x) + (i == 0 || i == 3 ? -y : y);
        float ha = dot(n, a), hb = dot(n, b);
        if (!(ha > 0.0) && !(hb > 0.0)) continue;
        if ((ha > 0.0) != (hb > 0.0)) {
            vec3 at = a + (b - a) * (ha / (ha - hb));
            cut = true;
            if (ha > 0.0) b = leave = at;
            else a = come = at;
        }
        sum += ism_edge(n, a, b);
        area += cross(a - d, b - d);
    }
    if (cut) {
        sum += ism_edge(n, leave, come);
        area += cross(leave - d, come - d);
    }
    share = sqrt(dot(area, area)) / (8.0 * sqrt(dot(x, x) * dot(y, y)));
    return sum * 0.159154943;
}

// Returns the kernel of a VPL's square. To receivers that face the square it is no brighter than the point,
// since the backs of bent sheets face it; square gets the kernel without that rule.
float ism_patch_kernel(mat3 basis, float edge, vec3 d, vec3 n, float point, out float square)
{
    float share, form = ism_form_factor(n, d, basis[0] * (0.5 * edge), basis[1] * (0.5 * edge), share);
    float facing = -2.0 * dot(n, basis[2]);
    square = form = form > 0.0 && share > 0.0 ? form * COHSM_PI / (edge * edge * share) : 0.0;
    if (!(facing > 0.0) || !(form > point)) return form;
    return form + min(facing, 1.0) * (point - form);
}

// Returns the kernel of a sphere of the area of a VPL's square, by 16 directions to it.
float ism_sphere_kernel(vec3 d, vec3 normal, vec3 n, float edge)
{
    float r2 = edge * edge * (1.0 / COHSM_PI), d2 = dot(d, d), sum = 0.0;
    float least = d2 > r2 ? sqrt(1.0 - r2 / d2) : -1.0;
    mat3 basis = ism_basis_of(cohsm_normalize(d));
    for (int k = 0; k < 16; k++) {
        float cosine = 1.0 - (1.0 - least) * (float(k) + 0.5) * (1.0 / 16.0);
        float sine = sqrt(1.0 - cosine * cosine);
        vec2 sc = cohsm_sincos(2.39996323 * float(k));
        vec3 w = basis * vec3(sine * sc.y, sine * sc.x, cosine);
        float a = dot(n, w), b = -dot(normal, w);
        if (a > 0.0 && b > 0.0) sum += a * b;
    }
    return sum * (1.0 / 16.0) * 2.0 * (1.0 - least) / r2;
}

// Returns how far near points stand for a VPL at this squared distance: 1 within 0.7 reach, 0 beyond reach.
float ism_nearness(float d2, float reach)
{
    float r2 = reach * reach, h = 2.0 * (r2 - d2);
    return !(h > 0.0) ? 0.0 : h < r2 ? h / r2 : 1.0;
}

// Returns the kernel of a VPL, cos cos / d^2 (of a sky the cosine alone), with its lobe and the rule near by.
// plain gets the kernel without the rule. most is the limit of ISM_NEAR 3.
float ism_kernel(ism_vpl l, vec3 p, vec3 n, float most, out float plain)
{
    if (l.sky) return plain = max(dot(l.position, n) * COHSM_PI, 0.0);
    vec3 d = l.position - p;
    float d2 = dot(d, d), a = dot(n, d), b = -dot(l.normal, d), area = l.edge * l.edge;
    plain = a > 0.0 && b > 0.0 ? a * b / (d2 * d2 + 1e-37) : 0.0;
    if (l.exponent != 1.0) {
        float c = -dot(l.axis, d) / sqrt(d2);
        plain = 0.0;
        if (c > 0.0 && a > 0.0)
            plain = 0.5 * (l.exponent + 1.0) * cohsm_pow(c, l.exponent) * a / (sqrt(d2) * d2);
        area = 0.0;
    }
    if (!(plain > 0.0)) return 0.0;
#if ISM_NEAR == 1
    if (!(area > 0.0 && d2 < 9.0 * area)) return plain;
    float point = plain;
    return ism_patch_kernel(l.basis, l.edge, d, n, point, plain);
#elif ISM_NEAR == 6
    float share = 1.0 - ism_nearness(d2, l.reach), k = plain, point = plain;
    if (!(share > 0.0)) return plain = 0.0;
    if (area > 0.0 && d2 < 9.0 * area) k = ism_patch_kernel(l.basis, l.edge, d, n, point, plain);
    plain *= share;
    return k * share;
#elif ISM_NEAR == 2
    return area > 0.0 && d2 < 16.0 * area ? ism_sphere_kernel(d, l.normal, n, l.edge) : plain;
#elif ISM_NEAR == 3
    return min(plain, most);
#else
    return plain;
#endif
}

// Adds the light of VPL v to sum: irradiance times pi, and in w the light that the rule near by took off.
// most is the limit of one VPL's light, for the rules that clamp.
void ism_add(inout vec4 sum, uint v, ism_vpl l, vec3 p, vec3 n, vec3 ng, float most)
{
    float plain, k = ism_kernel(l, p, n, most, plain), power = ism_luminance(l.flux);
#if ISM_NEAR == 4
    if (k * power > most) k = most / power;
#endif
    if (!(k > 0.0)) return;
    if (glbk_ism_view.no_maps == 0u) k *= ism_visible(v, l, p, ng, glbk_ism_view.bias);
    sum.xyz += k * l.flux;
    if (k > 0.0) sum.w += max(plain - k, 0.0) * power;
}

// Returns the light of a VPL without its map, for the mean that ISM_NEAR 4 clamps to.
float ism_unshadowed(ism_vpl l, vec3 p, vec3 n)
{
    float plain;
    return ism_kernel(l, p, n, 0.0, plain) * ism_luminance(l.flux);
}

// Returns how many VPLs first, first + set_count, ... there are.
uint ism_used(uint first, uint set_count)
{
    uint count = ISM_F.vpl_count;
    return first < count ? (count - first - 1u) / set_count + 1u : 0u;
}

// Returns the irradiance of a sum over VPLs first, first + set_count, ..., times set_count: so the mean over
// all such classes is the sum of all VPLs, however few there are.
vec4 ism_scaled(vec4 sum, uint set_count) { return sum * (float(set_count) / COHSM_PI); }

// ---- near points ----

struct ism_near_point {
    vec3  position, normal, flux;
    float edge;                 // of the square that the point stands for
    float reach;                // distance within which the point takes the VPL's place
    uint  vpl;                  // the VPL whose map says whether the point is seen
};

// Reads near point i from the table.
ism_near_point ism_read_near(uint i)
{
    uint at = ISM_F.first_near_point + 3u * i;
    vec4 a = ISM_TEXEL(at), b = ISM_TEXEL(at + 1u), c = ISM_TEXEL(at + 2u);
    return ism_near_point(a.xyz, b.xyz, c.xyz, a.w, b.w, uint(c.w));
}

// Returns how much a near point lights p, 0..1, by its VPL's map, or, if that hides p and the near point is
// nearer than the VPL, by the map moved to the near point. Receivers behind the VPL are lit. Receivers that
// face the near point are neither asked again nor lit so, since there the backs of bent sheets lie.
float ism_near_visible(ism_near_point q, vec3 p, vec3 n, vec3 ng, float bias)
{
#ifdef GLBK_OWN_VISIBLE
    return glbk_visible(q.vpl, p, ng);
#else
    ism_vpl l = ism_read_vpl(q.vpl);
    vec3 way = l.position - q.position, d = p - q.position, at = p;
    float open = 1.0 - clamp(-2.0 * dot(n, q.normal), 0.0, 1.0), lit = 1.0;
    if (!(dot(l.basis[2], p - l.position) > 0.0)) return open;
    bool movable = open > 0.0 && dot(d, d) < dot(way, way) && dot(l.basis[2], d) > 0.0;
    // This is a loop, since neighbours that differ would wait twice for a question that stood here twice.
    while (!(ism_visible(q.vpl, l, at, ng, bias) > 0.0)) {
        if (!movable) return 0.0;
        movable = false;
        at = p + way;
        lit = open;
    }
    return lit;
#endif
}

// Returns how far a near point stands for VPLs at p, which is 0 if it gives no light there.
float ism_near_weight(const in ism_near_point q, vec3 p, vec3 n)
{
    vec3 d = q.position - p;
    return dot(n, d) > 0.0 && dot(q.normal, d) < 0.0 ? ism_nearness(dot(d, d), q.reach) : 0.0;
}

// Returns the kernel of a near point times how far it stands for VPLs at p. plain gets this product without
// the square's rule.
float ism_near_kernel(ism_near_point q, vec3 p, vec3 n, out float plain)
{
    vec3 d = q.position - p;
    float d2 = dot(d, d), h = ism_near_weight(q, p, n);
    plain = 0.0;
    if (!(h > 0.0)) return 0.0;
    float point = dot(n, d) * -dot(q.normal, d) / (d2 * d2 + 1e-37), k = point;
    plain = point;
    if (d2 < 9.0 * q.edge * q.edge) k = ism_patch_kernel(ism_basis_of(q.normal), q.edge, d, n, point, plain);
    plain *= h;
    return k * h;
}

// Returns whether near point i stands for VPLs at p.
bool ism_near_counts(uint i, vec3 p, vec3 n) { return ism_near_weight(ism_read_near(i), p, n) > 0.0; }

// Returns the first near point, from i on, in a block of 64 whose sphere holds p. Beyond its sphere no point
// of a block reaches.
uint ism_near_block(uint i, uint count, vec3 p)
{
    for (; i < count; i += 64u) {
        vec4 sphere = ISM_TEXEL(ISM_F.first_sphere + i / 64u);
        vec3 d = sphere.xyz - p;
        if (dot(d, d) < sphere.w * sphere.w) break;
    }
    return i;
}

// Returns the light of all near points, also in interleaved pictures: a class alone, scaled up, would make
// white specks where a pixel has few neighbours on its surface to be blurred with. Four are looked for at a
// time, and add their light in a loop of their own: since neighbours wait for each other, the cost of a near
// point is then paid where neighbours have one too, and not wherever one of them has.
vec4 ism_gather(vec3 p, vec3 n, vec3 ng)
{
    uint count = ISM_F.near_point_count, i = ism_near_block(0u, count, p);
    vec4 sum = vec4(0.0);
    while (i < count) {
        uvec4 found = uvec4(0u);
        uint have = 0u;
        while (i < count && have < 4u) {
            if (ism_near_counts(i, p, n)) found[have++] = i;
            i++;
            if ((i & 63u) == 0u) i = ism_near_block(i, count, p);
        }
        for (uint k = 0u; k < have; k++) {
            ism_near_point q = ism_read_near(found[k]);
            float plain, bright = ism_near_kernel(q, p, n, plain);
            if (!(bright > 0.0)) continue;
            float lit = 1.0;
            if (glbk_ism_view.no_maps == 0u) lit = ism_near_visible(q, p, n, ng, glbk_ism_view.bias);
            sum += lit * vec4(bright * q.flux, max(plain - bright, 0.0) * ism_luminance(q.flux));
        }
    }
    return ism_scaled(sum, 1u);
}

// Returns in xyz the irradiance by VPLs first, first + set_count, ... times set_count, in w the irradiance
// that the rule near by took off.
vec4 ism_light(vec3 p, vec3 n, vec3 ng, uint first, uint set_count)
{
    uint count = ISM_F.vpl_count;
    float most = glbk_ism_view.clamp_at;
    vec4 sum = vec4(0.0);
#if ISM_NEAR == 4
    uint used = ism_used(first, set_count);
    float all = 0.0;
    for (uint v = first; v < count; v += set_count) all += ism_unshadowed(ism_read_vpl(v), p, n);
    most *= used > 0u ? all / float(used) : 0.0;
#endif
    for (uint v = first; v < count; v += set_count) ism_add(sum, v, ism_read_vpl(v), p, n, ng, most);
#if ISM_NEAR == 6
    return ism_scaled(sum, set_count) + ism_gather(p, n, ng);
#else
    return ism_scaled(sum, set_count);
#endif
}
