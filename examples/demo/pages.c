/* pages.c - index.html: pictures, differences and figures, scene by scene; which.html and which-one.md: the same
   figures technique by technique, with what each is good for. */
#include "gallery.h"

#include <stdarg.h>
#include <string.h>

/* ---- one writer for HTML and Markdown ---- */

typedef struct page { FILE *file; int is_markdown; } page;

static const char html_head[] =
    "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
    "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"><title>Dapple</title>\n<style>\n"
    "body { font-family: sans-serif; max-width: 70em; margin: 0 auto; padding: 1em; color: #222; }\n"
    "p { max-width: 50em; line-height: 1.4; } h2 { margin-top: 2em; border-top: 1px solid #ccc; padding-top: 1em; }\n"
    "table { border-collapse: collapse; } th, td { padding: 0.2em 0.8em; text-align: left; vertical-align: top; }\n"
    "tr { border-bottom: 1px solid #ddd; } details { overflow-x: auto; } img { display: block; }\n"
    ".best img { width: 100%; } nav { display: flex; flex-wrap: wrap; gap: 0.8em; }\n"
    "nav a { width: 320px; max-width: 100%; color: inherit; } nav img { width: 100%; }\n"
    ".pair { position: relative; max-width: 60em; --at: 50%; } .pair img { width: 100%; }\n"
    ".pair .over { position: absolute; top: 0; left: 0; clip-path: inset(0 calc(100% - var(--at)) 0 0); }\n"
    ".pair .line { position: absolute; top: 0; bottom: 0; left: var(--at); width: 2px; margin-left: -1px; }\n"
    ".pair .line { background: #fff; }\n"
    ".pair input { position: absolute; inset: 0; width: 100%; height: 100%; margin: 0; opacity: 0; cursor: ew-resize; }\n"
    ".pair span { position: absolute; bottom: 0.5em; padding: 0.1em 0.5em; background: #000a; color: #fff; }\n"
    ".pair .left { left: 0.5em; } .pair .right { right: 0.5em; }\n"
    "button { font: inherit; padding: 0.4em 0.8em; margin: 0 0.3em 0.3em 0; }\n"
    "button.chosen { background: #222; color: #fff; }\n"
    "</style></head><body>\n";

/* The slider moves the line; a button puts its technique on the line's left, the box the difference in its place. */
static const char html_script[] =
    "<script>\n"
    "for (const section of document.querySelectorAll('section')) {\n"
    "    const pair = section.querySelector('.pair'), over = section.querySelector('.over');\n"
    "    const slider = section.querySelector('input[type=range]'), box = section.querySelector('input[type=checkbox]');\n"
    "    const buttons = section.querySelectorAll('button'), name = section.querySelector('.left');\n"
    "    let chosen = buttons[0];\n"
    "    const show = () => {\n"
    "        const difference = box && box.checked;\n"
    "        over.src = chosen.dataset.stem + (difference ? '-diff.png' : '.png');\n"
    "        name.textContent = chosen.textContent + (difference ? ': difference' : '');\n"
    "        section.querySelector('.figures').textContent = chosen.dataset.figures;\n"
    "        for (const button of buttons) button.classList.toggle('chosen', button === chosen);\n"
    "    };\n"
    "    for (const button of buttons) button.onclick = () => { chosen = button; show(); };\n"
    "    if (slider) slider.oninput = () => pair.style.setProperty('--at', slider.value + '%');\n"
    "    if (box) box.onchange = show;\n"
    "    show();\n"
    "}\n"
    "</script>\n";

static int open_page(page *p, const gallery *g, const char *name, char *error)
{
    char path[400];
    snprintf(path, sizeof path, "%s/%s", g->folder, name);
    p->file = fopen(path, "w");
    p->is_markdown = strstr(name, ".md") != NULL;
    if (!p->file) return ex_fail(error, "%s: cannot write", path);
    if (!p->is_markdown) fputs(html_head, p->file);
    return 0;
}

static int close_page(page *p, const char *name, char *error)
{
    int ok;
    if (!p->is_markdown) fputs("</body></html>\n", p->file);
    ok = !ferror(p->file);
    if (fclose(p->file) != 0 || !ok) return ex_fail(error, "%s: write failed", name);
    return 0;
}

