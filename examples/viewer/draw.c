/* draw.c - see viewer.h. The preview, the technique's picture and the panel, by OpenGL through gl_backend.h. */
#include "viewer.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char mesh_vertex[] =
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in vec3 normal;\n"
    "layout(location = 2) in vec3 color;\n"
    "uniform mat4 world_to_clip;\n"
    "uniform mat4 object_to_world;\n"
    "out vec3 seen_normal;\n"
    "out vec3 seen_color;\n"
    "void main()\n"
    "{\n"
    "    seen_normal = mat3(object_to_world) * normal;\n"
    "    seen_color = color;\n"
    "    gl_Position = world_to_clip * (object_to_world * vec4(position, 1.0));\n"
    "}\n";

static const char mesh_fragment[] =
    "in vec3 seen_normal;\n"
    "in vec3 seen_color;\n"
    "layout(location = 0) out vec4 result;\n"
    "void main()\n"
    "{\n"
    "    vec3 n = normalize(gl_FrontFacing ? seen_normal : -seen_normal);\n"
    "    float light = 0.1 + 0.6 * max(dot(n, vec3(0.48, 0.8, 0.36)), 0.0) + 0.15 * max(-n.x, 0.0);\n"
    "    result = vec4(pow(seen_color * light, vec3(1.0 / 2.2)), 1.0);\n"
    "}\n";

/* Rows of the picture come from the top down. */
static const char picture_fragment[] =
    "uniform float scale;\n"
    "layout(location = 0) out vec4 result;\n"
    "float srgb(float x) { return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1.0 / 2.4) - 0.055; }\n"
    "void main()\n"
    "{\n"
    "    ivec2 size = textureSize(glbk_source, 0);\n"
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n"
    "    vec3 c = glbk_unpack(texelFetch(glbk_source, ivec2(at.x, size.y - 1 - at.y), 0)).rgb;\n"
    "    c = clamp(c * scale, 0.0, 1.0);\n"
    "    result = vec4(srgb(c.r), srgb(c.g), srgb(c.b), 1.0);\n"
    "}\n";

static const char panel_fragment[] =
    "uniform sampler2D image;\n"
    "layout(location = 0) out vec4 result;\n"
    "void main()\n"
    "{\n"
    "    ivec2 at = ivec2(gl_FragCoord.xy);\n"
    "    result = texelFetch(image, ivec2(at.x, textureSize(image, 0).y - 1 - at.y), 0);\n"
    "}\n";

typedef struct mesh { uint32_t vertex_array; glbk_buffer vertices; int32_t count; } mesh;

struct vw_draw {
    glbk_context *gl;
    glbk_program  mesh, picture, panel;
    glbk_texture  picture_texture, panel_texture;
    mesh         *meshes;              /* one an object of the scene: colours may differ */
    uint32_t      mesh_count;
    unsigned      loads;               /* the scene that the meshes belong to */
    float        *texels;
};

/* ---- programs ---- */

vw_draw *vw_draw_create(glbk_context *gl, char *error)
{
    const glbk_source sources[3] = { { mesh_vertex, mesh_fragment, NULL, NULL, NULL, NULL, { NULL }, { { 0, 0 } } },
                                     { NULL, picture_fragment, NULL, "base_bindings", NULL, NULL, { NULL },
                                       { { 0, 0 } } },
                                     { NULL, panel_fragment, NULL, NULL, NULL, NULL, { NULL }, { { 0, 0 } } } };
    vw_draw *d = calloc(1, sizeof *d);
    glbk_program *programs[3];
    if (!d) {
        snprintf(error, EX_ERROR_SIZE, "out of memory");
        return NULL;
    }
    d->gl = gl;
    programs[0] = &d->mesh;
    programs[1] = &d->picture;
    programs[2] = &d->panel;
    for (int i = 0; i < 3; i++) {
        glbk_result result = glbk_program_compile(gl, &sources[i], programs[i]);
        if (result != GLBK_OK) {
            snprintf(error, EX_ERROR_SIZE, "%s", glbk_result_text(result));
            vw_draw_free(d);
            return NULL;
        }
    }
    return d;
}

static void free_meshes(vw_draw *d)
{
    for (uint32_t i = 0; i < d->mesh_count; i++) {
        d->gl->gl.DeleteVertexArrays(1, &d->meshes[i].vertex_array);
        glbk_buffer_free(d->gl, &d->meshes[i].vertices);
    }
    free(d->meshes);
    d->meshes = NULL;
    d->mesh_count = 0;
}

