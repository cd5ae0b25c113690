// rsm_grid - interpolates between nodes of a grid that were evaluated (section 4).
// uses: rsm_screen

// The program has this function, which finds the node at a pixel, with its light and alpha. It returns false
// if nothing is seen there.
bool rsm_node(ivec2 at, out rsm_receiver s, out vec4 node);

// Finds the grid lines about a coordinate and its share of the way between them. Lines are multiples of step,
// and the last pixel of the picture.
void rsm_grid_lines(int at, int step, int size, out ivec2 line, out float share)
{
    line = ivec2(at / step * step, min((at / step + 1) * step, size - 1));
    share = line.y > line.x ? float(at - line.x) / float(line.y - line.x) : 0.0;
}

// Returns whether the light of node s may be used at p: whether their normals and planes are alike, and both
// are near each other.
bool rsm_suits(rsm_receiver p, rsm_receiver s, float reach2)
{
    vec3 d = s.position - p.position;
    float len = length(d), plane = max(abs(dot(d, p.normal)), abs(dot(d, s.normal)));
    float most = glbk_rsm_frame.most_distance;
    if (dot(s.normal, p.normal) < glbk_rsm_frame.normal_cosine) return false;
    if (plane > glbk_rsm_frame.plane_slope * len) return false;
    return (!(most > 0.0) || len <= most) && dot(d, d) <= reach2;
}

// Interpolates bilinearly between the nodes of the grid about a pixel. A missing fourth node is completed to
// a plane. Returns false if fewer than three nodes suit, or if they differ too much.
bool rsm_interpolate(ivec2 at, int step, ivec2 size, rsm_receiver p, out vec3 result)
{
    ivec2 lx, ly;
    vec2 f;
    vec3 value[4];
    float low = 3.0e38, high = 0.0, sum = 0.0;
    float reach = glbk_rsm_frame.reach, contrast = glbk_rsm_frame.contrast;
    int good = 0, missing = -1;
    rsm_grid_lines(at.x, step, size.x, lx, f.x);
    rsm_grid_lines(at.y, step, size.y, ly, f.y);
    for (int k = 0; k < 4; k++) {
        bool right = (k & 1) != 0, upper = (k & 2) != 0;
        ivec2 line = ivec2(right ? lx.y : lx.x, upper ? ly.y : ly.x);
        rsm_receiver s;
        vec4 node;
        bool seen = rsm_node(line, s, node);
        value[k] = node.xyz;
        float reach2 = reach > 0.0 ? rsm_node_distance2(node.w) * reach * reach : 3.0e38;
        if (node.w >= 0.0 || !seen || !rsm_suits(p, s, reach2)) {
            missing = k;
            continue;
        }
        float mean = rsm_mean3(node.xyz);
        low = min(low, mean);
        high = max(high, mean);
        sum += mean;
        good++;
    }
    result = vec3(0.0);
    if (good < 3 || (contrast >= 0.0 && high - low > contrast * sum / float(good))) return false;
    if (missing == 0) value[0] = value[1] + value[2] - value[3];
    if (missing == 1) value[1] = value[0] + value[3] - value[2];
    if (missing == 2) value[2] = value[3] + value[0] - value[1];
    if (missing == 3) value[3] = value[2] + value[1] - value[0];
    result = max(mix(mix(value[0], value[1], f.x), mix(value[2], value[3], f.x), f.y), vec3(0.0));
    return true;
}