/* Text of ours and of file names: < > & are all that HTML minds. */
static void put(page *p, const char *text)
{
    for (; *text; text++)
        if (!p->is_markdown && *text == '<') fputs("&lt;", p->file);
        else if (!p->is_markdown && *text == '>') fputs("&gt;", p->file);
        else if (!p->is_markdown && *text == '&') fputs("&amp;", p->file);
        else fputc(*text, p->file);
}

static void heading(page *p, int level, const char *text)
{
    if (p->is_markdown) fprintf(p->file, "%.*s ", level, "####");
    else fprintf(p->file, "<h%d>", level);
    put(p, text);
    if (p->is_markdown) fputs("\n\n", p->file);
    else fprintf(p->file, "</h%d>\n", level);
}

static void paragraph(page *p, const char *format, ...)
{
    char text[1600];
    size_t start = 0, space = 0;
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    for (size_t i = 0; text[i]; i++) {          /* lines of 119 characters at most */
        if (text[i] == ' ') space = i;
        if (i - start < 119 || space <= start) continue;
        text[space] = '\n';
        start = space + 1;
    }
    if (!p->is_markdown) fputs("<p>", p->file);
    put(p, text);
    fputs(p->is_markdown ? "\n\n" : "</p>\n", p->file);
}

/* Cells of one line are separated by |. A table ends with an empty line. */
static void table_line(page *p, const char *cells, int is_head)
{
    const char *tag = is_head ? "th" : "td";
    if (p->is_markdown) {
        fprintf(p->file, "| %s |\n", cells);
        if (is_head) {
            fputs("|---|", p->file);
            for (; *cells; cells++)
                if (*cells == '|') fputs("---|", p->file);
            fputc('\n', p->file);
        }
        return;
    }
    if (is_head) fputs("<table>\n", p->file);
    fprintf(p->file, "<tr><%s>", tag);
    for (; *cells; cells++)
        if (*cells == '|') {
            fprintf(p->file, "</%s><%s>", tag, tag);
        } else {
            const char one[2] = { *cells, 0 };
            put(p, one);
        }
    fprintf(p->file, "</%s></tr>\n", tag);
}

static void table_end(page *p)
{
    fputs(p->is_markdown ? "\n" : "</table>\n", p->file);
}

/* ---- numbers ---- */

typedef struct text20 { char text[20]; } text20;

static text20 number(const char *format, double value)
{
    text20 out = { "-" };
    if (isfinite(value)) snprintf(out.text, sizeof out.text, format, value);
    return out;
}

static text20 milliseconds(double ms)
{
    return ms < 10 ? number("%.1f ms", ms) : ms < 10000 ? number("%.0f ms", ms) : number("%.1f s", ms / 1000);
}

#define FIGURES "relative RMSE (reference's noise) | SSIM | mean ratio | precomputed | a frame | kept"

static void figures(char *out, size_t size, const gal_group *group, const gal_row *r)
{
    snprintf(out, size, "%s (%s) | %s | %s | %s | %s | %s", number("%.3f", r->error).text,
             number("%.3f", group->noise).text, number("%.3f", r->ssim).text, number("%.3f", r->mean_ratio).text,
             milliseconds(r->precompute_ms).text, milliseconds(r->frame_ms).text,
             number("%.2f MB", r->memory_bytes / 1e6).text);
}

static void say_what_figures_mean(page *p, const gallery *g)
{
    paragraph(p, "Relative RMSE and mean ratio are of linear radiance against a path-traced reference, over the pixels "
                 "that are not black in both; SSIM is of the pictures as shown. The error contains the noise of both: "
                 "the reference's own stands beside it. Precomputed: once, and kept; a frame: everything that moving "
                 "things need anew, primary visibility not counted. On OpenGL it is the second one: what a driver "
                 "compiles at its first use does not count.");
    paragraph(p, "Scenes are shown by the techniques that they were made for, not by all that treat them. Left out: "
                 "rsm and ism on open scenes under a sky, where little bounces; rsm where many small lamps shine, "
                 "which it takes as a few points; csm where all light bounces; shadowfield on what deforms.");
    paragraph(p, "Run: %s. Machine: %s.", g->run, g->machine);
    if (*g->left_out) paragraph(p, "Left out: %s.", g->left_out);
}

