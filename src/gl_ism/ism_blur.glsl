// ism_blur - takes the mean of light over a window that holds each class of pixels once, among neighbours on
// the same smooth surface.
// uses: ism_gbuffer

// The program has this function, which finds the receiver at a pixel and its light. It returns false if there
// is no receiver, or if the pixel is beyond the picture.
bool ism_neighbour(ivec2 at, out ism_receiver r, out vec4 light);

// Returns the mean of the light about a pixel, on whose receiver c the weights of its neighbours depend.
vec4 ism_smooth(ivec2 at, ism_receiver c)
{
    int r = int(glbk_ism_view.interleave) / 2;
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

// Returns the final light of a receiver, which is blurred if there is more than one class of pixels.
vec4 ism_finished(ivec2 at, ism_receiver c)
{
    if (glbk_ism_view.interleave > 1u) return ism_smooth(at, c);
    return glbk_unpack(texelFetch(glbk_ism_light, at, 0));
}
