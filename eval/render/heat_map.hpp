#pragma once

#include "../../hier/base/vec.hpp"
#include "../io/png.hpp"

#include <string>
#include <vector>

namespace tetrakis {

/// A part of a letter: x to the right and y downwards from the text's upper left corner. Capital letters are
/// k_text_height units high.
struct TextRectangle {
    Vec2d low, high;
};
inline constexpr int k_text_height = 7;

/// One line of plain ASCII text as rectangles to fill.
std::vector<TextRectangle> text_rectangles(const std::string& text);
/// Width of a text in the same units.
int text_width(const std::string& text);

/// The sRGB colour of x in [0, 1], from dark blue through green to yellow, with evenly rising lightness (after
/// matplotlib's viridis, by S. van der Walt and N. Smith).
Vec3f heat_colour(double x);

namespace detail {

/// Draws a vertical bar with the colours of [lower, upper], and their values, at the right edge of the picture.
void draw_legend(Image& image, double lower, double upper, const std::string& title);

}  // namespace detail

}  // namespace tetrakis
