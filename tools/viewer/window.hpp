#pragma once

#include "../../eval/io/png.hpp"

#include <functional>

struct GLFWwindow;

namespace tetrakis::viewer {

/// The window and its OpenGL 3.3 context, which is current as long as it lives; one at a time.
class Window {
  public:
    enum class Shown { yes, no };
    /// @throws Error  unsupported: no display, or no OpenGL 3.3 on it
    Window(int width, int height, Shown shown);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    operator GLFWwindow*() const { return window_; }

  private:
    GLFWwindow* window_ = nullptr;
};

/// What `draw` draws, in a picture of its own: no window hides parts of it. Needs a current context.
Image picture_of(int width, int height, const std::function<void()>& draw);

}  // namespace tetrakis::viewer
