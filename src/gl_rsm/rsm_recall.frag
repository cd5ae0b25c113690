// Mixes this frame's light with the light that the last frames had of the same surface; alpha counts the
// frames. Places and normals are kept for the next frame.
// uses: rsm_screen
// with: screen.vert
layout(location = 0) out glbk_color result;
layout(location = 1) out uvec4 rsm_out_place;
layout(location = 2) out uvec4 rsm_out_normal;

// Finds where a surface was in the last frame, in pixels. Returns false if that is not known.
bool rsm_reproject(ivec2 at, vec3 p, vec2 size, out vec2 q)
{
    q = vec2(0.0);
    if (glbk_rsm_frame.motion == 2u) {
        q = texelFetch(glbk_rsm_motion, at, 0).xy;
    } else if (glbk_rsm_frame.motion == 1u) {
        vec4 c = glbk_rsm_drawn.clip * vec4(p, 1.0);
        if (!(c.w > 0.0)) return false;
        q = (vec2(c.x, glbk_rsm_frame.rows_top_first != 0u ? -c.y : c.y) / c.w * 0.5 + 0.5) * size;
    } else {
        return false;
    }
    return all(lessThan(abs(q), vec2(1e6)));        // a place that is no number is not known
}

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy), size = rsm_picture_side();
    float most = glbk_rsm_frame.history;
    vec4 now = glbk_unpack(texelFetch(glbk_rsm_sum, at, 0));
    bool moved = glbk_rsm_frame.motion == 2u;
    vec2 q;
    rsm_receiver r, s;
    bool seen = rsm_read(at, r);
    rsm_out_place = uvec4(floatBitsToUint(r.position), 0u);
    rsm_out_normal = uvec4(floatBitsToUint(r.normal), 0u);
    if (!seen) {
        result = glbk_pack(vec4(0.0));
        return;
    }
    now.w = 1.0;
    if (most > 1.0 && rsm_reproject(at, r.position, vec2(size), q)) {
        // Within four of this frame's pixels the last frame may show this point.
        ivec2 other = ivec2(at.x + 1 < size.x ? at.x + 1 : max(at.x - 1, 0), at.y);
        rsm_read(other, s);
        vec3 d = s.position - r.position;
        float reach = dot(d, d) < 1e18 ? 16.0 * dot(d, d) + 1e-12 : 1e-12, total = 0.0;
        vec2 centre = floor(q),
             place = mix(q - 0.5, centre, lessThan(abs(q - 0.5 - centre), vec2(1.0 / 64.0)));
        vec2 from = floor(place), f = place - from; // a still camera finds one pixel, not four by rounding
        vec4 old = vec4(0.0);
        for (int k = 0; k < 4; k++) {
            ivec2 there = ivec2(from) + ivec2(k & 1, k >> 1);
            float weight = ((k & 1) != 0 ? f.x : 1.0 - f.x) * ((k & 2) != 0 ? f.y : 1.0 - f.y);
            if (any(lessThan(there, ivec2(0))) || any(greaterThanEqual(there, size))) continue;
            vec4 history = glbk_unpack(texelFetch(glbk_rsm_history, there, 0));
            if (!(history.w > 0.0)) continue;
            s.position = uintBitsToFloat(texelFetch(glbk_rsm_before, ivec3(there, 0), 0).xyz);
            s.normal = uintBitsToFloat(texelFetch(glbk_rsm_before, ivec3(there, 1), 0).xyz);
            d = s.position - r.position;
            if (!moved && dot(d, d) > reach) continue;      // moved surfaces are found by motion only
            weight *= moved ? (dot(r.normal, s.normal) > 0.5 ? 1.0 : 0.0)
                            : rsm_alike(r.position, r.normal, s.position, s.normal);
            total += weight;
            old += weight * history;
        }
        if (total > 0.01) {
            old /= total;
            now.w = min(old.w + 1.0, most);
            now.xyz = mix(old.xyz, now.xyz, 1.0 / now.w);
        }
    }
    result = glbk_pack(now);
}
