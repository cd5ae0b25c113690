// ism_blur - the mean over a window that holds each class of pixels once, of neighbours on the same smooth
// surface. The program has ism_neighbour: what lies at a pixel, and its light; false: nothing, or beyond the
// picture.
// uses: ism_gbuffer
bool ism_neighbour(ivec2 at, out ism_receiver r, out vec4 light);

vec4 ism_smooth(ivec2 at, ism_receiver c)
{
    int r = int(glbk_ism_view.size.z) / 2;
    vec4 sum = vec4(0.0);
    float weights = 0.0;
    for (int j = -r; j <= r; j++)
        for (int i = -r; i <= r; i++) {
            ism_receiver o;
            vec4 light;
            if (!ism_neighbour(at + ivec2(i, j), o, light)) continue;
            vec3 d = o.p - c.p;
            float facing = max(dot(c.n, o.n), 0.0), off = abs(dot(c.n, d)) + abs(dot(o.n, d));
            float weight = (abs(i) == r ? 0.5 : 1.0) * (abs(j) == r ? 0.5 : 1.0) * facing * facing;
            if (off > 0.0) weight *= max(1.0 - off / sqrt(dot(d, d)), 0.0);
            sum += weight * light;
            weights += weight;
        }
    return weights > 0.0 ? sum / weights : sum;
}

// The light of a receiver as it is read: blurred where there is more than one class of pixels.
vec4 ism_finished(ivec2 at, ism_receiver c)
{
    return glbk_ism_view.size.z > 1u ? ism_smooth(at, c) : glbk_unpack(texelFetch(glbk_ism_light, at, 0));
}
