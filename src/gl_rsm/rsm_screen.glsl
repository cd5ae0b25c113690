// rsm_screen - reads receivers of the G-buffer, nodes of grids between which light is interpolated, and
// neighbours.
// uses: rsm_access gbuffer
// Alpha of a pixel has one of these numbers.
#define RSM_NONE 0.0            // nothing is seen at the pixel
#define RSM_PENDING 1.0         // the pixel has no light yet
#define RSM_INTERPOLATED 2.0    // the light was interpolated
#define RSM_EVALUATED 3.0       // the light was evaluated
#define RSM_FRESH 4.0           // the light was evaluated in the step before this one

// Nodes of a grid say in alpha how far away their nearest light is: -d^2 2^60 in the step that evaluates
// them, -d^2 / 2^60 afterwards. So both can be told apart and no bit is lost.
#define RSM_NODE_SCALE 1152921504606846976.0

// Returns whether a node was evaluated in this step.
bool rsm_node_fresh(float alpha) { return alpha < -1.0; }

// Returns the squared distance of a node's nearest light.
float rsm_node_distance2(float alpha)
{
    return rsm_node_fresh(alpha) ? -alpha / RSM_NODE_SCALE : -alpha * RSM_NODE_SCALE;
}

// Returns the alpha of a node that is evaluated in this step.
float rsm_node_alpha(float distance2)
{
    return -clamp(distance2, 4.0 / RSM_NODE_SCALE, 0.25 * RSM_NODE_SCALE) * RSM_NODE_SCALE;
}

// Returns the alpha that a node has after this step.
float rsm_node_aged(float alpha)
{
    return rsm_node_fresh(alpha) ? alpha / RSM_NODE_SCALE / RSM_NODE_SCALE : alpha;
}

struct rsm_receiver {
    vec3 position, normal;
    float open;                 // share of bounced light that arrives: 1 = all
};

// Returns width and height of the picture.
ivec2 rsm_picture_side() { return ivec2(glbk_rsm_frame.width, glbk_rsm_frame.height); }

// Reads the receiver of a pixel. Returns false if nothing is seen there.
bool rsm_read(ivec2 at, out rsm_receiver r)
{
    glbk_point p;
    bool seen = glbk_read_point(at, p);
    r.position = p.position;
    r.normal = p.normal;
    r.open = 1.0 - p.occlusion;
    return seen;
}

// Returns the number of the set that a pixel of an interleaved picture takes.
uint rsm_set(ivec2 at)
{
    uint k = glbk_rsm_frame.interleave;
    return uint(at.x) % k + k * (uint(at.y) % k);
}

// Returns the number of a node in a grid. Nodes of coarser grids have a number in finer ones, too.
ivec2 rsm_node_number(ivec2 at, int step) { return (at + step - 1) / step; }

// Returns whether a pixel is a node of the grid, and its number.
bool rsm_is_node(ivec2 at, int step, ivec2 size, out ivec2 number)
{
    number = rsm_node_number(at, step);
    return (at.x % step == 0 || at.x == size.x - 1) && (at.y % step == 0 || at.y == size.y - 1);
}

// Returns the weight of a neighbour, or of history, at q with normal m for p with normal n. The weight is 0
// across edges of normals and off the plane, and falls smoothly to these.
float rsm_alike(vec3 p, vec3 n, vec3 q, vec3 m)
{
    vec3 d = q - p;
    float cosine = glbk_rsm_frame.normal_cosine, slope = glbk_rsm_frame.plane_slope;
    float off = dot(n, d), a = clamp((dot(n, m) - cosine) / (1.0 - cosine), 0.0, 1.0);
    return a * max(1.0 - off * off / (slope * slope * dot(d, d) + 1e-12), 0.0);
}
