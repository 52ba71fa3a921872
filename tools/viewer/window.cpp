#include "window.hpp"

#include "../../hier/base/error.hpp"

#include <epoxy/gl.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>

namespace tetrakis::viewer {
namespace {

constexpr int k_samples = 4;  // for each pixel: every OpenGL 3.3 supports as many

[[noreturn]] void refuse(const char* what) {
    const char* reason = nullptr;
    glfwGetError(&reason);
    throw Error(ErrorCode::unsupported, fmt::format("{}: {}", what, reason != nullptr ? reason : "no reason is known"));
}

}  // namespace

Window::Window(int width, int height, Shown shown) {
    if (glfwInit() == GLFW_FALSE) refuse("no window can be opened");
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_SAMPLES, k_samples);
    glfwWindowHint(GLFW_VISIBLE, shown == Shown::yes ? GLFW_TRUE : GLFW_FALSE);
    window_ = glfwCreateWindow(width, height, "tetrakis", nullptr, nullptr);
    if (window_ == nullptr) refuse("no window with OpenGL 3.3 can be opened");
    glfwMakeContextCurrent(window_);
    glfwSwapInterval(1);
}

Window::~Window() { glfwTerminate(); }

Image picture_of(int width, int height, const std::function<void()>& draw) {
    // A frame buffer with k_samples for each pixel, and one for their averages.
    std::array<unsigned, 2> frames{};
    std::array<unsigned, 3> stores{};
    glGenFramebuffers(2, frames.data());
    glGenRenderbuffers(3, stores.data());
    const auto attach = [&](GLenum place, unsigned store, GLenum format, int samples) {
        glBindRenderbuffer(GL_RENDERBUFFER, store);
        glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, format, width, height);
        glFramebufferRenderbuffer(GL_FRAMEBUFFER, place, GL_RENDERBUFFER, store);
    };
    glBindFramebuffer(GL_FRAMEBUFFER, frames[1]);
    attach(GL_COLOR_ATTACHMENT0, stores[2], GL_RGBA8, 0);
    glBindFramebuffer(GL_FRAMEBUFFER, frames[0]);
    attach(GL_COLOR_ATTACHMENT0, stores[0], GL_RGBA8, k_samples);
    attach(GL_DEPTH_ATTACHMENT, stores[1], GL_DEPTH_COMPONENT24, k_samples);
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
        throw Error(ErrorCode::unsupported, fmt::format("OpenGL draws no pictures of {} x {} pixels", width, height));
    draw();
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, frames[1]);
    glBlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    glBindFramebuffer(GL_FRAMEBUFFER, frames[1]);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    Image image{width, height, {}};
    const auto row = static_cast<std::ptrdiff_t>(3) * width;
    image.rgb.resize(static_cast<std::size_t>(row * height));
    glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, image.rgb.data());
    for (int y = 0; y < height / 2; ++y)  // OpenGL's rows start at the bottom
        std::swap_ranges(image.rgb.begin() + y * row, image.rgb.begin() + (y + 1) * row,
                         image.rgb.end() - (y + 1) * row);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glDeleteFramebuffers(2, frames.data());
    glDeleteRenderbuffers(3, stores.data());
    return image;
}

}  // namespace tetrakis::viewer
