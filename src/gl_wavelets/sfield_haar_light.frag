// Multiplies T of a batch's points by what the occluders of their lists leave, near to far, and adds the
// light of the lights between; 4 x 2 texels of a cube a pixel. T begins as cosine x solid angle. With gloss
// it begins as the solid angle, and light is added times each kernel of the BRDF.
// uses: sfield_haar_turn sfield_haar_gloss gbuffer
// with: screen.vert
// sets: SFIELD_GLOSS=0 | SFIELD_GLOSS=1
layout(location = 0) out uvec4 lower;       // T of the lower four texels, then of the upper four
layout(location = 1) out uvec4 upper;
layout(location = 2) out uvec4 light;       // sums over these texels; a: the open share
#if SFIELD_GLOSS
layout(location = 3) out uvec4 shine;       // sums of gloss
#endif

// Returns one texel of a cube of the list.
float sfield_tap(uint cube, uint face, ivec2 texel)
{
    texel = sfield_wrap(face, texel);
    uvec4 quad = texelFetch(glbk_haar_cubes,
                            sfield_square(cube, glbk_haar_batch.columns, face, uvec2(texel) / 2u,
                                          uvec2(glbk_haar_batch.side / 2u)), 0);
    bool right = (texel.x & 1) != 0, up = (texel.y & 1) != 0;
    return uintBitsToFloat(up ? (right ? quad.w : quad.z) : (right ? quad.y : quad.x));
}

// Returns x as component k of a vector, whose others are 0, as all are of other k.
vec4 sfield_component(int k, float x)
{
    return mix(vec4(0.0), vec4(x), equal(ivec4(k), ivec4(0, 1, 2, 3)));
}

// Returns where texel i of 8 stands: 0 to 3 the left 2 x 2, then the right.
ivec2 sfield_step(int i) { return ivec2((i & 1) + 2 * (i >> 2), i >> 1 & 1); }

// Returns a texel of the sky: radiance, solid angle.
vec4 sfield_sky(uint face, ivec2 texel)
{
    uint side = glbk_haar_batch.side, at = (face * side + uint(texel.y)) * side + uint(texel.x);
    return uintBitsToFloat(SFIELD_MOVING(glbk_sfield_contents.sky_texel + at));
}

#if SFIELD_GLOSS
// The kernels of a pixel's BRDF on 8 texels.
struct sfield_weights { vec4 a[3], b[3]; };

// Finds the kernels, and T of a point that nothing hides.
sfield_look sfield_begin_gloss(uint point, uint face, ivec2 corner, inout vec4 a, inout vec4 b,
                               out sfield_weights w)
{
    glbk_point p;
    sfield_look look;
    for (int k = 0; k < 3; k++) w.a[k] = w.b[k] = vec4(0.0);
    bool seen = glbk_read_point(sfield_pixel(point), p);
    seen = sfield_read_look(p, look) && seen;
    int count = seen ? int(min(glbk_haar_batch.columns + 7u, 8u)) : 0;      // 8, which compilers do not know
    for (int i = 0; i < count; i++) {
        ivec2 texel = corner + sfield_step(i);
        vec3 kernels = sfield_kernels(look, face, texel);
        float t = any(greaterThan(kernels, vec3(0.0))) ? sfield_sky(face, texel).w : 0.0;
        a += sfield_component(i, t);
        b += sfield_component(i - 4, t);
        for (int k = 0; k < 3; k++) {
            w.a[k] += sfield_component(i, kernels[k]);
            w.b[k] += sfield_component(i - 4, kernels[k]);
        }
    }
    return look;
}
#endif

// Writes T of a point that nothing hides.
void sfield_begin(uint point, uint face, ivec2 corner, inout vec4 a, inout vec4 b)
{
    glbk_point p;
    if (!glbk_read_point(sfield_pixel(point), p)) return;
    for (int i = 0; i < 8; i++) {
        ivec2 texel = corner + sfield_step(i);
        float t = max(dot(sfield_direction(face, texel), p.normal), 0.0) * sfield_sky(face, texel).w;
        a += sfield_component(i, t);
        b += sfield_component(i - 4, t);
    }
}

