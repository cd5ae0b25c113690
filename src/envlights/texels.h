/* ---- math: sine, cosine and arc tangent in double, the same bits everywhere ---- */

#define ENVLT__PI 3.14159265358979324

/* Writes sine and cosine of x, |x| <= 100. x is taken to an eighth of a turn about 0, with pi / 2 in two
   parts so that nothing cancels, and Taylor series of ten terms do the rest. */
static void envlt__sincos64(double x, double *sine, double *cosine)
{
    int k = (int)(x * (2.0 / ENVLT__PI) + (x < 0.0 ? -0.5 : 0.5)), j;
    double r = (x - (double)k * 1.5707963267948966) - (double)k * 6.123233995736766e-17, z = r * r, s = 1.0;
    double c = 1.0;
    for (j = 9; j > 0; j--) {
        s = 1.0 - s * z / (double)(2 * j * (2 * j + 1));
        c = 1.0 - c * z / (double)(2 * j * (2 * j - 1));
    }
    s *= r;
    *sine = k & 2 ? -(k & 1 ? c : s) : k & 1 ? c : s;
    *cosine = (k + 1) & 2 ? -(k & 1 ? s : c) : k & 1 ? s : c;
}

/* Returns the arc tangent. The angle is halved twice, by tan(a / 2) = tan a / (1 + sqrt(1 + tan^2 a)), so
   that the series converges quickly, and the result is four times the angle found. */
static double envlt__atan64(double x)
{
    double y = x / (1.0 + sqrt(1.0 + x * x)), z, sum = 0.0;
    int j;
    y = y / (1.0 + sqrt(1.0 + y * y));
    z = y * y;
    for (j = 21; j >= 0; j--) sum = 1.0 / (double)(2 * j + 1) - z * sum;
    return 4.0 * y * sum;
}

/* ---- texels: directions and solid angles ---- */

/* Returns the solid angle of the rectangle from the face's centre to (a, b), for a face at distance 1. */
static double envlt__corner_angle(double a, double b)
{
    return envlt__atan64(a * b / sqrt(1.0 + a * a + b * b));
}

/* Returns the solid angle of the rectangle [a0, a1] x [b0, b1] of a face at distance 1. */
static double envlt__rectangle_angle(double a0, double a1, double b0, double b1)
{
    return envlt__corner_angle(a1, b1) - envlt__corner_angle(a0, b1) - envlt__corner_angle(a1, b0) +
           envlt__corner_angle(a0, b0);
}

/* Returns the solid angle of a texel; with `upper` that of the part of the texel above the horizon. */
static double envlt__solid_angle(const envlt_map *map, uint32_t face, uint32_t x, uint32_t y, int upper)
{
    double w = map->width;
    double h = map->height;
    double c0, c1, s;
    double b0, b1;
    if (map->projection != ENVLT_PROJECTION_CUBE) {
        envlt__sincos64(ENVLT__PI * y / h, &s, &c0);
        envlt__sincos64(ENVLT__PI * (y + 1.0) / h, &s, &c1);
        if (upper && 2 * (uint64_t)y >= map->height) return 0.0;
        if (upper && 2 * ((uint64_t)y + 1) > map->height) c1 = 0.0;
        return 2.0 * ENVLT__PI / w * (c0 - c1);
    }
    b0 = 2.0 * y / h - 1.0;
    b1 = 2.0 * (y + 1.0) / h - 1.0;
    if (upper && face == 3) return 0.0;
    if (upper && face != 2) b1 = b1 > 0.0 ? 0.0 : b1;
    if (b0 >= b1) return 0.0;
    return envlt__rectangle_angle(2.0 * x / w - 1.0, 2.0 * (x + 1.0) / w - 1.0, b0, b1);
}

/* Writes the unit direction to the point (a, b) of a cube's face, both -1..1 from the face's top left corner.
   */
static void envlt__cube_direction(uint32_t face, double a, double b, double *d)
{
    double length = 1.0 / sqrt(1.0 + a * a + b * b);
    double x = face == 0 ? 1.0 : face == 1 ? -1.0 : face == 5 ? -a : a;
    double y = face == 2 ? 1.0 : face == 3 ? -1.0 : -b;
    double z = face == 0 ? -a : face == 1 ? a : face == 2 ? b : face == 3 ? -b : face == 4 ? 1.0 : -1.0;
    d[0] = x * length;
    d[1] = y * length;
    d[2] = z * length;
}

/* Writes the unit direction to the point (x, y) of the map, in texels from the top left corner of the face.
   */
static void envlt__direction(const envlt_map *map, uint32_t face, double x, double y, double *d)
{
    double st, ct, sp, cp;
    if (map->projection == ENVLT_PROJECTION_CUBE) {
        envlt__cube_direction(face, 2.0 * x / map->width - 1.0, 2.0 * y / map->height - 1.0, d);
        return;
    }
    envlt__sincos64(ENVLT__PI * y / map->height, &st, &ct);
    envlt__sincos64(2.0 * ENVLT__PI * (x / map->width - 0.5), &sp, &cp);
    d[0] = st * cp;
    d[1] = ct;
    d[2] = st * sp;
}

/* Returns the number of texel (x, y) of a cube's face. If x or y is one beyond the face, that is a texel of
   the neighbouring face. */
