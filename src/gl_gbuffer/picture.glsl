// picture - says where a pixel of a technique's picture lies, whether it is drawn, and how deep
// (glbk_picture).

// Returns the pixel of the picture that this fragment shows.
ivec2 glbk_picture_at() { return ivec2(gl_FragCoord.xy) - ivec2(glbk_shown.left, glbk_shown.bottom); }

// Returns whether glbk_picture_show has to be told what is seen, and where.
bool glbk_picture_asks() { return (glbk_shown.keep_empty | glbk_shown.has_depth) != 0u; }

// Discards the fragment if an empty pixel is to be kept, else sets its depth. seen says whether the G-buffer
// holds anything in this pixel, p where in world space. Call it once.
void glbk_picture_show(bool seen, vec3 p)
{
    if (glbk_shown.keep_empty != 0u && !seen) discard;
    vec4 clip = glbk_shown.to_clip * vec4(p, 1.0);
    float deep = seen && clip.w > 0.0 ? clamp(clip.z / clip.w * 0.5 + 0.5, 0.0, 1.0) : 1.0;
    gl_FragDepth = glbk_shown.has_depth != 0u ? deep : gl_FragCoord.z;
}
