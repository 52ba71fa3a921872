#pragma once

#include "png.hpp"

#include <span>

namespace tetrakis {

/// Writes an animated PNG that repeats for ever. Programs that do not know animation show its first picture.
/// @param images             one for each frame, all of one size
/// @param frames_per_second  1 to 100
/// @throws Error  io; invalid_input: no pictures, or of several sizes, or without pixels; the rate
void write_animated_png(AtomicFile& file, std::span<const Image> images, int frames_per_second);

}  // namespace tetrakis
