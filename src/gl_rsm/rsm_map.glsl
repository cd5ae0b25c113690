// rsm_map - has a light and its map: axes of faces, projection, light through a texel, as in rsm.h.
const int RSM_SUN = 1;              // these are numbers of rsm_light_kind
const int RSM_SPOT = 2;
const int RSM_SQUARE_SPOT = 3;
const int RSM_POINT = 4;
const int RSM_PATCH = 5;
const float RSM_PI = 3.14159265;

struct rsm_light {
    vec3 position;
    vec3 right, up, axis;           // the axes of face 0; light travels along axis
    vec3 value;                     // as in rsm.h's rsm_light
    float extent;                   // half a side of the map (of a sun), or the tangent of half its angle
    float cos_half;                 // cosine of half the cone
    float side;                     // texels a side of a face
    int faces, kind;
};

// Returns v with length 1; of 0 0 0 returns 0 0 0.
vec3 rsm_normalize(vec3 v)
{
    float d = dot(v, v);
    return d > 0.0 ? v / sqrt(d) : vec3(0.0);
}

// Finds right, up and axis of a face.
void rsm_face_axes(rsm_light l, int face, out vec3 r, out vec3 u, out vec3 a)
{
    r = l.right;
    u = l.up;
    a = l.axis;
    if (face == 1) { r = -l.axis; a = l.right; }
    else if (face == 2) { r = l.axis; a = -l.right; }
    else if (face == 3) { u = -l.axis; a = l.up; }
    else if (face == 4) { u = l.axis; a = -l.up; }
    else if (face == 5) { r = -l.right; a = -l.axis; }
}

// Returns a point by the axes of a face: x and y in units of the face's half side, z as depth.
vec3 rsm_to_face(rsm_light l, int face, vec3 p)
{
    vec3 r, u, a, q = p - l.position;
    rsm_face_axes(l, face, r, u, a);
    float z = dot(q, a);
    return vec3(vec2(dot(q, r), dot(q, u)) / (l.kind == RSM_SUN ? l.extent : l.extent * z), z);
}

// Returns the face of a cube that a direction meets, which is given by the light's axes.
int rsm_cube_face(vec3 d)
{
    vec3 a = abs(d);
    if (a.z >= a.x && a.z >= a.y) return d.z >= 0.0 ? 0 : 5;
    if (a.x >= a.y) return d.x >= 0.0 ? 1 : 2;
    return d.y >= 0.0 ? 3 : 4;
}

// Returns the face that a direction in the world meets.
int rsm_face_of_direction(rsm_light l, vec3 d)
{
    return l.faces == 1 ? 0 : rsm_cube_face(vec3(dot(d, l.right), dot(d, l.up), dot(d, l.axis)));
}

// Returns the centre of texel i of a row, -1..1.
float rsm_texel_centre(rsm_light l, int i) { return (float(i) + 0.5) * 2.0 / l.side - 1.0; }

// Returns the unit direction from a point to the light.
vec3 rsm_to_light(rsm_light l, vec3 p) { return l.kind == RSM_SUN ? -l.axis : rsm_normalize(l.position - p); }

// Returns the light of value 1 through the part q +- h of a face, in its plane at distance 1: cos^3,
// integrated by Gauss points.
float rsm_solid_angle(rsm_light l, vec3 r, vec3 u, vec3 a, vec2 q, float h)
{
    float sum = 0.0;
    int n = h < 0.05 ? 2 : 4;
    for (int j = 0; j < n; j++)
        for (int i = 0; i < n; i++) {
            ivec2 k = ivec2(i, j);
            vec2 sign = vec2(greaterThanEqual(k * 2, ivec2(n))) * 2.0 - 1.0;
            bvec2 outer = equal(k % 3, ivec2(0));
            vec2 node = n == 2 ? vec2(0.577350269) : mix(vec2(0.339981044), vec2(0.861136312), vec2(outer));
            vec2 weight = n == 2 ? vec2(0.5) : mix(vec2(0.326072577), vec2(0.173927423), vec2(outer));
            vec2 s = q + h * sign * node;
            float c = 1.0 / (1.0 + dot(s, s)), f = c * sqrt(c);
            if (l.kind == RSM_PATCH) f *= max(dot(l.axis, a + r * s.x + u * s.y) * sqrt(c), 0.0);
            sum += f * weight.x * weight.y;
        }
    return sum * 4.0 * h * h;
}

// Returns whether a place of a face lies in the light's cone.
bool rsm_in_cone(rsm_light l, vec3 r, vec3 u, vec3 a, vec2 q)
{
    vec3 d = a + r * q.x + u * q.y;
    return dot(l.axis, d) >= l.cos_half * length(d);
}

// Returns the light of value 1 through a texel of a face, as far as the texel lies in the cone.
float rsm_incident(rsm_light l, int face, ivec2 t)
{
    float h = l.extent / l.side;
    if (l.kind == RSM_SUN) return 4.0 * h * h;
    vec3 r, u, a;
    rsm_face_axes(l, face, r, u, a);
    vec2 q = vec2(rsm_texel_centre(l, t.x), rsm_texel_centre(l, t.y)) * l.extent;
    float flux = rsm_solid_angle(l, r, u, a, q, h);
    if (l.kind != RSM_SPOT) return flux;
    int corners = 0, covered = 0;
    for (int k = 0; k < 4; k++)
        corners += int(
            rsm_in_cone(l, r, u, a, q + h * vec2((k & 1) != 0 ? 1.0 : -1.0, (k & 2) != 0 ? 1.0 : -1.0)));
    if (corners == 4) return flux;
    if (corners == 0 && !rsm_in_cone(l, r, u, a, q)) return 0.0;
    for (int k = 0; k < 64; k++)
        covered += int(rsm_in_cone(l, r, u, a, q + h * (vec2(float(k & 7), float(k >> 3)) - 3.5) * 0.25));
    return flux * float(covered) * (1.0 / 64.0);
}

// Returns the area of the surface that a texel stands for: the cross section of its beam over the cosine,
// which is bounded for grazing surfaces.
float rsm_area(rsm_light l, int face, vec3 p, vec3 n)
{
    vec3 r, u, a, to = rsm_to_light(l, p);
    rsm_face_axes(l, face, r, u, a);
    float side = 2.0 * l.extent / l.side * (l.kind == RSM_SUN ? 1.0 : dot(p - l.position, a));
    return side * side * (l.kind == RSM_SUN ? 1.0 : abs(dot(a, to))) / max(abs(dot(n, to)), 0.05);
}

// Returns the mean of three channels.
float rsm_mean3(vec3 v) { return (v.x + v.y + v.z) * (1.0 / 3.0); }
