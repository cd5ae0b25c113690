// Draws of each cluster of successive triangles the sums of their areas and solid angles; their centroid and the
// mean squared distance from it; and the mean of n n^T over their normals: xx, yy, zz, yz, zx, xy.
// uses: ism_corners ism_fold
// with: screen.vert
layout(location = 0) out uvec2 masses;
layout(location = 1) out uvec4 place;
layout(location = 2) out uvec4 squares;
layout(location = 3) out uvec4 mixed;

void main()
{
    uint count = ISM_S.cluster_count, size = ISM_S.cluster_size;
    uint triangles = ISM_S.triangle_count;
    uint c = ism_unfold(count).x, end = min((c + 1u) * size, triangles);
    vec2 sums = vec2(0.0);
    vec3 from = vec3(0.0), at = vec3(0.0), nn = vec3(0.0), other = vec3(0.0);
    float square = 0.0;
    for (uint t = c * size; c < count && t < end; t++) {
        vec2 sizes = ism_folded2(glbk_ism_sizes, t, triangles);
        if (sizes.x > 0.0) {
            ism_corners p = ism_read_corners(t);
            vec3 n = ism_normal2(p) * (0.5 / sizes.x);
            if (!(sums.x > 0.0)) from = p.a;    // so that squares keep their digits far from the origin
            p.a -= from;
            p.b -= from;
            p.c -= from;
            vec3 g = (p.a + p.b + p.c) * (1.0 / 3.0);
            sums += sizes;
            at += sizes.x * g;
            square += sizes.x * (9.0 * dot(g, g) + dot(p.a, p.a) + dot(p.b, p.b) + dot(p.c, p.c)) * (1.0 / 12.0);
            nn += sizes.x * n * n;
            other += sizes.x * n.yzx * n.zxy;
        }
    }
    float one = 0.0;
    if (sums.x > 0.0) one = 1.0 / sums.x;
    at *= one;
    square = max(square * one - dot(at, at), 0.0);
    masses = floatBitsToUint(sums);
    place = floatBitsToUint(vec4(from + at, square));
    squares = floatBitsToUint(vec4(nn * one, 0.0));
    mixed = floatBitsToUint(vec4(other * one, 0.0));
}
