#include "progress.hpp"

#include "interrupt.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <string>

#include <sys/ioctl.h>
#include <unistd.h>

namespace tetrakis::cli {
namespace {

int terminal_width() {
    winsize size{};
    constexpr int k_usual_width = 80;
    return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : k_usual_width;
}

}  // namespace

// The first bar comes a while after the start: what is quick needs none.
Progress::Progress() : terminal_(isatty(STDERR_FILENO) != 0), last_drawn_(std::chrono::steady_clock::now()) {}

bool Progress::update(std::string_view stage, double fraction) {
    if (interrupted()) return false;
    if (!terminal_) return true;
    constexpr auto k_between_drawings = std::chrono::milliseconds(100);
    const auto now = std::chrono::steady_clock::now();
    if (now - last_drawn_ < k_between_drawings) return true;
    last_drawn_ = now;

    const double part = std::clamp(fraction, 0.0, 1.0);  // NaN stays NaN and draws an empty bar
    constexpr int k_around_bar = 26, k_longest_bar = 40;
    const int length = std::clamp(terminal_width() - k_around_bar, 0, k_longest_bar);
    const int full = part > 0 ? static_cast<int>(part * length) : 0;
    fmt::print(stderr, "\r\033[K{:<10.14} [{}{}] {:3.0f} %", stage, std::string(static_cast<std::size_t>(full), '#'),
               std::string(static_cast<std::size_t>(length - full), ' '), part > 0 ? part * 100 : 0.0);
    std::fflush(stderr);
    drawn_ = true;
    return true;
}

void Progress::clear() {
    if (drawn_) fmt::print(stderr, "\r\033[K");
    drawn_ = false;
}

void stop_if_interrupted() {
    if (interrupted()) throw Error(ErrorCode::cancelled, "cancelled");
}

}  // namespace tetrakis::cli
