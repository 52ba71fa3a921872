#include "console.hpp"

#include "commands.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <initializer_list>
#include <iostream>
#include <string>
#include <unordered_set>

namespace tetrakis::cli {

void print_error(std::string_view text) { fmt::print(stderr, "tetrakis: error: {}\n", text); }
void print_warning(std::string_view text) { fmt::print(stderr, "tetrakis: warning: {}\n", text); }

void print_warnings(const std::vector<std::string>& warnings) {
    // A broken model can have thousands of warnings; the report lists all of them.
    constexpr std::size_t k_most = 20;
    std::unordered_set<std::string_view> seen;
    std::size_t hidden = 0;
    for (const std::string& warning : warnings) {
        if (!seen.insert(warning).second) continue;
        if (seen.size() <= k_most)
            print_warning(warning);
        else
            ++hidden;
    }
    if (hidden > 0) print_warning(fmt::format("... and {} more", hidden));
}

void Table::print() const {
    std::size_t width = 0;
    for (const auto& [name, value] : rows_) width = std::max(width, name.size());
    for (const auto& [name, value] : rows_) fmt::print("{:<{}}  {}\n", name, width, value);
}

bool flush_output() {
    std::cout.flush();
    return std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && std::cout.good();
}

std::string format_count(unsigned long long n) {
    std::string digits = std::to_string(n);
    for (std::size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, 1, ' ');
    return digits;
}

std::string format_bytes(unsigned long long bytes) {
    const double b = static_cast<double>(bytes);
    if (b < 1e3) return fmt::format("{} B", bytes);
    if (b < 1e6) return fmt::format("{:.3g} kB", b / 1e3);
    if (b < 1e9) return fmt::format("{:.3g} MB", b / 1e6);
    return fmt::format("{:.3g} GB", b / 1e9);
}

std::string format_seconds(double seconds) {
    return seconds < 1 ? fmt::format("{:.0f} ms", seconds * 1e3) : fmt::format("{:.2f} s", seconds);
}

std::string format_length(double length) { return fmt::format("{:.4g}", length); }

namespace {

int terminal_width() {
    winsize size{};
    constexpr int k_usual_width = 80;
    return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : k_usual_width;
}

}  // namespace

// As if just drawn: the first bar appears after a while, so quick work shows none.
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

namespace {

volatile std::sig_atomic_t interrupt_flag = 0, end_at_once = 0;

extern "C" void take_interrupt(int) {
    if (end_at_once != 0 || interrupt_flag != 0) _exit(static_cast<int>(ExitCode::cancelled));
    interrupt_flag = 1;
}

}  // namespace

void catch_interrupts() {
    end_at_once = 0;
    std::signal(SIGXFSZ, SIG_IGN);  // writing to a file that grows too large then fails with an error
    for (const int signal : {SIGINT, SIGTERM}) {
        struct sigaction action = {};
        // A shell without job control starts background programs with SIGINT ignored: keep that.
        if (sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_IGN) continue;
        action = {};
        action.sa_handler = take_interrupt;
        action.sa_flags = SA_RESTART;
        sigemptyset(&action.sa_mask);
        sigaction(signal, &action, nullptr);
    }
}

void let_interrupts_end() { end_at_once = 1; }

bool interrupted() noexcept { return interrupt_flag != 0; }

}  // namespace tetrakis::cli
