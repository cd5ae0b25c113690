// probes.glsl - irradiance at a surface from a grid of probes that `bake probes` wrote (docs/probes.md). GLSL 3.30 and ES 3.00.
// probes: an R32F texture without filtering, a row for each probe, "floats" texels wide. grid, origin, step, side: of the
// .json. p: the point, best moved along its normal by a little of a step; n: its unit normal.

float dapple_probe_float(highp sampler2D probes, int probe, int i) { return texelFetch(probes, ivec2(i, probe), 0).r; }

vec3 dapple_probe_harmonic(highp sampler2D probes, int probe, int j)
{
    return vec3(dapple_probe_float(probes, probe, 3 * j), dapple_probe_float(probes, probe, 3 * j + 1),
                dapple_probe_float(probes, probe, 3 * j + 2));
}

// Irradiance that one probe has for a normal; harmonics may ring below 0.
vec3 dapple_probe_shade(highp sampler2D probes, int probe, vec3 n)
{
    vec3 sum = 0.28209479 * dapple_probe_harmonic(probes, probe, 0);
    sum += 0.48860251 * (n.y * dapple_probe_harmonic(probes, probe, 1) + n.z * dapple_probe_harmonic(probes, probe, 2) +
                         n.x * dapple_probe_harmonic(probes, probe, 3));
    sum += 1.09254843 * (n.x * n.y * dapple_probe_harmonic(probes, probe, 4) +
                         n.y * n.z * dapple_probe_harmonic(probes, probe, 5) +
                         n.x * n.z * dapple_probe_harmonic(probes, probe, 7));
    sum += 0.31539157 * (3.0 * n.z * n.z - 1.0) * dapple_probe_harmonic(probes, probe, 6);
    sum += 0.54627422 * (n.x * n.x - n.y * n.y) * dapple_probe_harmonic(probes, probe, 8);
    return max(sum, vec3(0.0));
}

// Mean distance and mean square distance that a probe sees along a direction: of the four nearest texels.
vec2 dapple_probe_distance(highp sampler2D probes, int probe, int side, vec3 d)
{
    d /= abs(d.x) + abs(d.y) + abs(d.z);
    vec2 sign_of = vec2(d.x >= 0.0 ? 1.0 : -1.0, d.y >= 0.0 ? 1.0 : -1.0);
    vec2 at = d.z >= 0.0 ? d.xy : (1.0 - abs(d.yx)) * sign_of;
    at = clamp((0.5 * at + 0.5) * float(side) - 0.5, vec2(0.0), vec2(float(side - 1)));
    ivec2 low = min(ivec2(at), ivec2(side - 1)), high = min(low + 1, ivec2(side - 1));
    vec2 part = at - vec2(low), sum = vec2(0.0);
    for (int i = 0; i < 4; i++) {
        ivec2 t = ivec2((i & 1) == 0 ? low.x : high.x, i < 2 ? low.y : high.y);
        float weight = ((i & 1) == 0 ? 1.0 - part.x : part.x) * (i < 2 ? 1.0 - part.y : part.y);
        int first = 27 + 2 * (t.y * side + t.x);
        sum += weight * vec2(dapple_probe_float(probes, probe, first), dapple_probe_float(probes, probe, first + 1));
    }
    return sum;
}

// Of the eight probes about the point, each counts by its nearness, by whether it lies in front of the surface, and by
// Chebyshev's bound on the chance that nothing lies between.
vec3 dapple_probe_irradiance(highp sampler2D probes, ivec3 grid, vec3 origin, vec3 step_size, int side, vec3 p, vec3 n)
{
    vec3 at = clamp((p - origin) / step_size, vec3(0.0), vec3(grid - 1));
    ivec3 low = min(ivec3(at), max(grid - 2, ivec3(0)));
    vec3 part = at - vec3(low), sum = vec3(0.0);
    float weights = 0.0;
    for (int i = 0; i < 8; i++) {
        ivec3 corner = ivec3(i & 1, (i >> 1) & 1, i >> 2), cell = min(low + corner, grid - 1);
        int probe = (cell.z * grid.y + cell.y) * grid.x + cell.x;
        vec3 near = mix(1.0 - part, part, vec3(corner)), to = p - (origin + vec3(cell) * step_size);
        float away = length(to), facing = 0.5 * dot(n, -to) / max(away, 1e-6) + 0.5;
        float weight = max(near.x * near.y * near.z, 1e-4) * (facing * facing + 0.1);
        if (away > 1e-4) {
            vec2 seen = dapple_probe_distance(probes, probe, side, to);
            float variance = max(seen.y - seen.x * seen.x, 1e-6 + 1e-3 * seen.x * seen.x), over = max(away - seen.x, 0.0);
            float chance = variance / (variance + over * over);
            weight *= max(chance * chance * chance, 0.01);
        }
        sum += weight * dapple_probe_shade(probes, probe, n);
        weights += weight;
    }
    return sum / weights;
}
