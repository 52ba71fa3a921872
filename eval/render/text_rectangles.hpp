#pragma once

#include "../../hier/base/vec.hpp"

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

}  // namespace tetrakis
