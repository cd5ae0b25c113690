// Draws two numbers for each texel of a source: its flux times its effect on the picture, blurred over
// neighbours on the same surface (paper 6.5), of which roots of mean squares are taken; and its flux (3.2).
// ism_weight makes an importance of them.
// uses: ism_pvpl
// with: screen.vert
layout(location = 0) out uvec2 result;

float ism_effect_at(ivec2 at) { return ISM_FLOATS(glbk_ism_effects, at).x; }

float ism_blurred(ivec2 at, ism_pvpl q)
{
    int radius = int(ISM_C.blur_radius), height = int(ISM_C.face_height);
    ivec2 lowest = ivec2(0, at.y / height * height);
    ivec2 highest = lowest + ivec2(int(ISM_C.width), height) - 1;
    ivec2 from = max(at - radius, lowest), to = min(at + radius, highest);
    float sum = 0.0, weights = 0.0;
    for (int y = from.y; y <= to.y; y++)
        for (int x = from.x; x <= to.x; x++) {
            ism_pvpl o = ism_read_pvpl(ivec2(x, y));
            vec3 d = o.position - q.position;
            float weight = dot(q.normal, o.normal);
            if (o.luminance > 0.0 && weight > 0.5 && abs(dot(q.normal, d)) <= 0.3 * length(d)) {
                sum += weight * ism_effect_at(ivec2(x, y));
                weights += weight;
            }
        }
    float mean = ism_effect_at(at);
    if (weights > 0.0) mean = sum / weights;
    return mean;
}

void main()
{
    ivec2 at = ISM_HERE;
    ism_pvpl q = ism_read_pvpl(at);
    float effect = 0.0;
    if (ISM_C.by_effect != 0u && q.luminance > 0.0) {
        if (ISM_C.blur_radius == 0u) effect = ism_effect_at(at);
        else effect = ism_blurred(at, q);
        if (ISM_C.by_mean == 0u) effect = sqrt(effect);
    }
    result = floatBitsToUint(vec2(q.luminance * effect, q.luminance));
}
