#pragma once

#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace tetrakis {

/// Why a call failed.
enum class ErrorCode { invalid_input = 1, io, unsupported, memory_limit, cancelled };

/// The library's exception type; only what schemes/ computes by itself throws std::invalid_argument, as said there.
/// `what()` is the whole message, `file:line: text` where a file is known.
class Error : public std::runtime_error {
  public:
    Error(ErrorCode code, const std::string& text) : std::runtime_error(text), code_(code) {}
    /// @param line  1-based line of `file`; 0 when no single line is to blame
    Error(ErrorCode code, const std::string& text, const std::filesystem::path& file, std::uint64_t line = 0);

    ErrorCode code() const { return code_; }
    const std::filesystem::path& file() const { return file_; }
    std::uint64_t line() const { return line_; }

  private:
    ErrorCode code_;
    std::filesystem::path file_;
    std::uint64_t line_ = 0;
};

}  // namespace tetrakis
