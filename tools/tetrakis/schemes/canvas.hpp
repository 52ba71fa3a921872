#pragma once

#include "../../../eval/io/png.hpp"
#include "../../../eval/render/heat_map.hpp"
#include "../../../hier/base/vec.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

namespace tetrakis::cli {

/// A white image for lines, dots and text. Coordinates are pixels from the top left. It is drawn enlarged and averaged,
/// so that edges are smooth.
class Canvas {
  public:
    Canvas(int width, int height) {
        large_.width = width * k_samples;
        large_.height = height * k_samples;
        large_.rgb.assign(std::size_t{3} * large_.width * large_.height, 255);
    }

    void line(Vec2d from, Vec2d to, double width, const Vec3f& colour) {
        const Vec2d along = to - from, reach(width / 2);
        const double length2 = glm::dot(along, along);
        fill(glm::min(from, to) - reach, glm::max(from, to) + reach, colour, [&](Vec2d p) {
            const double t = length2 > 0 ? std::clamp(glm::dot(p - from, along) / length2, 0.0, 1.0) : 0.0;
            return glm::length(p - from - t * along) <= width / 2;
        });
    }
    void disc(Vec2d centre, double radius, const Vec3f& colour) {
        fill(centre - radius, centre + radius, colour, [&](Vec2d p) { return glm::length(p - centre) <= radius; });
    }
    void circle(Vec2d centre, double radius, double width, const Vec3f& colour) {
        const double reach = radius + width / 2;
        fill(centre - reach, centre + reach, colour,
             [&](Vec2d p) { return std::abs(glm::length(p - centre) - radius) <= width / 2; });
    }
    void rectangle(Vec2d low, Vec2d high, const Vec3f& colour) {
        fill(low, high, colour, [&](Vec2d p) { return p.x >= low.x && p.x < high.x && p.y >= low.y && p.y < high.y; });
    }
    /// Draws ASCII text. @param at  its top left corner @param height  of a capital letter
    void text(Vec2d at, double height, const std::string& text, const Vec3f& colour) {
        const double scale = height / k_text_height;
        for (const TextRectangle& part : text_rectangles(text))
            rectangle(at + scale * part.low, at + scale * part.high, colour);
    }
    /// Draws text centred at `middle` on a white rectangle.
    void label(Vec2d middle, double height, const std::string& text, const Vec3f& colour) {
        const Vec2d half(text_width(text, height) / 2, height / 2), margin(k_label_margin * height);
        rectangle(middle - half - margin, middle + half + margin, Vec3f(1));
        this->text(middle - half, height, text, colour);
    }
    static double text_width(const std::string& text, double height) {
        return tetrakis::text_width(text) * height / k_text_height;
    }
    /// Copies an image so that its top left corner is at (x, y).
    void paste(int x, int y, const Image& image) {
        for (int v = 0; v < image.height * k_samples; ++v)
            for (int u = 0; u < image.width * k_samples; ++u) {
                const int to_x = x * k_samples + u, to_y = y * k_samples + v;
                if (to_x < 0 || to_y < 0 || to_x >= large_.width || to_y >= large_.height) continue;
                const auto from =
                    image.rgb.begin() + 3 * (static_cast<std::ptrdiff_t>(v / k_samples) * image.width + u / k_samples);
                std::copy(from, from + 3,
                          large_.rgb.begin() + 3 * (static_cast<std::ptrdiff_t>(to_y) * large_.width + to_x));
            }
    }

    Image image() const {
        Image result;
        result.width = large_.width / k_samples;
        result.height = large_.height / k_samples;
        result.rgb.resize(std::size_t{3} * result.width * result.height);
        for (int y = 0; y < result.height; ++y)
            for (int x = 0; x < result.width; ++x)
                for (int c = 0; c < 3; ++c) {
                    int sum = 0;
                    for (int v = 0; v < k_samples; ++v)
                        for (int u = 0; u < k_samples; ++u)
                            sum += large_.rgb[3 * (static_cast<std::size_t>(y * k_samples + v) * large_.width +
                                                   x * k_samples + u) +
                                              c];
                    result.rgb[3 * (static_cast<std::size_t>(y) * result.width + x) + c] =
                        static_cast<std::uint8_t>((sum + k_samples * k_samples / 2) / (k_samples * k_samples));
                }
        return result;
    }

  private:
    static constexpr int k_samples = 3;             // per pixel and axis
    static constexpr double k_label_margin = 0.35;  // white around a label, in heights

    template <class Inside>
    void fill(Vec2d low, Vec2d high, const Vec3f& colour, Inside&& inside) {
        const auto first = [](double x) { return std::max(0, static_cast<int>(std::floor(x * k_samples))); };
        const auto last = [](double x, int size) {
            return std::min(size, static_cast<int>(std::ceil(x * k_samples)) + 1);
        };
        std::uint8_t rgb[3];
        for (int c = 0; c < 3; ++c) rgb[c] = static_cast<std::uint8_t>(std::lround(255 * colour[c]));
        for (int y = first(low.y); y < last(high.y, large_.height); ++y)
            for (int x = first(low.x); x < last(high.x, large_.width); ++x)
                if (inside(Vec2d((x + 0.5) / k_samples, (y + 0.5) / k_samples)))
                    std::copy(rgb, rgb + 3,
                              large_.rgb.begin() + 3 * (static_cast<std::ptrdiff_t>(y) * large_.width + x));
    }

    Image large_;
};

}  // namespace tetrakis::cli
