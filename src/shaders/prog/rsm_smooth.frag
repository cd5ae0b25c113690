// One pass of the a-trous filter: 1 2 1 by 1 2 1, `step` pixels apart, stopped by edges of normals and planes. A pixel with
// few neighbours like it is no brighter than its brightest neighbour.
// uses: rsm_screen
// with: screen.vert
layout(location = 0) out glbk_color result;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy), size = ivec2(glbk_rsm_frame.grid.zw);
    int step = int(glbk_rsm_frame.grid.x);
    vec4 sum = glbk_unpack(texelFetch(glbk_rsm_sum, at, 0));
    float total = 4.0;
    rsm_receiver r, s;
    if (!rsm_read(at, r)) {
        result = glbk_pack(vec4(0.0));
        return;
    }
    vec3 light = sum.xyz * 4.0, most = vec3(0.0);
    for (int j = -1; j <= 1; j++)
        for (int i = -1; i <= 1; i++) {
            ivec2 there = at + ivec2(i, j) * step;
            if ((i == 0 && j == 0) || any(lessThan(there, ivec2(0))) || any(greaterThanEqual(there, size))) continue;
            if (!rsm_read(there, s)) continue;
            float weight = rsm_alike(r.position, r.normal, s.position, s.normal, glbk_rsm_frame.tests.x, glbk_rsm_frame.tests.y) *
                           (i != 0 && j != 0 ? 1.0 : 2.0);
            vec3 other = glbk_unpack(texelFetch(glbk_rsm_sum, there, 0)).xyz;
            light += weight * other;
            total += weight;
            most = max(most, other);
        }
    light /= total;
    if (total < 8.0) light = mix(light, min(light, most), vec3(greaterThan(most, vec3(0.0))));
    result = glbk_pack(vec4(light, sum.w));
}
