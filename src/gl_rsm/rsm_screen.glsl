// rsm_screen - receivers of the G-buffer, nodes of grids between which light is interpolated, neighbours of filters.
// uses: rsm_access gbuffer
#define RSM_NONE 0.0            // what alpha says of a pixel: nothing seen there
#define RSM_OPEN 1.0
#define RSM_INTERPOLATED 2.0
#define RSM_EVALUATED 3.0       // and in the step before this one:
#define RSM_FRESH 4.0

// Nodes of a grid say in alpha how far away their nearest light is: -d^2 2^60 in the step that evaluates them, -d^2 /
// 2^60 afterwards, so that both can be told apart and no bit is lost.
#define RSM_NODE_SCALE 1152921504606846976.0
bool rsm_node_fresh(float alpha) { return alpha < -1.0; }
float rsm_node_distance2(float alpha)
{
    return rsm_node_fresh(alpha) ? -alpha / RSM_NODE_SCALE : -alpha * RSM_NODE_SCALE;
}
float rsm_node_alpha(float distance2)
{
    return -clamp(distance2, 4.0 / RSM_NODE_SCALE, 0.25 * RSM_NODE_SCALE) * RSM_NODE_SCALE;
}
float rsm_node_aged(float alpha) { return rsm_node_fresh(alpha) ? alpha / RSM_NODE_SCALE / RSM_NODE_SCALE : alpha; }

struct rsm_receiver { vec3 position, normal; float occlusion; };     // the factor: 1 open

bool rsm_read(ivec2 at, out rsm_receiver r)
{
    glbk_point p;
    bool seen = glbk_read_point(at, p);
    r.position = p.position;
    r.normal = p.normal;
    r.occlusion = 1.0 - p.occlusion;
    return seen;
}

// Which set of an interleaved picture a pixel takes.
uint rsm_set(ivec2 at)
{
    uint k = glbk_rsm_frame.counts.y;
    return uint(at.x) % k + k * (uint(at.y) % k);
}

// Is `at` a node of the grid? number: which; those of coarser grids have one in finer ones, too.
ivec2 rsm_node_number(ivec2 at, int step) { return (at + step - 1) / step; }

bool rsm_is_node(ivec2 at, int step, ivec2 size, out ivec2 number)
{
    number = rsm_node_number(at, step);
    return (at.x % step == 0 || at.x == size.x - 1) && (at.y % step == 0 || at.y == size.y - 1);
}

// Weight of a neighbour or of history for p: 0 across edges of normals and off the plane, falling smoothly to them.
float rsm_alike(vec3 p, vec3 n, vec3 q, vec3 m, float cosine, float slope)
{
    vec3 d = q - p;
    float off = dot(n, d), a = clamp((dot(n, m) - cosine) / (1.0 - cosine), 0.0, 1.0);
    return a * max(1.0 - off * off / (slope * slope * dot(d, d) + 1e-12), 0.0);
}