void vw_draw_free(vw_draw *d)
{
    if (!d)
        return;
    free_meshes(d);
    glbk_texture_free(d->gl, &d->picture_texture);
    glbk_texture_free(d->gl, &d->panel_texture);
    glbk_program_free(d->gl, &d->mesh);
    glbk_program_free(d->gl, &d->picture);
    glbk_program_free(d->gl, &d->panel);
    free(d->texels);
    free(d);
}

/* ---- the preview ---- */

enum { FLOATS = 9 };       /* position, normal, colour */

static void make_mesh(vw_draw *d, const ex_scene *scene, const ex_object *object, mesh *out)
{
    const glbk_functions *gl = &d->gl->gl;
    const ex_mesh *m = &scene->meshes[object->mesh];
    size_t count = 3 * (size_t)m->triangle_count;
    float *vertices = malloc((count + 1) * FLOATS * sizeof *vertices);
    if (!vertices)
        return;
    for (size_t i = 0; i < count; i++) {
        const ex_material *material = &scene->materials[ex_object_material(scene, object, (uint32_t)(i / 3))];
        float *v = vertices + FLOATS * i;
        memcpy(v, m->positions + 3 * (size_t)m->indices[i], 3 * sizeof *v);
        memcpy(v + 3, m->normals + 3 * (size_t)m->indices[i], 3 * sizeof *v);
        memcpy(v + 6, material->base_color, 3 * sizeof *v);
    }
    if (count && glbk_buffer_create(d->gl, count * FLOATS * sizeof *vertices, vertices, &out->vertices) == GLBK_OK) {
        gl->GenVertexArrays(1, &out->vertex_array);
        gl->BindVertexArray(out->vertex_array);
        gl->BindBuffer(GLBK_GL_ARRAY_BUFFER, out->vertices.name);
        for (uint32_t i = 0; i < 3; i++) {
            gl->EnableVertexAttribArray(i);
            gl->VertexAttribPointer(i, 3, GLBK_GL_FLOAT, 0, FLOATS * sizeof *vertices,
                                    (const void *)(uintptr_t)(3 * i * sizeof *vertices));
        }
        gl->BindVertexArray(0);
        out->count = (int32_t)count;
    }
    free(vertices);
}

static void make_meshes(vw_draw *d, const vw_show *show)
{
    free_meshes(d);
    d->loads = show->loads;
    d->meshes = calloc(show->loaded.object_count + 1u, sizeof *d->meshes);
    if (!d->meshes)
        return;
    d->mesh_count = show->loaded.object_count;
    for (uint32_t i = 0; i < d->mesh_count; i++)
        make_mesh(d, &show->loaded, &show->loaded.objects[i], &d->meshes[i]);
}

static glbk_pass window_pass(vw_draw *d, const vw_show *show)
{
    glbk_pass pass;
    memset(&pass, 0, sizeof pass);
    pass.viewport[2] = (int32_t)show->width;
    pass.viewport[3] = (int32_t)show->height;
    d->gl->gl.BindFramebuffer(GLBK_GL_DRAW_FRAMEBUFFER, 0);
    return pass;
}

void vw_draw_preview(vw_draw *d, const vw_show *show)
{
    static const float background[4] = { 0.13f, 0.14f, 0.16f, 1 };
    const glbk_functions *gl = &d->gl->gl;
    glbk_pass pass = window_pass(d, show);
    float matrix[16];
    if (d->loads != show->loads)
        make_meshes(d, show);
    vw_orbit_matrix(&show->orbit, (float)show->width / (float)show->height, show->job.radius, matrix);
    pass.depth = GLBK_DEPTH_LESS;
    glbk_begin(d->gl, &pass, &d->mesh);
    gl->ClearBufferfv(GLBK_GL_COLOR, 0, background);
    glbk_clear_depth(d->gl, 1);
    gl->UniformMatrix4fv(gl->GetUniformLocation(d->mesh.name, "world_to_clip"), 1, 0, matrix);
    for (uint32_t i = 0; i < d->mesh_count; i++) {
        gl->UniformMatrix4fv(gl->GetUniformLocation(d->mesh.name, "object_to_world"), 1, 0,
                             show->loaded.objects[i].transform);
        gl->BindVertexArray(d->meshes[i].vertex_array);
        if (d->meshes[i].count)
            gl->DrawArrays(GLBK_GL_TRIANGLES, 0, d->meshes[i].count);
    }
}

/* ---- pictures ---- */