/* ---- index.html ---- */

/* Where its picture leads to. */
static void put_anchor(page *p, const gal_group *group)
{
    fprintf(p->file, "%s-%s", group->scene, group->kind);
}

static void show_best(page *p, const gallery *g)
{
    const gal_group *best = NULL;
    const gal_row *picture = NULL;
    for (uint32_t i = 0; i < g->group_count; i++)
        for (uint32_t k = 0; k < g->groups[i].row_count; k++)
            if (!picture || strcmp(g->groups[i].rows[k].stem, g->best) == 0) {
                best = &g->groups[i];
                picture = &best->rows[k];
            }
    if (!picture) return;
    fprintf(p->file, "<div class=\"best\"><img src=\"%s.png\" alt=\"\"></div>\n", picture->stem);
    paragraph(p, "%s, by %s: no ray was traced for a shadow.", best->title, picture->technique);
}

static void show_overview(page *p, const gallery *g)
{
    fputs("<nav>\n", p->file);
    for (uint32_t i = 0; i < g->group_count; i++) {
        const gal_group *group = &g->groups[i];
        if (!group->row_count) continue;
        fputs("<a href=\"#", p->file);
        put_anchor(p, group);
        fprintf(p->file, "\"><img src=\"%s.png\" alt=\"\" loading=\"lazy\">", group->rows[group->row_count - 1].stem);
        put(p, group->title);
        fputs("</a>\n", p->file);
    }
    fputs("</nav>\n", p->file);
}

/* The first technique over the reference, up to a line; a button for each technique, with its figures. */
static void show_pair(page *p, const gal_group *group)
{
    const char *below = *group->reference ? group->reference : group->rows[0].stem;
    fprintf(p->file, "<div class=\"pair\"><img src=\"%s.png\" alt=\"reference\" loading=\"lazy\">", below);
    fprintf(p->file, "<img class=\"over\" src=\"%s.png\" alt=\"\" loading=\"lazy\"%s>", group->rows[0].stem,
            *group->reference ? "" : " style=\"clip-path: none\"");
    fputs("<span class=\"left\"></span>", p->file);
    if (*group->reference)
        fputs("<div class=\"line\"></div><span class=\"right\">reference</span><input type=\"range\" min=\"0\" "
              "max=\"100\" step=\"any\" value=\"50\" aria-label=\"technique or reference\">", p->file);
    fputs("</div>\n<p>", p->file);
    for (uint32_t i = 0; i < group->row_count; i++) {
        const gal_row *r = &group->rows[i];
        fprintf(p->file, "<button data-stem=\"%s\" data-figures=\"", r->stem);
        put(p, r->label);
        fprintf(p->file, "%serror %s, SSIM %s, %s a frame\">", *r->label ? ": " : "", number("%.3f", r->error).text,
                number("%.3f", r->ssim).text, milliseconds(r->frame_ms).text);
        put(p, r->technique);
        fprintf(p->file, "%s</button>", strcmp(r->backend, "gl") == 0 ? ", OpenGL" : "");
    }
    if (*group->reference) fputs("<label><input type=\"checkbox\"> difference</label>", p->file);
    fputs("</p>\n<p class=\"figures\"></p>\n", p->file);
}

