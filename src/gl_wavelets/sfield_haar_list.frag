// Lists what a point meets from near to far: a column of the target is a place of the list, a row a point.
// The places of later rounds go on after the last place of the round before.
// uses: sfield_haar_list gbuffer
// with: screen.vert
// sets: SFIELD_BANDS=1
layout(location = 0) out uvec4 what;        // kind, first sample, entity, field
layout(location = 1) out uvec4 corner;      // weights of four samples on a shell
layout(location = 2) out uvec4 weight;      // of both shells; how far it is to the next frame, its samples
layout(location = 3) out uvec4 met;         // squared distance, id; the list goes on after the last place

void main()
{
    uint rest = uint(gl_FragCoord.x), point = uint(gl_FragCoord.y), id = 0u, root = 0u;
    ivec2 at = sfield_pixel(point);
    float d2 = -1.0;
    glbk_point p;
    bool seen = glbk_read_point(at, p), first = glbk_haar_batch.round == 0u;
    what = corner = weight = uvec4(0u);
    met = uvec4(0u, SFIELD_NONE, 0u, 0u);
    if (!first) {
        uvec4 last = texelFetch(glbk_haar_met, ivec2(glbk_haar_batch.slots - 1u, point), 0);
        d2 = uintBitsToFloat(last.x);
        id = last.y;
    }
    if (first && glbk_haar_batch.own != 0u) root = texelFetch(glbk_sfield_self, ivec3(at, 0), 0).x;
    if (!seen || id == SFIELD_NONE) return;
    if (root != 0u && rest == 0u) {
        bool turns = p.entity - 1u < glbk_sfield_contents.entity_count;
        what = uvec4(SFIELD_OWN, root, turns ? p.entity - 1u : SFIELD_NOBODY, 0u);
        met = uvec4(floatBitsToUint(d2), id, 0u, 0u);
        return;
    }
    if (root != 0u) rest--;
    for (uint more = rest + 1u; more > 0u && id != SFIELD_NONE;) {
        sfield_find(p.position, p.normal, p.entity, 0u, 1u, d2, id);
        bool hides = (id & 3u) == 3u && id != SFIELD_NONE;
        if (!hides || !sfield_hidden(p.position, p.normal, p.entity, 0u, 1u, d2, id)) more--;
    }
    if (id == SFIELD_NONE) return;
    met = uvec4(floatBitsToUint(d2), id, 0u, 0u);
    sfield_surround(p.position, d2, id, what, corner, weight);
}
