// Writes the cubes of a batch's lists, 2 x 2 texels a pixel: what an occluder hides of each point, or a
// channel of what a light sends there, in the field's space.
// uses: sfield_haar gbuffer
// with: screen.vert
// sets: SFIELD_GLOSS=0 | SFIELD_GLOSS=1
#ifndef SFIELD_GLOSS
#define SFIELD_GLOSS 0
#endif
layout(location = 0) out uvec4 quad;

// Returns the number in the low or in the high half of a word.
vec2 sfield_halves(uint word) { return vec2(float(int(word << 16) >> 16), float(int(word) >> 16)); }

// Returns 2 x 2 texels of a face from its tree of so many levels; a node has `texels` texels.
vec4 sfield_descend(uint root, uint texels, uint channel, uvec2 at, uint levels)
{
    uint node = root;
    uvec4 head = SFIELD_TEXEL(node);
    vec4 values = vec4(0.0);
    for (uint level = levels; level > 0u; level--) {
        uvec2 words = head.xy;
        if (channel > 0u) {
            uvec4 other = SFIELD_TEXEL(node + 1u);
            words = channel == 1u ? other.xy : other.zw;
        }
        values = vec4(sfield_halves(words.x), sfield_halves(words.y)) * uintBitsToFloat(head.w);
        if (level == 1u) break;
        uint x = at.x >> (level - 2u) & 1u, y = at.y >> (level - 2u) & 1u, quarter = x + 2u * y;
        uint below = head.z >> 28 & ((1u << quarter) - 1u);
        if ((head.z >> 28 >> quarter & 1u) == 0u) {
            values = vec4(x == 0u ? (y == 0u ? values.x : values.z) : (y == 0u ? values.y : values.w));
            break;
        }
        node = (head.z & 0xfffffffu) + texels * ((below & 1u) + (below >> 1 & 1u) + (below >> 2));
        head = SFIELD_TEXEL(node);
    }
    return values;
}

// Returns whether the quad at a place of a face, and with turned bodies all that lies next to it, is below
// the horizon of a point, so that T is 0 wherever anything is read here. A direction lies within 3 / side of
// the middle of a quad that it is read from, in s as in t, and past the edges of faces within 5 / side.
bool sfield_below(uint point, uint entity, uint face, uvec2 at)
{
    glbk_point p;
    bool seen = glbk_read_point(sfield_pixel(point), p);
    bool turned = sfield_is_turned(entity);
    float side = float(glbk_haar_batch.side), margin = (turned ? 8.0 : 2.0) / side;
#if SFIELD_GLOSS
    margin += 1.5 / side;           // T is not 0 if any part of a texel is above the horizon
#endif
    vec3 n = p.normal;
    if (turned) n = sfield_turn(entity, n);
    return !seen || dot(normalize(sfield_from_face(face, (4.0 * vec2(at) + 2.0) / side - 1.0)), n) < -margin;
}

void main()
{
    uint half_side = glbk_haar_batch.side / 2u, levels = 0u;
    uvec2 at = uvec2(gl_FragCoord.xy), cell = at / uvec2(6u * half_side, half_side);
    uint cube = cell.y * glbk_haar_batch.columns + cell.x, face = at.x / half_side % 6u;
    uint point = cube / glbk_haar_batch.slots;
    vec4 sum = vec4(0.0);
    quad = uvec4(0u);
    if (point >= glbk_haar_batch.count || cell.x >= glbk_haar_batch.columns) return;
    ivec2 place = ivec2(cube % glbk_haar_batch.slots, point);
    uvec4 what = texelFetch(glbk_haar_what, place, 0), weight = texelFetch(glbk_haar_weight, place, 0);
    vec4 corner = uintBitsToFloat(texelFetch(glbk_haar_corner, place, 0)), shells = uintBitsToFloat(weight);
    if (what.x == SFIELD_EMPTY || sfield_below(point, what.z, face, at % half_side)) return;
    while (1u << levels < glbk_haar_batch.side) levels++;
    at %= half_side;
    if (what.x == SFIELD_OWN) {
        quad = floatBitsToUint(sfield_descend(what.y + face, 1u, 0u, at, levels));
        return;
    }
    uint side = SFIELD_TEXEL(what.w).w, channel = what.x < SFIELD_LIGHT ? 0u : what.x - SFIELD_LIGHT;
    uvec4 parts = SFIELD_TEXEL(what.w + 1u);    // channels, the first root
    for (uint i = 0u; i < (shells.z > 0.0 ? 16u : 8u); i++) {
        float w;
        uint sample_at = sfield_share(what, corner, weight, side, i, w);
        if (w > 0.0)
            sum +=
                w * sfield_descend(parts.y + (6u * sample_at + face) * parts.x, parts.x, channel, at, levels);
    }
    quad = floatBitsToUint(sum);
}