/* A texture of that size, made anew where it had another one. 0, or -1. */
static int keep_texture(vw_draw *d, glbk_texture *texture, glbk_format format, uint32_t width, uint32_t height)
{
    glbk_texture_desc desc;
    if (texture->name && texture->width == width && texture->height == height)
        return 0;
    glbk_texture_free(d->gl, texture);
    memset(&desc, 0, sizeof desc);
    desc.format = format;
    desc.width = width;
    desc.height = height;
    return glbk_texture_create(d->gl, &desc, texture) == GLBK_OK ? 0 : -1;
}

/* A row of pixels with four values each, as the texture has them. */
static void put_row(float *to, const float *rgb, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        memcpy(to + 4 * i, rgb + 3 * i, 3 * sizeof *to);
        to[4 * i + 3] = 1;
    }
}

void vw_draw_picture(vw_draw *d, const vw_show *show, float scale, float split)
{
    const ex_image *image = &show->side[VW_TECHNIQUE].picture, *other = &show->side[VW_REFERENCE].picture;
    const int is_split = show->side[VW_REFERENCE].frames && other->width == image->width &&
                         other->height == image->height;
    const size_t width = image->width, pixels = width * image->height;
    const size_t left = is_split ? (size_t)(split * (float)width) : width;
    glbk_pass pass;
    float *grown;
    if (!pixels || keep_texture(d, &d->picture_texture, GLBK_FORMAT_COLOR, image->width, image->height) != 0)
        return;
    grown = realloc(d->texels, 4 * pixels * sizeof *grown);
    if (!grown)
        return;
    d->texels = grown;
    for (size_t y = 0; y < image->height; y++, grown += 4 * width) {
        put_row(grown, image->rgb + 3 * width * y, left);
        if (left < width)
            put_row(grown + 4 * left, other->rgb + 3 * (width * y + left), width - left);
        for (size_t x = left > 0 ? left - 1 : 0; is_split && x <= left && x < width; x++)
            grown[4 * x] = grown[4 * x + 1] = grown[4 * x + 2] = 1 / scale;
    }
    glbk_texture_update(d->gl, &d->picture_texture, &(glbk_box){ 0, 0, 0, 0, image->width, image->height, 1 },
                        d->texels);
    pass = window_pass(d, show);
    glbk_begin(d->gl, &pass, &d->picture);
    d->gl->gl.Uniform1f(d->gl->gl.GetUniformLocation(d->picture.name, "scale"), scale);
    glbk_bind_texture(d->gl, GLBK_SLOT_glbk_source, &d->picture_texture);
    glbk_draw_screen(d->gl);
}

void vw_draw_panel(vw_draw *d, const vw_panel *panel)
{
    glbk_pass pass;
    if (keep_texture(d, &d->panel_texture, GLBK_FORMAT_RGBA8, panel->width, panel->height) != 0)
        return;
    glbk_texture_update(d->gl, &d->panel_texture, &(glbk_box){ 0, 0, 0, 0, panel->width, panel->height, 1 },
                        panel->rgba);
    memset(&pass, 0, sizeof pass);
    pass.viewport[2] = (int32_t)panel->width;
    pass.viewport[3] = (int32_t)panel->height;
    pass.blend = GLBK_BLEND_OVER;
    d->gl->gl.BindFramebuffer(GLBK_GL_DRAW_FRAMEBUFFER, 0);
    glbk_begin(d->gl, &pass, &d->panel);
    glbk_bind_texture(d->gl, 0, &d->panel_texture);
    glbk_draw_screen(d->gl);
}

unsigned char *vw_draw_read(vw_draw *d, uint32_t width, uint32_t height)
{
    size_t row = 3 * (size_t)width;
    unsigned char *rgba = malloc(4 * (size_t)width * height), *rgb = malloc(row * height);
    if (rgba && rgb) {
        d->gl->gl.BindFramebuffer(GLBK_GL_READ_FRAMEBUFFER, 0);
        d->gl->gl.PixelStorei(0x0D05 /* PACK_ALIGNMENT */, 1);
        d->gl->gl.ReadPixels(0, 0, (int32_t)width, (int32_t)height, 0x1908 /* RGBA */, GLBK_GL_UNSIGNED_BYTE,
                             rgba);
        for (size_t y = 0; y < height; y++)
            for (size_t x = 0; x < width; x++)
                memcpy(rgb + row * (height - 1 - y) + 3 * x, rgba + 4 * (y * width + x), 3);
    } else {
        free(rgb);
        rgb = NULL;
    }
    free(rgba);
    return rgb;
}
