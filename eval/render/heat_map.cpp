#include "heat_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include <stb/stb_easy_font.h>

namespace tetrakis {

namespace {

// A copy for stb_easy_font: its table has only printable ASCII characters, and its functions take pointers to
// non-const char.
std::string printable(std::string text) {
    for (char& c : text)
        if (c != '\n' && (c < ' ' || c > '~')) c = '?';
    return text;
}

}  // namespace

std::vector<TextRectangle> text_rectangles(const std::string& text) {
    struct Vertex {
        float x, y, z;
        unsigned char colour[4];
    };
    constexpr std::size_t k_quads_per_glyph = 18;
    std::string copy = printable(text);
    std::vector<Vertex> corners(4 * k_quads_per_glyph * (text.size() + 1));
    const int quads = stb_easy_font_print(0, 0, copy.data(), nullptr, corners.data(),
                                          static_cast<int>(corners.size() * sizeof(Vertex)));
    std::vector<TextRectangle> result;
    for (int q = 0; q < quads; ++q) {
        const Vertex &low = corners[4 * q], &high = corners[4 * q + 2];
        result.push_back({Vec2d(low.x, low.y), Vec2d(high.x, high.y)});
    }
    return result;
}

int text_width(const std::string& text) {
    std::string copy = printable(text);
    return stb_easy_font_width(copy.data());
}

Vec3f heat_colour(double x) {
    // viridis at x = 0, 1/8, ..., 1.
    constexpr float k_stops[9][3] = {{0.267f, 0.005f, 0.329f}, {0.279f, 0.175f, 0.483f}, {0.230f, 0.322f, 0.546f},
                                     {0.173f, 0.449f, 0.558f}, {0.128f, 0.567f, 0.551f}, {0.158f, 0.684f, 0.502f},
                                     {0.369f, 0.789f, 0.383f}, {0.678f, 0.864f, 0.190f}, {0.993f, 0.906f, 0.144f}};
    const double place = std::isfinite(x) ? std::clamp(x, 0.0, 1.0) * 8 : 0.0;
    const int i = std::min(static_cast<int>(place), 7);
    const auto s = static_cast<float>(place - i);
    Vec3f colour(0);
    for (int c = 0; c < 3; ++c) colour[c] = k_stops[i][c] * (1 - s) + k_stops[i + 1][c] * s;
    return colour;
}

namespace detail {

namespace {

void fill(Image& image, int x0, int y0, int x1, int y1, const Vec3f& colour) {
    for (int y = std::max(0, y0); y < std::min(image.height, y1); ++y)
        for (int x = std::max(0, x0); x < std::min(image.width, x1); ++x)
            for (int c = 0; c < 3; ++c)
                image.rgb[3 * (static_cast<std::size_t>(y) * image.width + x) + c] =
                    static_cast<std::uint8_t>(std::lround(255 * colour[c]));
}

void draw_text(Image& image, int x, int y, int scale, const std::string& text, const Vec3f& colour) {
    const auto at = [&](double value) { return static_cast<int>(std::lround(value * scale)); };
    for (const TextRectangle& part : text_rectangles(text))
        fill(image, x + at(part.low.x), y + at(part.low.y), x + at(part.high.x), y + at(part.high.y), colour);
}

}  // namespace

void draw_legend(Image& image, double lower, double upper, const std::string& title) {
    const int scale = std::max(1, image.height / 420);
    const int bar_height = image.height * 6 / 10, bar_width = 9 * scale, margin = 14 * scale;
    std::vector<std::string> labels;
    constexpr int k_ticks = 5;
    int widest = title.empty() ? 0 : text_width(title) * scale - bar_width - 5 * scale;
    for (int i = 0; i < k_ticks; ++i) {
        labels.push_back(fmt::format("{:.2e}", lower + (upper - lower) * i / (k_ticks - 1)));
        widest = std::max(widest, text_width(labels.back()) * scale);
    }
    const int x = image.width - margin - widest - 5 * scale - bar_width, y = (image.height - bar_height) / 2;
    const Vec3f ink(0.16f, 0.18f, 0.21f);
    fill(image, x - 1, y - 1, x + bar_width + 1, y + bar_height + 1, ink);
    for (int row = 0; row < bar_height; ++row)
        fill(image, x, y + row, x + bar_width, y + row + 1, heat_colour(1 - (row + 0.5) / bar_height));
    for (int i = 0; i < k_ticks; ++i) {
        const int tick = y + bar_height - 1 - (bar_height - 1) * i / (k_ticks - 1);
        fill(image, x + bar_width, tick, x + bar_width + 3 * scale, tick + 1, ink);
        draw_text(image, x + bar_width + 5 * scale, tick - k_text_height * scale / 2, scale, labels[i], ink);
    }
    if (!title.empty()) draw_text(image, x, y - (k_text_height + 9) * scale, scale, title, ink);
}

}  // namespace detail

}  // namespace tetrakis