static uint32_t envlt__cube_texel(uint32_t side, uint32_t face, int64_t x, int64_t y)
{
    double d[3], m[3], a, b;
    double n = side;
    int64_t col = x, row = y;
    int i, axis = 0;
    if (x < 0 || y < 0 || x >= (int64_t)side || y >= (int64_t)side) {
        envlt__cube_direction(face, (2.0 * (double)x + 1.0) / n - 1.0, (2.0 * (double)y + 1.0) / n - 1.0, d);
        for (i = 0; i < 3; i++) {
            m[i] = fabs(d[i]);
            if (m[i] > m[axis]) axis = i;
        }
        face = (uint32_t)(2 * axis + (d[axis] < 0.0));
        a = face == 0 ? -d[2] : face == 1 ? d[2] : face == 5 ? -d[0] : d[0];
        b = face == 2 ? d[2] : face == 3 ? -d[2] : -d[1];
        col = (int64_t)((a / m[axis] + 1.0) * 0.5 * n);
        row = (int64_t)((b / m[axis] + 1.0) * 0.5 * n);
        col = col >= (int64_t)side ? (int64_t)side - 1 : col < 0 ? 0 : col;
        row = row >= (int64_t)side ? (int64_t)side - 1 : row < 0 ? 0 : row;
    }
    return (face * side + (uint32_t)row) * side + (uint32_t)col;
}

/* Checks whether a map can be used, and writes how many texels the map has. */
static envlt_result envlt__check_map(const envlt_map *map, size_t *texels, const envlt__logger *logger)
{
    uint64_t count;
    if (!map->rgb) return envlt__refuse_text(logger, "map.rgb", "is NULL", ENVLT_ERR_ARGUMENT);
    if (!map->width) return envlt__refuse(logger, "map.width", 0.0, "1 or more", ENVLT_ERR_ARGUMENT);
    if (!map->height) return envlt__refuse(logger, "map.height", 0.0, "1 or more", ENVLT_ERR_ARGUMENT);
    if (map->texel_stride && (map->texel_stride < 12 || map->texel_stride % 4))
        return envlt__refuse(logger, "map.texel_stride", (double)map->texel_stride,
                             "0, or a multiple of 4 from 12 on", ENVLT_ERR_ARGUMENT);
    if ((unsigned)map->projection >= ENVLT_PROJECTION_COUNT)
        return envlt__refuse(logger, "map.projection", map->projection, "one of envlt_projection",
                             ENVLT_ERR_INPUT);
    if (map->projection == ENVLT_PROJECTION_CUBE && map->width != map->height)
        return envlt__refuse(logger, "map.height", map->height, "the width: faces of a cube are squares",
                             ENVLT_ERR_ARGUMENT);
    count = map->width > 1u << 27 || map->height > 1u << 27 ? UINT64_MAX : (uint64_t)map->width * map->height;
    if (count <= 1u << 27 && map->projection == ENVLT_PROJECTION_CUBE) count *= 6u;
    if (count > 1u << 27)
        return envlt__refuse(logger, "map.width x map.height", (double)map->width * map->height,
                             "at most 2^27, all faces of a cube together", ENVLT_ERR_LIMIT);
    if (map->texel_stride && (size_t)count > SIZE_MAX / map->texel_stride)
        return envlt__refuse(logger, "map.texel_stride", (double)map->texel_stride,
                             "less: the map has more bytes than there are addresses", ENVLT_ERR_LIMIT);
    *texels = (size_t)count;
    return ENVLT_OK;
}

/* Reads the radiance of a texel with 0 in place of channels that are negative, above 1e30 or not a number,
   and returns 1 if there was such a channel. One comparison finds them all: read as integers, the bits of
   negative floats and of NaN are greater than those of 1e30 (0x7149f2ca), as are those of larger floats. The
   bits of -0 are too, but -0 is not counted. */
static inline int envlt__fetch_texel(const envlt_map *map, size_t texel, float *rgb)
{
    const char *p = (const char *)map->rgb + texel * (map->texel_stride ? map->texel_stride : 12);
    uint32_t bits[3];
    int c, bad = 0;
    memcpy(rgb, p, 3 * sizeof *rgb);
    memcpy(bits, p, sizeof bits);
    if (bits[0] <= 0x7149f2cau && bits[1] <= 0x7149f2cau && bits[2] <= 0x7149f2cau) return 0;
    for (c = 0; c < 3; c++)
        if (bits[c] > 0x7149f2cau) {
            bad |= (bits[c] & 0x7fffffffu) != 0;
            rgb[c] = 0.0f;
        }
    return bad;
}

static float envlt__luminance(const float *rgb)
{
    return 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2];
}

ENVLT_DEF double envlt_texel_solid_angle(envlt_projection projection, uint32_t width, uint32_t height,
                                         uint32_t x, uint32_t y)
{
    envlt_map map;
    memset(&map, 0, sizeof map);
    map.projection = projection;
    map.width = width;
    map.height = height;
    return x < width && y < height ? envlt__solid_angle(&map, 0, x, y, 0) : 0.0;
}

/* Returns a coordinate within 8 times the map's size, for which sine and cosine are exact; 0 for NaN. */
static double envlt__clamp_coordinate(float x, uint32_t size)
{
    double most = 8.0 * size, d = envlt__finite(x) ? (double)x : 0.0;
    return d > most ? most : d < -most ? -most : d;
}

ENVLT_DEF void envlt_texel_direction(envlt_projection projection, uint32_t width, uint32_t height,
                                     uint32_t face, float x, float y, float direction[3])
{
    envlt_map map;
    double d[3];
    int i;
    memset(&map, 0, sizeof map);
    map.projection = projection;
    map.width = width ? width : 1;
    map.height = height ? height : 1;
    envlt__direction(&map, face, envlt__clamp_coordinate(x, map.width),
                     envlt__clamp_coordinate(y, map.height), d);
    for (i = 0; i < 3; i++) direction[i] = (float)d[i];
}
