// rsm_screen - receivers of the G-buffer, interpolation between those that were evaluated (section 4), neighbours of filters.
// uses: rsm_gather
#define RSM_NONE 0.0            // what alpha says of a pixel: nothing seen there
#define RSM_OPEN 1.0
#define RSM_INTERPOLATED 2.0
#define RSM_EVALUATED 3.0       // and in the step before this one:
#define RSM_FRESH 4.0

// Nodes of a grid say in alpha how far away their nearest light is: -d^2 2^60 in the step that evaluates them, -d^2 / 2^60
// afterwards, so that both can be told apart and no bit is lost.
#define RSM_NODE_SCALE 1152921504606846976.0
bool rsm_node_fresh(float alpha) { return alpha < -1.0; }
float rsm_node_distance2(float alpha) { return rsm_node_fresh(alpha) ? -alpha / RSM_NODE_SCALE : -alpha * RSM_NODE_SCALE; }
float rsm_node_alpha(float distance2) { return -clamp(distance2, 4.0 / RSM_NODE_SCALE, 0.25 * RSM_NODE_SCALE) * RSM_NODE_SCALE; }
float rsm_node_aged(float alpha) { return rsm_node_fresh(alpha) ? alpha / RSM_NODE_SCALE / RSM_NODE_SCALE : alpha; }

struct rsm_receiver { vec3 position, normal; float occlusion; };

bool rsm_read(ivec2 at, out rsm_receiver r)
{
    uvec4 place = RSM_SEEN(at, 0);
    r.position = uintBitsToFloat(place.xyz);
    r.occlusion = clamp(uintBitsToFloat(place.w), 0.0, 1.0);
    r.normal = uintBitsToFloat(RSM_SEEN(at, 1).xyz);
    return dot(r.normal, r.normal) > 0.25;
}

// Bounced light of pixel `at` from the bound list, map and pattern.
vec3 rsm_bounce(rsm_receiver r, ivec2 at)
{
    uint k = glbk_rsm_frame.counts.y, set = uint(at.x) % k + k * (uint(at.y) % k), noise = glbk_rsm_frame.counts.w;
    bool glossy = glbk_rsm_frame.pick.w != 0u;
    rsm_lamp l = rsm_bound();
    vec3 sum = vec3(0.0);
    if (glbk_rsm_frame.range.y > glbk_rsm_frame.range.x) {
        uint base = set * glbk_rsm_frame.range.z;
        sum = rsm_gather_list(l, r.position, r.normal, base + glbk_rsm_frame.range.x, base + glbk_rsm_frame.range.y, glossy,
                              glbk_rsm_frame.pattern.y);
    }
    if (glbk_rsm_frame.counts.z > 0u) {
        vec2 turn = vec2(1.0, 0.0);
        if (noise > 0u) {
            float angle = 2.0 * RSM_PI * texelFetch(glbk_rsm_noise, ivec2(uvec2(at) % noise), 0).x;
            turn = vec2(cos(angle), sin(angle));
        }
        sum += rsm_gather_about(l, r.position, r.normal, glbk_rsm_frame.pattern.x, turn, set, k * k, glbk_rsm_frame.counts.z,
                                glbk_rsm_frame.limits, glossy, glbk_rsm_frame.pattern.y, glbk_rsm_frame.pattern.z);
    }
    return sum / RSM_PI;
}

// Grid lines of a coordinate: multiples of step, and the picture's last pixel; their numbers in the grid and the pixels.
void rsm_grid_lines(int at, int step, int size, out ivec2 number, out ivec2 line, out float share)
{
    number = ivec2(at / step, at / step + 1);
    line = ivec2(number.x * step, min(number.y * step, size - 1));
    if (line.y <= line.x) number.y = number.x;
    share = line.y > line.x ? float(at - line.x) / float(line.y - line.x) : 0.0;
}

// Is `at` a node of the grid? number: which.
bool rsm_is_node(ivec2 at, int step, ivec2 size, out ivec2 number)
{
    number = (at + step - 1) / step;
    return (at.x % step == 0 || at.x == size.x - 1) && (at.y % step == 0 || at.y == size.y - 1);
}

bool rsm_suits(rsm_receiver p, rsm_receiver s, vec4 tests, float reach2)
{
    vec3 d = s.position - p.position;
    float len = length(d), plane = max(abs(dot(d, p.normal)), abs(dot(d, s.normal)));
    if (dot(s.normal, p.normal) < tests.x || plane > tests.y * len) return false;
    return (!(tests.z > 0.0) || len <= tests.z) && dot(d, d) <= reach2;
}

// Bilinear between nodes of the grid; false where fewer than three suit or they differ too much. A missing fourth is
// completed to a plane. tests: least cosine, most slope, most distance or 0, contrast or below 0. reach: of a sample, times its
// distance to the nearest light, or below 0.
bool rsm_interpolate(glbk_color_sampler grid, ivec2 at, int step, ivec2 size, rsm_receiver p, vec4 tests, float reach, out vec3 result)
{
    ivec2 nx, ny, lx, ly;
    vec2 f;
    vec3 value[4];
    float low = 3.0e38, high = 0.0, sum = 0.0;
    int good = 0, missing = -1;
    rsm_grid_lines(at.x, step, size.x, nx, lx, f.x);
    rsm_grid_lines(at.y, step, size.y, ny, ly, f.y);
    for (int k = 0; k < 4; k++) {
        bool right = (k & 1) != 0, upper = (k & 2) != 0;
        vec4 node = glbk_unpack(texelFetch(grid, ivec2(right ? nx.y : nx.x, upper ? ny.y : ny.x), 0));
        rsm_receiver s;
        value[k] = node.xyz;
        float reach2 = reach > 0.0 ? rsm_node_distance2(node.w) * reach * reach : 3.0e38;
        if (node.w >= 0.0 || !rsm_read(ivec2(right ? lx.y : lx.x, upper ? ly.y : ly.x), s) || !rsm_suits(p, s, tests, reach2)) {
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
    if (good < 3 || (tests.w >= 0.0 && high - low > tests.w * sum / float(good))) return false;
    if (missing == 0) value[0] = value[1] + value[2] - value[3];
    if (missing == 1) value[1] = value[0] + value[3] - value[2];
    if (missing == 2) value[2] = value[3] + value[0] - value[1];
    if (missing == 3) value[3] = value[2] + value[1] - value[0];
    result = max(mix(mix(value[0], value[1], f.x), mix(value[2], value[3], f.x), f.y), vec3(0.0));
    return true;
}

// Weight of a neighbour or of history for p: 0 across edges of normals and off the plane, falling smoothly to them.
float rsm_alike(vec3 p, vec3 n, vec3 q, vec3 m, float cosine, float slope)
{
    vec3 d = q - p;
    float off = dot(n, d), a = clamp((dot(n, m) - cosine) / (1.0 - cosine), 0.0, 1.0);
    return a * max(1.0 - off * off / (slope * slope * dot(d, d) + 1e-12), 0.0);
}
