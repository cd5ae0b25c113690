// hdr - an OpenEXR picture (any compression) to Radiance .hdr on stdout. Written by make assets, needs libopenexr-dev.
#include <ImfArray.h>
#include <ImfRgbaFile.h>

#include <cmath>
#include <cstdio>
#include <exception>

static int convert(const char *name)
{
    Imf::RgbaInputFile file(name);
    const Imath::Box2i window = file.dataWindow();
    const int width = window.max.x - window.min.x + 1, height = window.max.y - window.min.y + 1;
    Imf::Array2D<Imf::Rgba> pixels(height, width);
    file.setFrameBuffer(&pixels[0][0] - window.min.x - window.min.y * width, 1, static_cast<size_t>(width));
    file.readPixels(window.min.y, window.max.y);
    std::printf("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n", height, width);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const float rgb[3] = { pixels[y][x].r, pixels[y][x].g, pixels[y][x].b };
            float most = 0;
            int exponent = 0;
            for (float v : rgb) most = v > most && std::isfinite(v) ? v : most;
            const float scale = most > 1e-32f ? std::frexp(most, &exponent) * 256.0f / most : 0.0f;
            for (float v : rgb) std::putchar(v > 0 && std::isfinite(v) ? static_cast<int>(v * scale) : 0);
            std::putchar(most > 1e-32f ? exponent + 128 : 0);
        }
    return std::fflush(stdout) != 0;
}

int main(int count, char **values)
{
    try {
        if (count == 2) return convert(values[1]);
        std::fprintf(stderr, "hdr: usage: hdr FILE.exr > FILE.hdr\n");
        return 2;
    } catch (const std::exception &e) {
        std::fprintf(stderr, "hdr: %s\n", e.what());
        return 1;
    }
}
