#pragma once

#include "../../hier/base/vec.hpp"
#include "../io/png.hpp"

#include <string>

namespace tetrakis {

/// Colour of x in [0, 1], sRGB: dark blue through green to yellow, of evenly rising lightness (after matplotlib's
/// viridis, by S. van der Walt and N. Smith).
Vec3f heat_colour(double x);

namespace detail {

/// Draws a vertical bar with the colours of [lower, upper] and their numbers at the right edge of the picture.
void draw_legend(Image& image, double lower, double upper, const std::string& title);

}  // namespace detail

}  // namespace tetrakis