static void show_group(page *p, const gal_group *group)
{
    char line[600];
    fputs("<section id=\"", p->file);
    put_anchor(p, group);
    fputs("\">\n", p->file);
    heading(p, 2, group->title);
    show_pair(p, group);
    fputs("<details><summary>All figures</summary>\n", p->file);
    table_line(p, "technique | backend | settings | " FIGURES, 1);
    for (uint32_t i = 0; i < group->row_count; i++) {
        const gal_row *r = &group->rows[i];
        char f[200];
        figures(f, sizeof f, group, r);
        snprintf(line, sizeof line, "%s | %s | %s | %s", r->technique, r->backend, r->label, f);
        table_line(p, line, 0);
    }
    table_end(p);
    if (*group->reference && isfinite(group->kept_ms))
        paragraph(p, "%.0f triangles; the reference is a kept one of %.0f paths a pixel, which took %s on the "
                  "machine that made it; its own relative noise is %s.", group->triangles, group->samples,
                  milliseconds(group->kept_ms).text, number("%.4f", group->noise).text);
    else if (*group->reference)
        paragraph(p, "%.0f triangles; the reference took %s, its own relative noise is %s.", group->triangles,
                  milliseconds(group->reference_ms).text, number("%.3f", group->noise).text);
    fputs("</details></section>\n", p->file);
}

int gal_index(gallery *g, char *error)
{
    page p;
    if (open_page(&p, g, "index.html", error) != 0) return -1;
    heading(&p, 1, "Dapple: pictures");
    if (g->done < g->scenes) {
        fputs("<meta http-equiv=\"refresh\" content=\"20\">\n", p.file);
        paragraph(&p, "Still drawing: %u of %u scenes are here. The page loads itself again.", g->done, g->scenes);
    }
    show_best(&p, g);
    show_overview(&p, g);
    for (uint32_t i = 0; i < g->group_count; i++)
        if (g->groups[i].row_count) show_group(&p, &g->groups[i]);
    heading(&p, 2, "What the figures mean");
    fputs("<p><a href=\"which.html\">Which one do I need?</a> Figures technique by technique.</p>\n", p.file);
    paragraph(&p, "Each scene's direct light, or its direct and once bounced light, by the techniques that it was made "
                  "for, at one exposure. In difference pictures grey is equal, red too bright, blue too dark.");
    say_what_figures_mean(&p, g);
    fputs(html_script, p.file);
    return close_page(&p, "index.html", error);
}

/* ---- which one ---- */

static const char *const choices[] = {
    "you have | you want | take",
    "rigid objects that may move, turn and scale evenly; any light | their shadows at a steady cost | csm.h",
    "a tool that asks very many visibility questions | answers from a few megabytes, batched | csm.h",
    "many rigid objects and local lights that move, soft shadows | all of it in a few milliseconds | shadowfield.h",
    "anything that deforms, under a sky | its shadows, nothing precomputed | envlights.h, envshadow.h",
    "scenes, lights and cameras that move | bounced light without its shadows, fast | rsm.h",
    "the same | bounced light with its shadows | ism.h",
    "a renderer of any kind with directional lights | a sky as such lights | envlights.h",
    "answers about visibility, by csm.h or rays | direct light of lamps and skies by sampling | lightsampling.h",
    "few samples a pixel | a smooth picture, over frames and over neighbours | gifilter.h",
    "a need for answers exact to the last ray | | a ray tracer",
    NULL
};

typedef struct what {
    const char *technique, *header, *purpose, *lines[5];
} what;

