// cohsm_estimate - draws one sample of a light at a surface, with its weight: the direct-light estimator of
// section 5. It needs what cohsm_brdf.glsl and cohsm_light.glsl need. C twin: lsamp_sample of
// lightsampling.h.
//
// COHSM_PATTERN(j, k) may be defined as point k of pattern j of 256 (lsamp_patterns_build). Without it each
// pixel has a scrambled (0, 2)-sequence, which converges faster over many frames.
// uses: cohsm_random cohsm_brdf cohsm_light

#define COHSM_SAMPLING_BOTH 0   // balance heuristic
#define COHSM_SAMPLING_LIGHT 1
#define COHSM_SAMPLING_BRDF 2
#define COHSM_SAMPLING_PAPER 3

struct cohsm_estimator {        // what all samples of a point share
    uint  samples;              // S
    uint  seed;
    uint  frame;
    cohsm_surface surface;
    cohsm_light light;
    cohsm_aim aim;
    bool  reachable;            // false: no sample has a weight
    bool  split;                // paper, environment: diffuse by the light, specular by the BRDF
    float light_share;          // of the samples, by the density of the light
};

// Returns the random numbers of sample k of a pixel, 0..1.
vec3 cohsm_numbers(const in cohsm_estimator e, uint pixel, uint k)
{
    uint key = cohsm_hash_combine(e.seed, pixel), index = e.frame * e.samples + k;
    vec3 u;
#ifdef COHSM_PATTERN
    u.xy = COHSM_PATTERN((key + e.frame * 159u) & 255u, k);
    if (e.frame > 255u) {
        u.xy += vec2(cohsm_random(key, e.frame >> 8, 0u), cohsm_random(key, e.frame >> 8, 1u));
        u.xy -= floor(u.xy);
        u.xy = vec2(cohsm_clamp_unit(u.x), cohsm_clamp_unit(u.y));
    }
#else
    u.xy = cohsm_sobol2(index, key);
#endif
    u.z = 0.0;
    if (COHSM_SHAPE_OF(e.light) >= COHSM_SHAPE_OWN) u.z = cohsm_random(key, 0x9e3779b9u, index);
    return u;
}

// Returns what all samples of a point share. samples is S, frame that of progressive rendering.
cohsm_estimator cohsm_estimator_at(cohsm_surface surface, const in cohsm_light light, vec3 position,
                                   int sampling, uint samples, uint seed, uint frame)
{
    cohsm_estimator e;
    e.samples = samples;
    e.seed = seed;
    e.frame = frame;
    e.surface = surface;
    e.light = light;
    e.reachable = cohsm_aim_at(light, position, e.aim) && !surface.black;
    bool unseen = cohsm_light_is_delta(light) || COHSM_SHAPE_OF(light) >= COHSM_SHAPE_OWN;
    bool distant = COHSM_SHAPE_OF(light) == COHSM_SHAPE_ENVIRONMENT;
    e.split = distant && sampling == COHSM_SAMPLING_PAPER;
    e.light_share = 1.0;
    if (unseen || sampling == COHSM_SAMPLING_LIGHT || !e.reachable) return e;
    if (sampling == COHSM_SAMPLING_BRDF) e.light_share = 0.0;
    else if (sampling == COHSM_SAMPLING_PAPER) e.light_share = cohsm_if(distant, surface.diffuse_share, 1.0);
    else if (distant) e.light_share = 0.5;
    else {
        float q = e.aim.solid * surface.peak;
        e.light_share = 8.0 / (8.0 + q * q * q);
        e.light_share = floor(e.light_share * float(samples) + 0.5) / float(samples);
    }
    return e;
}

// Returns f L cos / pdf of one sample, and which emission it found; visibility and 1 / S are the caller's. u
// is from cohsm_numbers.
vec3 cohsm_estimate(const in cohsm_estimator e, vec3 u, out cohsm_emission found)
{
    float c = e.light_share;
    bool by_light = u.x < c, hit;
    vec3 wi;
    u.x = cohsm_clamp_unit(cohsm_if(by_light, u.x / c, (u.x - c) / (1.0 - c)));
    if (by_light)
        hit = cohsm_light_draw(e.light, e.aim, u, found);
    else {
        wi = cohsm_brdf_draw(e.surface, cohsm_if(e.split, 0.0, e.surface.diffuse_share), u.xy);
        hit = cohsm_light_hit(e.light, e.aim, cohsm_from_axes(e.surface, wi), found) && wi.z > 0.0;
    }
    if (!hit) {
        found = cohsm_emission(e.surface.n, COHSM_INFINITY, vec3(0.0), vec3(0.0), 0.0);
        return vec3(0.0);
    }
    wi = cohsm_to_axes(e.surface, found.direction);
    cohsm_response r = cohsm_respond(e.surface, wi);
    vec3 f = cohsm_if(e.split, cohsm_if(by_light, r.diffuse, r.specular), r.diffuse + r.specular);
    float split_pdf = cohsm_if(by_light, c * found.pdf, (1.0 - c) * r.specular_pdf);
    float pdf = cohsm_if(e.split, split_pdf, c * found.pdf + (1.0 - c) * cohsm_brdf_pdf(e.surface, r));
    if (!(wi.z > 0.0) || !(pdf > 0.0)) return vec3(0.0);
    f = f * found.radiance * (wi.z / pdf);
    return cohsm_if(cohsm_finite3(f), f, vec3(0.0));
}
