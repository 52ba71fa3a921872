#pragma once

#include "../../hier/base/vec.hpp"
#include "../io/png.hpp"

#include <string>
#include <vector>

namespace tetrakis {

/// A part of a letter: x to the right and y downwards from the text's upper left corner, in units of which a capital
/// is k_text_height high.
struct TextRectangle {
    Vec2d low, high;
};
inline constexpr int k_text_height = 7;

/// One line of plain ASCII text as rectangles to fill.
std::vector<TextRectangle> text_rectangles(const std::string& text);
/// How wide it is, in the same units.
int text_width(const std::string& text);

/// Colour of x in [0, 1], sRGB: dark blue through green to yellow, of evenly rising lightness (after matplotlib's
/// viridis, by S. van der Walt and N. Smith).
Vec3f heat_colour(double x);

namespace detail {

/// Draws a vertical bar with the colours of [lower, upper] and their numbers at the right edge of the picture.
void draw_legend(Image& image, double lower, double upper, const std::string& title);

}  // namespace detail

}  // namespace tetrakis
