/* main.c - the program `compare`: how far picture A is from picture B. docs/programs.md is its definition.

   Pixels that are exactly 0 in both are left out everywhere. Pixels with a value that is not finite in A or B are
   counted, left out too, and make the exit status 1. psnr and ssim look at what a viewer sees: both pictures under B's
   automatic exposure, in sRGB, clamped to 0..1. ssim (Wang, Bovik, Sheikh and Simoncelli, "Image quality assessment",
   2004) is taken on the luminance of those values and averaged over the windows whose centre counts; at the picture's
   border a window's weights are normalised over the part inside. */
#include "../common/common.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

extern const char dapple_version[];        /* of CHANGELOG.md, by the Makefile */

enum { DONE = 0, FAILED = 1, BAD_ARGUMENTS = 2 };
enum { WINDOW = 5 };           /* pixels on either side of the centre: 11 x 11 */

typedef struct comparison {
    uint32_t      width, height;
    const float  *a, *b;
    float         ev;          /* B's */
    unsigned char *counts;     /* 1 for each pixel that counts */
    size_t        pixels, nonfinite;
    double        rmse, mean_a, mean_b, psnr, ssim;
} comparison;

/* ---- what counts ---- */

static void select_pixels(comparison *c)
{
    for (size_t i = 0; i < (size_t)c->width * c->height; i++) {
        const float *a = c->a + 3 * i, *b = c->b + 3 * i;
        int finite = 1, zero = 1;
        for (int k = 0; k < 3; k++) {
            finite &= isfinite(a[k]) && isfinite(b[k]);
            zero &= !(a[k] < 0 || a[k] > 0 || b[k] < 0 || b[k] > 0);
        }
        c->counts[i] = (unsigned char)(finite && !zero);
        c->pixels += c->counts[i];
        c->nonfinite += (size_t)!finite;
    }
}

/* ---- errors of radiance ---- */

static void measure_radiance(comparison *c)
{
    double squares = 0, sum_a = 0, sum_b = 0, values = 3 * (double)c->pixels;
    for (size_t i = 0; i < (size_t)c->width * c->height; i++)
        for (size_t k = 0; k < 3 && c->counts[i]; k++) {
            double a = (double)c->a[3 * i + k], b = (double)c->b[3 * i + k];
            squares += (a - b) * (a - b);
            sum_a += a;
            sum_b += b;
        }
    c->rmse = sqrt(squares / values);
    c->mean_a = sum_a / values;
    c->mean_b = sum_b / values;
}

/* ---- what a viewer sees ---- */

static double shown(const comparison *c, float value)
{
    double x = fmin(fmax((double)value * exp2((double)c->ev), 0), 1);
    return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
}

static double shown_luminance(const comparison *c, const float *rgb)
{
    return 0.2126 * shown(c, rgb[0]) + 0.7152 * shown(c, rgb[1]) + 0.0722 * shown(c, rgb[2]);
}

static double measure_psnr(const comparison *c)
{
    double squares = 0;
    for (size_t i = 0; i < (size_t)c->width * c->height; i++)
        for (size_t k = 0; k < 3 && c->counts[i]; k++) {
            double d = shown(c, c->a[3 * i + k]) - shown(c, c->b[3 * i + k]);
            squares += d * d;
        }
    return -10 * log10(squares / (3 * (double)c->pixels));     /* infinite for equal pictures */
}

/* Gaussian of sigma 1.5 along one axis; step: values between neighbours. */
static void blur(const double *from, double *to, size_t count, size_t lines, size_t step, size_t line_step)
{
    double weight[WINDOW + 1];
    for (int k = 0; k <= WINDOW; k++)
        weight[k] = exp(-k * k / (2 * 1.5 * 1.5));
    for (size_t line = 0; line < lines; line++)
        for (size_t i = 0; i < count; i++) {
            double sum = 0, total = 0;
            for (size_t j = i < WINDOW ? 0 : i - WINDOW; j < count && j <= i + WINDOW; j++) {
                double w = weight[j < i ? i - j : j - i];
                sum += w * from[line * line_step + j * step];
                total += w;
            }
            to[line * line_step + i * step] = sum / total;
        }
}

static void blur_image(const comparison *c, double *image, double *scratch)
{
    blur(image, scratch, c->width, c->height, 1, c->width);
    blur(scratch, image, c->height, c->width, c->width, 1);
}

/* Planes of A, B, A A, B B, A B, blurred to the moments of every window; -1: out of memory. */
static int measure_ssim(comparison *c)
{
    const double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
    size_t size = (size_t)c->width * c->height;
    double *planes = malloc(6 * size * sizeof *planes), *p[6], sum = 0;
    if (!planes)
        return -1;
    for (size_t k = 0; k < 6; k++)
        p[k] = planes + k * size;
    for (size_t i = 0; i < size; i++) {
        double a = shown_luminance(c, c->a + 3 * i), b = shown_luminance(c, c->b + 3 * i);
        a = isfinite(a) ? a : 0;
        b = isfinite(b) ? b : 0;
        p[0][i] = a, p[1][i] = b, p[2][i] = a * a, p[3][i] = b * b, p[4][i] = a * b;
    }
    for (int k = 0; k < 5; k++)
        blur_image(c, p[k], p[5]);
    for (size_t i = 0; i < size; i++) {
        double a = p[0][i], b = p[1][i];
        double spread = fmax(p[2][i] - a * a, 0) + fmax(p[3][i] - b * b, 0), both = p[4][i] - a * b;
        if (c->counts[i])
            sum += (2 * a * b + c1) * (2 * both + c2) / ((a * a + b * b + c1) * (spread + c2));
    }
    free(planes);
    c->ssim = sum / (double)c->pixels;
    return 0;
}

/* ---- difference picture ---- */

