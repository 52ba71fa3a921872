#pragma once

#include "../../eval/io/png.hpp"

#include <functional>

struct GLFWwindow;

namespace tetrakis::viewer {

/// A window with an OpenGL 3.3 context, which is current as long as the window lives. There may be one at a time.
class Window {
  public:
    enum class Shown { yes, no };
    /// @throws Error  unsupported: there is no display, or it has no OpenGL 3.3
    Window(int width, int height, Shown shown);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    operator GLFWwindow*() const { return window_; }

  private:
    GLFWwindow* window_ = nullptr;
};

/// Renders what `draw` draws to an image, of which other windows hide no part. Needs a current context.
Image picture_of(int width, int height, const std::function<void()>& draw);

}  // namespace tetrakis::viewer
