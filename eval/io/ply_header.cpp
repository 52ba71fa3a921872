#include "ply_header.hpp"

#include "mesh_codecs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>

namespace tetrakis::detail {

namespace {

std::vector<std::string_view> words_of(std::string_view line) {
    std::vector<std::string_view> words;
    for (std::size_t i = 0; i < line.size();) {
        if (line[i] == ' ' || line[i] == '\t') {
            ++i;
            continue;
        }
        const std::size_t end = std::min(line.find_first_of(" \t", i), line.size());
        words.push_back(line.substr(i, end - i));
        i = end;
    }
    return words;
}

std::optional<PlyType> type_of(std::string_view word) {
    constexpr std::pair<std::string_view, PlyType> k_types[] = {
        {"char", PlyType::int8},      {"int8", PlyType::int8},       {"uchar", PlyType::uint8},
        {"uint8", PlyType::uint8},    {"short", PlyType::int16},     {"int16", PlyType::int16},
        {"ushort", PlyType::uint16},  {"uint16", PlyType::uint16},   {"int", PlyType::int32},
        {"int32", PlyType::int32},    {"uint", PlyType::uint32},     {"uint32", PlyType::uint32},
        {"float", PlyType::float32},  {"float32", PlyType::float32}, {"double", PlyType::float64},
        {"float64", PlyType::float64}};
    for (const auto& [name, type] : k_types)
        if (word == name) return type;
    return std::nullopt;
}

std::size_t size_of(PlyType type) {
    constexpr std::size_t k_sizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
    return k_sizes[static_cast<int>(type)];
}

template <class T>
double read_as(const char* bytes, bool swap) {
    char ordered[sizeof(T)];
    std::memcpy(ordered, bytes, sizeof(T));
    if (swap) std::reverse(ordered, ordered + sizeof(T));
    T value;
    std::memcpy(&value, ordered, sizeof(T));
    return static_cast<double>(value);
}

// `comment material 3 brass` gives names[3] = "brass", as long as the numbers come in order.
void take_name(std::string_view line, std::size_t word_start, std::string_view number_word,
               std::vector<std::string>& names) {
    long long number = -1;
    std::string_view rest = number_word;
    if (!take_integer(rest, number) || number != static_cast<long long>(names.size())) return;
    const std::size_t start = line.find_first_not_of(' ', word_start + number_word.size());
    names.emplace_back(start == std::string_view::npos ? std::string_view{} : line.substr(start));
}

class HeaderParser {
  public:
    HeaderParser(std::string_view bytes, const std::filesystem::path& path) : bytes_(bytes), path_(path) {}

    PlyHeader run() {
        if (next_line() != "ply") reject("this is no PLY file: its first line is not 'ply'");
        bool has_format = false;
        for (;;) {
            if (at_ >= bytes_.size()) reject("the header has no end_header; the file may be cut short");
            const std::string_view line = next_line();
            const std::vector<std::string_view> words = words_of(line);
            if (words.empty() || words[0] == "obj_info") continue;
            if (words[0] == "comment")
                comment(line, words);
            else if (words[0] == "format")
                has_format = format(words);
            else if (words[0] == "element")
                element(words);
            else if (words[0] == "property")
                property(words);
            else if (words[0] == "end_header")
                break;
            else
                reject(fmt::format("unknown word '{:.40}' in the header", words[0]));
        }
        if (!ended_) reject("the header ends with the file; the file may be cut short");
        if (!has_format) reject("the header has no format line");
        header_.size = at_;
        return std::move(header_);
    }

  private:
    [[noreturn]] void reject(const std::string& text) const {
        throw Error(ErrorCode::invalid_input, text, path_, header_.lines);
    }

    std::string_view next_line() {
        ++header_.lines;
        const std::size_t end = bytes_.find('\n', at_);
        ended_ = end != std::string_view::npos;
        std::string_view line = bytes_.substr(at_, ended_ ? end - at_ : std::string_view::npos);
        at_ = ended_ ? end + 1 : bytes_.size();
        if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
        return line;
    }

    void comment(std::string_view line, const std::vector<std::string_view>& words) {
        if (words.size() < 3) return;
        const auto start = static_cast<std::size_t>(words[2].data() - line.data());
        if (words[1] == "material") take_name(line, start, words[2], header_.materials);
        if (words[1] == "group") take_name(line, start, words[2], header_.groups);
    }

    bool format(const std::vector<std::string_view>& words) {
        const std::string_view name = words.size() > 1 ? words[1] : std::string_view{};
        if (name == "ascii")
            header_.format = PlyHeader::Format::ascii;
        else if (name == "binary_little_endian")
            header_.format = PlyHeader::Format::little_endian;
        else if (name == "binary_big_endian")
            header_.format = PlyHeader::Format::big_endian;
        else
            reject("the format is none of ascii, binary_little_endian, binary_big_endian");
        return true;
    }

