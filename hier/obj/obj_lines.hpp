#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace tetrakis::detail {

/// One logical line of an OBJ file: continuations (a backslash at the end) joined, no line end.
struct ObjLine {
    std::string_view text;
    std::uint64_t number = 0;  ///< of its first physical line, from 1
};

/// Cuts a text into logical lines. Line ends may be LF, CR LF or CR; the last one may be missing; a byte order mark at
/// the start is skipped.
class ObjLines {
  public:
    explicit ObjLines(std::string_view text);
    /// The view holds until the next call. False at the end.
    bool next(ObjLine& line);

  private:
    std::string_view physical_line();

    std::string_view rest_;
    std::uint64_t number_ = 0;
    std::string joined_;
};

/// Words between blanks; a word that starts with '#' ends the line.
class ObjWords {
  public:
    explicit ObjWords(std::string_view text) : rest_(text) {}
    /// Empty at the end.
    std::string_view next();
    /// What is left, trimmed; '#' is not special (names may hold it).
    std::string_view remainder() const;

  private:
    std::string_view rest_;
};

/// A decimal number, correctly rounded; NaN or infinity for the spellings of these (MSVC's too) and for overflow. Empty
/// if the word is no number.
std::optional<double> obj_number(std::string_view word);

/// A decimal integer, clamped to +-2^62; empty if the word is none.
std::optional<std::int64_t> obj_integer(std::string_view word);

/// The name in UTF-8: bytes that are no UTF-8 are taken as Latin-1.
std::string obj_name(std::string_view bytes);

/// A word as messages show it: short, printable, in quotes.
std::string obj_quote(std::string_view word);

}  // namespace tetrakis::detail
