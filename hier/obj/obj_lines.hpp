#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace tetrakis::detail {

/// One logical line of an OBJ file, without its line end; lines continued by a backslash at the end are joined.
struct ObjLine {
    std::string_view text;
    std::uint64_t number = 0;  ///< number of its first physical line, from 1
};

/// Cuts a text into logical lines. Line ends may be LF, CR LF or CR; the last line may have none. A byte order mark at
/// the start is skipped.
class ObjLines {
  public:
    explicit ObjLines(std::string_view text);
    /// Gets the next line; false at the end. The view is valid until the next call.
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
    /// The next word; empty at the end.
    std::string_view next();
    /// The rest of the line, trimmed; '#' is not special, since names may contain it.
    std::string_view remainder() const;

  private:
    std::string_view rest_;
};

/// A decimal number, correctly rounded. Spellings of NaN and infinity (MSVC's, too) give one of these, and overflow
/// gives infinity. Empty if the word is no number.
std::optional<double> obj_number(std::string_view word);

/// A decimal integer, clamped to +-2^62; empty if the word is none.
std::optional<std::int64_t> obj_integer(std::string_view word);

/// The name in UTF-8: bytes that are not UTF-8 are read as Latin-1.
std::string obj_name(std::string_view bytes);

/// A word for messages: short, printable, in quotes.
std::string obj_quote(std::string_view word);

}  // namespace tetrakis::detail