/* Geometry, lights, precomputation, memory, what it cannot do. */
static const what techniques[] = {
    { "csm", "csm.h: coherent shadow maps",
      "Visibility of rigid objects from thousands of directions or places, compressed without loss.",
      { "rigid objects and instances of them; they move, turn and scale evenly. A mesh that deforms is built again",
        "sky, sun, spot, point, line, rectangle, disc, sphere, emissive mesh; places of local lights are fixed in "
        "the object's space unless they lie outside its hull",
        "seconds to minutes an object, once; bake keeps it in a file",
        "0.5 MB (a ball) to 35 MB an object at the default 16,384 maps, half of that with 4,096, however many instances "
        "there are; flat open sheets and boxes take more than round bodies",
        "deforming meshes, bounced light; contact shadows finer than a pixel of a map (1/128 of the object)" } },
    { "shadowfield", "shadowfield.h: precomputed shadow fields",
      "How much of each direction an object hides, on spheres around it; products of a few samples at run time.",
      { "rigid objects and instances of them; they move, turn and scale evenly, any number of them",
        "sky, sphere, disc, rectangle, emissive mesh, sun; lights move and change with time, too; not inside a room",
        "seconds an object, once; bake keeps it in a file",
        "0.4 MB an object (harmonics of 4 bands, 16 x 16 points a face), and the self-visibility of what is shaded; "
        "wavelets some MB",
        "hard shadows with harmonics (4 bands blur 45 degrees), deforming meshes (`render` exits 1 when one "
        "moves), bounced light; shades points" } },
    { "envshadow", "envshadow.h: environment-map shadows",
      "The sky as some hundred directional lights, each with a shadow map.",
      { "anything: deforming, open, torn; nothing is computed on it beforehand",
        "a sky, which may turn and change; suns", "none",
        "the shadow maps: 71 MB for 256 lights of 256 x 256 texels",
        "lights inside the scene, bounced light; walls thinner than the filter may leak" } },
    { "rsm", "rsm.h: reflective shadow maps",
      "One bounce of light from the texels of a shadow map that knows position, normal and flux.",
      { "anything; maps are drawn for every frame",
        "sun, spot, point, patches of area lights, sky as some suns", "none",
        "56 bytes a texel: 15 MB for a spot or sun of 512 x 512, 74 MB for an area light of 16 patches",
        "shadows of bounced light (corners are too bright behind things), a second bounce, mirrors" } },
    { "ism", "ism.h: imperfect, view-adaptive shadow maps",
      "A thousand virtual point lights, each with a coarse shadow map made of scattered points.",
      { "anything; points follow the triangles as they deform",
        "everything: sun, spot, point by your own shadow maps; area lights and skies as virtual lights", "none",
        "128 MB for 1024 lights of 8192 points and 64 x 64 texels, twice that where area lights bounce",
        "sharp indirect shadows (single maps leak and blur; their sum counts), mirrors" } },
};

static void describe(page *p, const gallery *g, const what *w)
{
    static const char *const names[] = { "geometry", "lights", "precomputation", "memory", "what it cannot do" };
    char line[700], f[200];
    int any = 0;
    heading(p, 2, w->header);
    paragraph(p, "%s", w->purpose);
    for (int i = 0; i < 5; i++) {
        snprintf(line, sizeof line, "%s | %s", names[i], w->lines[i]);
        table_line(p, line, i == 0);            /* Markdown has no table without a head */
    }
    table_end(p);
    for (uint32_t i = 0; i < g->group_count; i++)
        for (uint32_t k = 0; k < g->groups[i].row_count; k++) {
            const gal_row *r = &g->groups[i].rows[k];
            if (strcmp(r->technique, w->technique) != 0) continue;
            if (!any++) table_line(p, "scene | light | backend, settings | " FIGURES, 1);
            figures(f, sizeof f, &g->groups[i], r);
            snprintf(line, sizeof line, "%s | %s | %s%s%s | %s", g->groups[i].scene, g->groups[i].kind, r->backend,
                     *r->label ? ", " : "", r->label, f);
            table_line(p, line, 0);
        }
    if (any) table_end(p);
    else paragraph(p, "No figures from this run.");
}

static int write_which(gallery *g, const char *name, char *error)
{
    page p;
    if (open_page(&p, g, name, error) != 0) return -1;
    heading(&p, 1, "Which one do I need?");
    if (p.is_markdown) fputs("Made by `make demo` (out/which-one.md), from the figures of one run.\n\n", p.file);
    for (int i = 0; choices[i]; i++) table_line(&p, choices[i], i == 0);
    table_end(&p);
    paragraph(&p, "The headers work together: csm.h, envshadow.h or shadowfield.h for direct light, rsm.h or ism.h for "
                  "what bounces. gl_backend/ has the GPU's half of each of them, for OpenGL 3.3, ES 3.0 and WebGL 2.");
    say_what_figures_mean(&p, g);
    for (size_t i = 0; i < sizeof techniques / sizeof techniques[0]; i++) describe(&p, g, &techniques[i]);
    return close_page(&p, name, error);
}

int gal_which(gallery *g, char *error)
{
    return write_which(g, "which.html", error) || write_which(g, "which-one.md", error) ? -1 : 0;
}
