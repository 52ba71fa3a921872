#include "text_rectangles.hpp"

#if defined(__GNUC__)
#    pragma GCC diagnostic push
#    pragma GCC diagnostic ignored "-Wunused-function"
#    pragma GCC diagnostic ignored "-Wshadow"
#    pragma GCC diagnostic ignored "-Wsign-compare"
#    pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#endif
#include <stb/stb_easy_font.h>
#if defined(__GNUC__)
#    pragma GCC diagnostic pop
#endif

namespace tetrakis {

std::vector<TextRectangle> text_rectangles(const std::string& text) {
    struct Vertex {
        float x, y, z;
        unsigned char colour[4];
    };
    constexpr std::size_t k_quads_per_glyph = 18;
    std::string copy = text;  // the font's functions take what they could write to
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
    std::string copy = text;
    return stb_easy_font_width(copy.data());
}

}  // namespace tetrakis
