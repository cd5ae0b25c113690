// picture - a pixel of a technique's picture: where it lies, whether it is drawn, how deep it is
// (glbk_picture).
ivec2 glbk_picture_at() { return ivec2(gl_FragCoord.xy) - ivec2(glbk_shown.left, glbk_shown.bottom); }

// Is it asked whether something is seen, and where?
bool glbk_picture_asks() { return (glbk_shown.keep_empty | glbk_shown.has_depth) != 0u; }

// Once for each pixel, with what the G-buffer says: whether something is seen at world place p.
void glbk_picture_show(bool seen, vec3 p)
{
    if (glbk_shown.keep_empty != 0u && !seen) discard;
    vec4 clip = glbk_shown.to_clip * vec4(p, 1.0);
    float deep = seen && clip.w > 0.0 ? clamp(clip.z / clip.w * 0.5 + 0.5, 0.0, 1.0) : 1.0;
    gl_FragDepth = glbk_shown.has_depth != 0u ? deep : gl_FragCoord.z;
}
