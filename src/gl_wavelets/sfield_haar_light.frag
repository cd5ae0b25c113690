// Multiplies T of a batch's points by what the occluders of their lists leave, near to far, and adds the
// light of the lights between; 4 x 2 texels of a cube a pixel. T begins as cosine x solid angle.
// uses: sfield_haar gbuffer
// with: screen.vert
layout(location = 0) out uvec4 lower;       // T of the lower four texels, then of the upper four
layout(location = 1) out uvec4 upper;
layout(location = 2) out uvec4 light;       // sums over these texels; a: T

// Returns the face of a direction and its place there.
uint sfield_to_face(vec3 d, out vec2 st)
{
    vec3 a = abs(d);
    bool on_x = a.x >= a.y && a.x >= a.z, on_y = !on_x && a.y >= a.z;
    float axis = on_x ? d.x : on_y ? d.y : d.z;
    st = on_x ? vec2(axis > 0.0 ? -d.z : d.z, -d.y) : on_y ? vec2(d.x, axis > 0.0 ? d.z : -d.z)
                                                           : vec2(axis > 0.0 ? d.x : -d.x, -d.y);
    st /= abs(axis);
    return (on_x ? 0u : on_y ? 2u : 4u) + (axis > 0.0 ? 0u : 1u);
}

// Returns one texel of a cube. Past an edge of the face it is that of the next face in that direction.
float sfield_tap(uint cube, uint face, ivec2 texel)
{
    int side = int(glbk_haar_batch.side);
    if (any(lessThan(texel, ivec2(0))) || any(greaterThanEqual(texel, ivec2(side)))) {
        vec2 st;
        face = sfield_to_face(sfield_from_face(face, sfield_middle(texel)), st);
        texel = clamp(ivec2((st + 1.0) * (0.5 * float(side))), ivec2(0), ivec2(side - 1));
    }
    uvec2 half_side = uvec2(side / 2);
    uvec4 quad = texelFetch(glbk_haar_cubes, sfield_square(cube, glbk_haar_batch.columns, face,
                                                             uvec2(texel) / 2u, half_side), 0);
    bool right = (texel.x & 1) != 0, up = (texel.y & 1) != 0;
    return uintBitsToFloat(up ? (right ? quad.w : quad.z) : (right ? quad.y : quad.x));
}

// Returns a cube in a direction, between the four texels round it.
float sfield_between(uint cube, vec3 d)
{
    vec2 st;
    uint face = sfield_to_face(d, st);
    vec2 at = (st + 1.0) * (0.5 * float(glbk_haar_batch.side)) - 0.5, low = floor(at);
    float sum = 0.0;
    for (int k = 0; k < 4; k++) {
        ivec2 step_by = ivec2(k & 1, k >> 1);
        vec2 part = at - low;
        float x = step_by.x == 0 ? 1.0 - part.x : part.x, y = step_by.y == 0 ? 1.0 - part.y : part.y;
        sum += x * y * sfield_tap(cube, face, ivec2(low) + step_by);
    }
    return sum;
}

// Returns x as component k of a vector, whose others are 0, as all are of other k.
vec4 sfield_component(int k, float x)
{
    return mix(vec4(0.0), vec4(x), equal(ivec4(k), ivec4(0, 1, 2, 3)));
}

// Returns where texel i of 8 stands: 0 to 3 the left 2 x 2, then the right.
ivec2 sfield_step(int i) { return ivec2((i & 1) + 2 * (i >> 2), i >> 1 & 1); }

// Returns the direction of a texel's middle.
vec3 sfield_direction(uint face, ivec2 texel)
{
    return normalize(sfield_from_face(face, sfield_middle(texel)));
}

// Returns a texel of the sky: radiance, solid angle.
vec4 sfield_sky(uint face, ivec2 texel)
{
    uint side = glbk_haar_batch.side, at = (face * side + uint(texel.y)) * side + uint(texel.x);
    return uintBitsToFloat(SFIELD_MOVING(glbk_sfield_contents.sky_texel + at));
}

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
    if (point >= glbk_haar_batch.count || cell.x >= 6u * columns) return;
    if (glbk_haar_batch.round == 0u) {
        sfield_begin(point, face, corner, a, b);
    } else {
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
            sums.xyz += (dot(a, p) + dot(b, q)) * tint;
        }
    }
    for (int i = 0; i < 8 && !dark && glbk_haar_batch.last != 0u; i++) {
        float t = dot(sfield_component(i, 1.0), a) + dot(sfield_component(i - 4, 1.0), b);
        sums += vec4(t * sfield_sky(face, corner + sfield_step(i)).xyz, t);
    }
    lower = floatBitsToUint(a);
    upper = floatBitsToUint(b);
    light = floatBitsToUint(sums);
}
