// rsm_smooth - has one pass of the a-trous filter: 1 2 1 by 1 2 1, `step` pixels apart, stopped by edges of
// normals and planes. A pixel with few neighbours like it becomes no brighter than its brightest neighbour.
// uses: rsm_screen

// The program has this function, which finds the neighbour `off` steps away from pixel `at`. It returns false
// if nothing is seen there, or if the neighbour is beyond the picture.
bool rsm_neighbour(ivec2 at, ivec2 off, out rsm_receiver s, out vec3 light);

// Returns the filtered light of a pixel. sum is the pixel's light, whose alpha stays.
vec4 rsm_smooth(ivec2 at, rsm_receiver r, vec4 sum)
{
    vec3 light = sum.xyz * 4.0, most = vec3(0.0);
    float total = 4.0;
    for (int j = -1; j <= 1; j++)
        for (int i = -1; i <= 1; i++) {
            rsm_receiver s;
            vec3 other;
            if ((i == 0 && j == 0) || !rsm_neighbour(at, ivec2(i, j), s, other)) continue;
            float weight = rsm_alike(r.position, r.normal, s.position, s.normal);
            weight *= i != 0 && j != 0 ? 1.0 : 2.0;
            light += weight * other;
            total += weight;
            most = max(most, other);
        }
    light /= total;
    if (total < 8.0) light = mix(light, min(light, most), vec3(greaterThan(most, vec3(0.0))));
    return vec4(light, sum.w);
}
