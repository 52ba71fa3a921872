#include "console.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <unordered_set>

namespace tetrakis::cli {

void print_error(std::string_view text) { fmt::print(stderr, "tetrakis: error: {}\n", text); }
void print_warning(std::string_view text) { fmt::print(stderr, "tetrakis: warning: {}\n", text); }

void print_warnings(const std::vector<std::string>& warnings) {
    // A broken model can have thousands; the report has them all.
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

}  // namespace tetrakis::cli