    void element(const std::vector<std::string_view>& words) {
        long long count = -1;
        std::string_view number = words.size() == 3 ? words[2] : std::string_view{};
        if (!take_integer(number, count) || !number.empty() || count < 0)
            reject("an element line has a name and a count");
        for (const PlyElement& other : header_.elements)
            if (other.name == words[1]) reject(fmt::format("element '{:.40}' is declared twice", words[1]));
        header_.elements.push_back({std::string(words[1]), static_cast<std::uint64_t>(count), {}});
    }

    void property(const std::vector<std::string_view>& words) {
        if (header_.elements.empty()) reject("a property comes before the first element");
        PlyProperty property;
        property.is_list = words.size() > 1 && words[1] == "list";
        const std::size_t type_word = property.is_list ? 3 : 1;
        if (words.size() != type_word + 2) reject("a property line has a type and a name");
        const auto type = type_of(words[type_word]);
        const auto count_type = property.is_list ? type_of(words[2]) : PlyType::uint8;
        if (!type || !count_type) reject("a property has an unknown type");
        if (*count_type == PlyType::float32 || *count_type == PlyType::float64)
            reject("the count of a list is not an integer type");
        property.type = *type;
        property.count_type = *count_type;
        property.name = words.back();
        header_.elements.back().properties.push_back(std::move(property));
    }

    std::string_view bytes_;
    const std::filesystem::path& path_;
    std::size_t at_ = 0;
    bool ended_ = false;
    PlyHeader header_;
};

}  // namespace

PlyHeader parse_ply_header(std::string_view bytes, const std::filesystem::path& path) {
    return HeaderParser(bytes, path).run();
}

PlyValues::PlyValues(std::string_view bytes, const PlyHeader& header, const std::filesystem::path& path)
    : bytes_(bytes), at_(header.size), format_(header.format), line_(header.lines + 1), path_(path) {}

void PlyValues::reject(const std::string& text) const {
    if (format_ == PlyHeader::Format::ascii) throw Error(ErrorCode::invalid_input, text, path_, line_);
    throw Error(ErrorCode::invalid_input, fmt::format("at byte {}: {}", at_, text), path_);
}

double PlyValues::next(PlyType type) {
    if (format_ == PlyHeader::Format::ascii) return next_word();
    const std::size_t size = size_of(type);
    if (bytes_.size() - at_ < size) reject("the file ends in the middle of its data");
    const char* here = bytes_.data() + at_;
    at_ += size;
    const bool swap = (format_ == PlyHeader::Format::big_endian) == (std::endian::native == std::endian::little);
    switch (type) {
        case PlyType::int8:
            return read_as<std::int8_t>(here, swap);
        case PlyType::uint8:
            return read_as<std::uint8_t>(here, swap);
        case PlyType::int16:
            return read_as<std::int16_t>(here, swap);
        case PlyType::uint16:
            return read_as<std::uint16_t>(here, swap);
        case PlyType::int32:
            return read_as<std::int32_t>(here, swap);
        case PlyType::uint32:
            return read_as<std::uint32_t>(here, swap);
        case PlyType::float32:
            return read_as<float>(here, swap);
        case PlyType::float64:
            return read_as<double>(here, swap);
    }
    return 0;
}

double PlyValues::next_word() {
    const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; };
    for (; at_ < bytes_.size() && blank(bytes_[at_]); ++at_)
        if (bytes_[at_] == '\n') ++line_;
    if (at_ >= bytes_.size()) reject("the file ends in the middle of its data");
    std::string_view rest = bytes_.substr(at_);
    double value = 0;
    if (!take_number(rest, value) || (!rest.empty() && !blank(rest.front()))) reject("this is not a number");
    at_ = bytes_.size() - rest.size();
    return value;
}

std::uint64_t PlyValues::least_bytes(const PlyProperty& property) const {
    if (format_ == PlyHeader::Format::ascii) return 2;  // a digit and a blank
    return size_of(property.is_list ? property.count_type : property.type);
}

std::uint64_t PlyValues::list_count(const PlyProperty& property) {
    const double number = next(property.count_type);
    if (!(number >= 0) || number != std::floor(number)) reject("the count of a list is no count");
    const std::uint64_t each = format_ == PlyHeader::Format::ascii ? 2 : size_of(property.type);
    if (number * static_cast<double>(each) > static_cast<double>(bytes_.size() - at_ + 1))
        reject("a list is longer than the rest of the file");
    return static_cast<std::uint64_t>(number);
}

void PlyValues::check_room(const PlyElement& element) const {
    if (element.count == 0) return;
    if (element.properties.empty()) reject(fmt::format("element '{:.40}' has no properties", element.name));
    std::uint64_t each = 0;
    for (const PlyProperty& property : element.properties) each += least_bytes(property);
    // The last number of a text file needs no blank after it.
    if (element.count > (bytes_.size() - at_ + 1) / each)
        reject(fmt::format("{} elements '{:.40}' do not fit into the {} bytes left; the file may be cut short",
                           element.count, element.name, bytes_.size() - at_));
}

}  // namespace tetrakis::detail
