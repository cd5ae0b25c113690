// sfield_haar_turn - wavelets: reads a cube in any direction, between its texels. C twins: shadowfield.h.
// uses: sfield_haar

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

// Returns where the texel of a cube stands that a place past an edge of a face, or on the face, has: that of
// the next face in that direction.
ivec2 sfield_wrap(inout uint face, ivec2 texel)
{
    int side = int(glbk_haar_batch.side);
    vec2 st;
    if (all(greaterThanEqual(texel, ivec2(0))) && all(lessThan(texel, ivec2(side)))) return texel;
    face = sfield_to_face(sfield_from_face(face, sfield_middle(texel)), st);
    return clamp(ivec2((st + 1.0) * (0.5 * float(side))), ivec2(0), ivec2(side - 1));
}

// Returns a texel of a cube, which may lie past the edges of its face. Each program has its own.
float sfield_tap(uint cube, uint face, ivec2 texel);

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

// Returns the direction of a texel's middle.
vec3 sfield_direction(uint face, ivec2 texel)
{
    return normalize(sfield_from_face(face, sfield_middle(texel)));
}
