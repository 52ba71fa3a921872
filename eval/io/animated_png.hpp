#pragma once

#include "png.hpp"

#include <span>

namespace tetrakis {

/// Writes an animated PNG that repeats for ever. Programs without support for it show the first picture.
/// @param images             one for each frame, all of one size
/// @param frames_per_second  1 to 100
/// @throws Error  io; invalid_input: no pictures, pictures of different sizes or without pixels, a rate out of range
void write_animated_png(AtomicFile& file, std::span<const Image> images, int frames_per_second);

}  // namespace tetrakis
