// ism_inter_texel - moves a VPL between the texels of its source (paper 6.5).
// uses: ism_pvpl

// Moves place and normal of the VPL at (texel + fraction) to a mixture of the four texels about it, those
// that lie on one surface. If the surface is curved, their chord may run behind it, and a VPL there would
// light a sheet's back: the VPL lies on the chord or on the mean of the four tangent planes, whichever is
// farther out. Returns the distance to the farthest of the texels.
float ism_inter_texel(ivec2 texel, vec2 fraction, inout vec3 position, inout vec3 normal)
{
    vec2 s = fraction - 0.5, from, to;
    vec3 p0 = position, n0 = normal, sum = vec3(0.0), mixed = vec3(0.0), offsets[4], normals[4];
    float weights = 0.0, shares[4], behind = 0.0, spacing = 0.0;
    int height = int(ISM_C.face_height), face = texel.y / height;
    ivec2 lowest = ivec2(0, face * height);
    ivec2 highest = lowest + ivec2(int(ISM_C.width), height) - 1;
    ivec2 beside = 1 - 2 * ivec2(lessThan(s, vec2(0.0)));
    bool known = ism_to_clip(p0, from);
    for (int k = 0; k < 4; k++) {
        ivec2 pick = ivec2(k & 1, k >> 1), at = texel + pick * beside, kept = clamp(at, lowest, highest);
        vec2 share = mix(1.0 - abs(s), abs(s), vec2(pick));
        float w = share.x * share.y;
        ism_pvpl q = ism_read_pvpl(kept);
        vec3 d = q.position - p0;
        bool used = at == kept && q.luminance > 0.0;
        if (k > 0) used = used && dot(n0, q.normal) > 0.9 && abs(dot(n0, d)) <= 0.1 * length(d);
        if (k > 0 && known && ism_to_clip(q.position, to)) w *= cohsm_exp(-50.0 * dot(to - from, to - from));
        if (!used) {
            w = 0.0;
            d = vec3(0.0);
            q.normal = vec3(0.0);
        }
        spacing = max(spacing, length(d));
        sum += w * d;
        mixed += w * q.normal;
        weights += w;
        offsets[k] = d;
        normals[k] = q.normal;
        shares[k] = w;
    }
    if (weights > 0.0) {
        normal = normalize(mixed);
        sum /= weights;
        for (int k = 0; k < 4; k++)
            behind += shares[k] / weights * dot(normals[k], offsets[k] - sum) * dot(normals[k], normal);
        position = p0 + sum + max(behind, 0.0) * normal;
    }
    return spacing;
}
