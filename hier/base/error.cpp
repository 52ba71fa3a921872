#include "error.hpp"

namespace tetrakis {

namespace {
std::string located(const std::string& text, const std::filesystem::path& file, std::uint64_t line) {
    if (file.empty()) return text;
    return line == 0 ? file.string() + ": " + text : file.string() + ":" + std::to_string(line) + ": " + text;
}
}  // namespace

Error::Error(ErrorCode code, const std::string& text, const std::filesystem::path& file, std::uint64_t line)
    : std::runtime_error(located(text, file, line)), code_(code), file_(file), line_(line) {}

}  // namespace tetrakis
