#include "obj_lines.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdlib>
#include <limits>

namespace tetrakis::detail {

namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }

std::string_view trimmed(std::string_view s) {
    while (!s.empty() && is_blank(s.front())) s.remove_prefix(1);
    while (!s.empty() && is_blank(s.back())) s.remove_suffix(1);
    return s;
}

// Length of the UTF-8 sequence at the start, or 0. Overlong forms and surrogates are no UTF-8.
std::size_t utf8_length(std::string_view s) {
    constexpr std::uint32_t k_least[] = {0, 0, 0x80, 0x800, 0x10000}, k_end = 0x110000;
    const auto lead = static_cast<unsigned char>(s[0]);
    if (lead < 0x80) return 1;
    const auto length = static_cast<std::size_t>(std::countl_one(lead));
    if (length < 2 || length > 4 || length > s.size()) return 0;
    std::uint32_t code = lead & (0x7Fu >> length);
    for (const char c : s.substr(1, length - 1)) {
        if ((c & 0xC0) != 0x80) return 0;
        code = code << 6 | (c & 0x3Fu);
    }
    return code < k_least[length] || code >= k_end || (code >= 0xD800 && code < 0xE000) ? 0 : length;
}

}  // namespace

ObjLines::ObjLines(std::string_view text) : rest_(text) {
    constexpr std::string_view k_byte_order_mark = "\xEF\xBB\xBF";
    if (rest_.starts_with(k_byte_order_mark)) rest_.remove_prefix(k_byte_order_mark.size());
}

std::string_view ObjLines::physical_line() {
    ++number_;
    const auto end = std::find_if(rest_.begin(), rest_.end(), [](char c) { return c == '\n' || c == '\r'; });
    const std::string_view line(rest_.begin(), end);
    rest_.remove_prefix(line.size());
    rest_.remove_prefix(rest_.starts_with("\r\n") ? 2 : std::min<std::size_t>(rest_.size(), 1));
    return line;
}

bool ObjLines::next(ObjLine& line) {
    if (rest_.empty()) return false;
    line.text = physical_line();
    line.number = number_;
    if (line.text.empty() || line.text.back() != '\\' || trimmed(line.text).starts_with('#')) return true;
    joined_.clear();
    std::string_view part = line.text;
    while (!part.empty() && part.back() == '\\') {
        joined_.append(part.substr(0, part.size() - 1)).push_back(' ');
        part = rest_.empty() ? std::string_view() : physical_line();
    }
    joined_.append(part);
    line.text = joined_;
    return true;
}

std::string_view ObjWords::next() {
    std::size_t i = 0;
    while (i < rest_.size() && is_blank(rest_[i])) ++i;
    std::size_t end = i;
    while (end < rest_.size() && !is_blank(rest_[end])) ++end;
    const std::string_view word = rest_.substr(i, end - i);
    if (!word.empty() && word.front() == '#') {
        rest_ = {};
        return {};
    }
    rest_.remove_prefix(end);
    return word;
}

std::string_view ObjWords::remainder() const { return trimmed(rest_); }

std::optional<double> obj_number(std::string_view word) {
    const std::string_view digits = word.starts_with('+') ? word.substr(1) : word;
    if (digits.empty() || (digits.size() < word.size() && (digits[0] == '-' || digits[0] == '+'))) return {};
    double value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    const bool whole = end == digits.data() + digits.size();
    if (error == std::errc() && whole) return value;
    if (error == std::errc::result_out_of_range && whole) {
        // from_chars does not tell overflow from underflow: strtod gives infinity or the nearest number.
        return std::strtod(std::string(digits).c_str(), nullptr);
    }
    const std::size_t hash = digits.find('#');  // 1.#INF, -1.#IND, 1.#QNAN
    if (hash != std::string_view::npos && digits.substr(0, hash).find_first_not_of("-1.") == std::string_view::npos) {
        const std::string_view kind = digits.substr(hash + 1);
        if (kind.starts_with("INF") || kind.starts_with("IND") || kind.starts_with("QNAN") || kind.starts_with("SNAN"))
            return std::numeric_limits<double>::quiet_NaN();
    }
    return {};
}

std::optional<std::int64_t> obj_integer(std::string_view word) {
    constexpr std::int64_t k_clamp = std::int64_t{1} << 62;
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (end != word.data() + word.size() || error == std::errc::invalid_argument) return {};
    if (error == std::errc::result_out_of_range) return word.front() == '-' ? -k_clamp : k_clamp;
    return std::clamp(value, -k_clamp, k_clamp);
}

std::string obj_name(std::string_view bytes) {
    bool valid = true;
    for (std::size_t i = 0; i < bytes.size() && valid;) {
        const std::size_t length = utf8_length(bytes.substr(i));
        valid = length != 0;
        i += length;
    }
    if (valid) return std::string(bytes);
    std::string name;
    for (const char c : bytes) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte < 0x80) {
            name.push_back(c);
        } else {
            name.push_back(static_cast<char>(0xC0u | byte >> 6));
            name.push_back(static_cast<char>(0x80u | (byte & 0x3Fu)));
        }
    }
    return name;
}

std::string obj_quote(std::string_view word) {
    constexpr std::size_t k_shown = 24;
    std::string text = "'";
    for (const char c : word.substr(0, k_shown)) text.push_back(c >= ' ' && c <= '~' ? c : '?');
    return text + (word.size() > k_shown ? "...'" : "'");
}

}  // namespace tetrakis::detail
