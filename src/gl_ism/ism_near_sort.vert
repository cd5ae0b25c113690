// Places each near point among 1024 of them in their order along Morton's curve, so that those of a block of 64
// lie together.
// uses: ism_choice
flat out uint ism_from;

void main()
{
    uint i = uint(gl_VertexID), count = ISM_C.near_point_count, first = i & ~1023u, rank = first;
    uint own = texelFetch(glbk_ism_near_facts, ism_cell_of(i), 0).w;
    for (uint k = first; k < min(first + 1024u, count); k++) {
        uint key = texelFetch(glbk_ism_near_facts, ism_cell_of(k), 0).w;
        if (key < own || (key == own && k < i)) rank++;
    }
    ism_from = i;
    vec2 size = vec2(256u, (count + 255u) >> 8);
    gl_Position = vec4((vec2(ism_cell_of(rank)) + 0.5) / size * 2.0 - 1.0, 0.0, 1.0);
    gl_PointSize = 1.0;
}
