// Draws least and greatest depth of cells: of 8 x 8 texels of the atlas, or of 2 x 2 cells of the level
// below, which is the texture's base level meanwhile.
// uses: envsh_access
// with: screen.vert
// sets: ENVSH_RGBA=0 | ENVSH_RGBA=1
layout(location = 0) out uvec4 result;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    uint layer = glbk_envsh_object.layer;
    vec2 bounds = vec2(1.0, 0.0);
    if (glbk_envsh_object.level == 0u) {
        int cells = int(glbk_envsh_scene.cells_side), last = int(glbk_envsh_scene.map_side) - 1;
        ivec2 tile = at / cells, from = (at - tile * cells) * 8;
        uint place = uint(tile.x) | (uint(tile.y) << 11) | ((layer / ENVSH_CHANNELS) << 22);
        for (int i = 0; i < 64; i++) {
            ivec2 texel = min(from + ivec2(i & 7, i >> 3), ivec2(last));
            float z = envsh_stored(layer % ENVSH_CHANNELS, place, texel);
            bounds = vec2(min(bounds.x, z), max(bounds.y, z));
        }
    } else {
        for (int i = 0; i < 4; i++) {
            ivec3 below = ivec3(2 * at + ivec2(i & 1, i >> 1), int(layer));
            vec2 b = uintBitsToFloat(texelFetch(glbk_envsh_cells, below, 0).xy);
            bounds = vec2(min(bounds.x, b.x), max(bounds.y, b.y));
        }
    }
    result = uvec4(floatBitsToUint(bounds), 0u, 0u);
}
