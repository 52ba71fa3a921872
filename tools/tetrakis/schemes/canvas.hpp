#pragma once

#include "../../../eval/io/png.hpp"
#include "../../../hier/base/vec.hpp"

#include <string>

namespace tetrakis::cli {

/// A white sheet for drawings of lines, dots and text, in pixels from the top left; drawn larger and averaged, so edges
/// are smooth.
class Canvas {
  public:
    Canvas(int width, int height);

    void line(Vec2d from, Vec2d to, double width, const Vec3f& colour);
    void disc(Vec2d centre, double radius, const Vec3f& colour);
    void circle(Vec2d centre, double radius, double width, const Vec3f& colour);
    void rectangle(Vec2d low, Vec2d high, const Vec3f& colour);
    /// ASCII, its top left corner there. @param height  of a capital letter
    void text(Vec2d at, double height, const std::string& text, const Vec3f& colour);
    /// The same, its middle there, on a white ground.
    void label(Vec2d middle, double height, const std::string& text, const Vec3f& colour);
    static double text_width(const std::string& text, double height);
    /// Another picture, its top left corner there.
    void paste(int x, int y, const Image& image);

    Image image() const;

  private:
    template <class Inside>
    void fill(Vec2d low, Vec2d high, const Vec3f& colour, Inside&& inside);

    Image large_;
};

}  // namespace tetrakis::cli