/* Grey where A and B agree; towards red where A is brighter, towards blue where B is. Full colour stands for a
   difference of luminance of a quarter of the white of B's automatic exposure. Black: pixels that do not count. */
static int write_difference(const comparison *c, const char *path, char *error)
{
    static const float grey[3] = { 0.21f, 0.21f, 0.21f }, red[3] = { 0.85f, 0.01f, 0.01f };
    static const float blue[3] = { 0.01f, 0.08f, 0.95f };
    ex_image image;
    int result;
    if (ex_image_alloc(&image, c->width, c->height) != 0) {
        snprintf(error, EX_ERROR_SIZE, "out of memory");
        return -1;
    }
    for (size_t i = 0; i < (size_t)c->width * c->height; i++) {
        const float *a = c->a + 3 * i, *b = c->b + 3 * i;
        float d = 0.2126f * (a[0] - b[0]) + 0.7152f * (a[1] - b[1]) + 0.0722f * (a[2] - b[2]);
        float s = fminf(fabsf(4 * d * exp2f(c->ev)), 1);
        for (size_t k = 0; k < 3 && c->counts[i]; k++)
            image.rgb[3 * i + k] = grey[k] + s * ((d > 0 ? red[k] : blue[k]) - grey[k]);
    }
    result = ex_image_write(&image, path, 0, error);
    ex_image_free(&image);
    return result;
}

/* ---- program ---- */

static void print_number(const char *name, double value)
{
    if (isfinite(value))
        printf("\"%s\": %.7g, ", name, value);
    else
        printf("\"%s\": null, ", name);
}

static void print(const comparison *c)
{
    putchar('{');
    print_number("rmse", c->rmse);
    print_number("relative_rmse", c->rmse / c->mean_b);
    print_number("mean_ratio", c->mean_a / c->mean_b);
    print_number("psnr", c->psnr);
    print_number("ssim", c->ssim);
    printf("\"ev\": %.7g, \"pixels\": %llu, \"nonfinite\": %llu}\n", (double)c->ev, (unsigned long long)c->pixels,
           (unsigned long long)c->nonfinite);
}

static int compare(const ex_image *a, const ex_image *b, const char *diff, char *error)
{
    comparison c;
    int result = -1;
    memset(&c, 0, sizeof c);
    if (a->width != b->width || a->height != b->height) {
        snprintf(error, EX_ERROR_SIZE, "the sizes differ: %ux%u and %ux%u", (unsigned)a->width, (unsigned)a->height,
                 (unsigned)b->width, (unsigned)b->height);
        return -1;
    }
    c.width = a->width;
    c.height = a->height;
    c.a = a->rgb;
    c.b = b->rgb;
    c.ev = ex_image_auto_ev(b);
    c.counts = calloc((size_t)c.width * c.height, 1);
    if (c.counts) {
        select_pixels(&c);
        measure_radiance(&c);
        c.psnr = measure_psnr(&c);
        result = measure_ssim(&c);
    }
    if (result != 0) {
        snprintf(error, EX_ERROR_SIZE, "out of memory");
    } else {
        print(&c);
        result = diff ? write_difference(&c, diff, error) : 0;
        if (result == 0 && c.nonfinite) {
            snprintf(error, EX_ERROR_SIZE, "%llu pixels are not finite", (unsigned long long)c.nonfinite);
            result = -1;
        }
    }
    free(c.counts);
    return result;
}

static int parse(int count, char **values, const char **names, const char **diff, char *error)
{
    int used = 0;
    *diff = NULL;
    for (int i = 1; i < count; i++) {
        if (strcmp(values[i], "--diff") == 0 && i + 1 < count && !*diff) {
            *diff = values[++i];
        } else if (values[i][0] == '-' || used == 2) {
            snprintf(error, EX_ERROR_SIZE, "%.80s: unexpected (see compare --help)", values[i]);
            return -1;
        } else {
            names[used++] = values[i];
        }
    }
    if (*diff && (strlen(*diff) < 5 || strcmp(*diff + strlen(*diff) - 4, ".png") != 0)) {
        snprintf(error, EX_ERROR_SIZE, "--diff %.80s: must end in .png", *diff);
        return -1;
    }
    if (used == 2)
        return 0;
    snprintf(error, EX_ERROR_SIZE, "two pictures are needed (see compare --help)");
    return -1;
}

int main(int count, char **values)
{
    char error[EX_ERROR_SIZE] = "";
    const char *names[2] = { NULL, NULL }, *diff;
    ex_image a = { 0, 0, NULL }, b = { 0, 0, NULL };
    int status = BAD_ARGUMENTS;
    if (count == 2 && strcmp(values[1], "--help") == 0) {
        puts("usage: compare A.pfm B.pfm [--diff FILE.png]\n"
             "       compare --help | --version\n"
             "\n"
             "Prints one line of JSON: rmse, relative_rmse (over B's mean), mean_ratio, psnr, ssim, B's ev, pixels,\n"
             "nonfinite. --diff: grey where equal, red where A is brighter, blue where B is; full colour at a quarter\n"
             "of B's white.\n"
             "\n"
             "exit status: 0 done, 1 failed (also: other sizes, pixels that are not finite), 2 bad arguments");
        return DONE;
    }
    if (count == 2 && strcmp(values[1], "--version") == 0)
        return printf("compare %s\n", dapple_version), DONE;
    if (parse(count, values, names, &diff, error) == 0)
        status = ex_image_read_pfm(&a, names[0], error) == 0 && ex_image_read_pfm(&b, names[1], error) == 0 &&
                 compare(&a, &b, diff, error) == 0 ? DONE : FAILED;
    if (status != DONE)
        fprintf(stderr, "compare: %s\n", error);
    ex_image_free(&a);
    ex_image_free(&b);
    return status;
}