// Writes the texels of a cube of the list, as they lie in the world.
void sfield_read(uint cube, uint entity, uint face, ivec2 corner, out vec4 p, out vec4 q)
{
    bool turned = sfield_is_turned(entity);
    ivec2 at = sfield_square(cube, glbk_haar_batch.columns, face, uvec2(corner) / 2u,
                             uvec2(glbk_haar_batch.side / 2u));
    p = turned ? vec4(0.0) : uintBitsToFloat(texelFetch(glbk_haar_cubes, at, 0));
    q = turned ? vec4(0.0) : uintBitsToFloat(texelFetch(glbk_haar_cubes, at + ivec2(1, 0), 0));
    for (int i = 0; i < 8 && turned; i++) {
        vec3 d = sfield_direction(face, corner + sfield_step(i));
        float x = sfield_between(cube, sfield_turn(entity, d));
        p += sfield_component(i, x);
        q += sfield_component(i - 4, x);
    }
}

void main()
{
    uint side = glbk_haar_batch.side, columns = 2u * glbk_haar_batch.columns;
    uvec2 size = uvec2(side / 4u, side / 2u), here = uvec2(gl_FragCoord.xy), cell = here / size;
    uint face = cell.x % 6u, point = cell.y * columns + cell.x / 6u;
    ivec2 corner = ivec2(here % size * uvec2(4u, 2u));
    vec4 a = vec4(0.0), b = vec4(0.0), sums = vec4(0.0), p, q;      // T, in quads: left, right
    lower = upper = light = uvec4(0u);
#if SFIELD_GLOSS
    shine = uvec4(0u);
#endif
    if (point >= glbk_haar_batch.count || cell.x >= 6u * columns) return;
#if SFIELD_GLOSS
    vec3 glossy = vec3(0.0);
    sfield_weights w;
    sfield_look look = sfield_begin_gloss(point, face, corner, a, b, w);
    if (glbk_haar_batch.round > 0u) {
        glossy = uintBitsToFloat(texelFetch(glbk_haar_shine, ivec2(here), 0).xyz);
#else
    if (glbk_haar_batch.round == 0u) {
        sfield_begin(point, face, corner, a, b);
    } else {
#endif
        a = uintBitsToFloat(texelFetch(glbk_haar_lower, ivec2(here), 0));
        b = uintBitsToFloat(texelFetch(glbk_haar_upper, ivec2(here), 0));
        sums = uintBitsToFloat(texelFetch(glbk_haar_sums, ivec2(here), 0));
    }
    bool dark = a == vec4(0.0) && b == vec4(0.0);
    for (uint slot = 0u; slot < glbk_haar_batch.slots && !dark; slot++) {
        uvec4 what = texelFetch(glbk_haar_what, ivec2(slot, point), 0);
        if (what.x == SFIELD_EMPTY) break;
        sfield_read(point * glbk_haar_batch.slots + slot, what.z, face, corner, p, q);
        if (what.x == SFIELD_OCCLUDER || what.x == SFIELD_OWN) {
            a -= a * p;
            b -= b * q;
        } else {
            bvec3 channel = equal(uvec3(what.x - SFIELD_LIGHT), uvec3(0u, 1u, 2u));
            vec3 tint = uintBitsToFloat(sfield_entity(what.z, 6u).xyz) * vec3(channel);
#if SFIELD_GLOSS
            p *= a;
            q *= b;
            sums.xyz += (dot(p, w.a[0]) + dot(q, w.b[0])) * tint;
            glossy += (dot(p, w.a[1]) + dot(q, w.b[1])) * tint * look.facing;
            glossy += (dot(p, w.a[2]) + dot(q, w.b[2])) * tint;
#else
            sums.xyz += (dot(a, p) + dot(b, q)) * tint;
#endif
        }
    }
    for (int i = 0; i < 8 && !dark && glbk_haar_batch.last != 0u; i++) {
        vec4 left = sfield_component(i, 1.0), right = sfield_component(i - 4, 1.0);
        float t = dot(left, a) + dot(right, b);
        vec3 sky = sfield_sky(face, corner + sfield_step(i)).xyz;
#if SFIELD_GLOSS
        float cosine = max(dot(sfield_direction(face, corner + sfield_step(i)), look.n), 0.0);
        sums += t * vec4((dot(left, w.a[0]) + dot(right, w.b[0])) * sky, cosine);
        glossy += t * (dot(left, w.a[1]) + dot(right, w.b[1])) * sky * look.facing;
        glossy += t * (dot(left, w.a[2]) + dot(right, w.b[2])) * sky;
#else
        sums += vec4(t * sky, t);
#endif
    }
    lower = floatBitsToUint(a);
    upper = floatBitsToUint(b);
    light = floatBitsToUint(sums);
#if SFIELD_GLOSS
    shine = uvec4(floatBitsToUint(glossy), 0u);
#endif
}
