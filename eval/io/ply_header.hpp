#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace tetrakis::detail {

enum class PlyType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

struct PlyProperty {
    std::string name;
    PlyType type = PlyType::float32;
    PlyType count_type = PlyType::uint8;
    bool is_list = false;
};

struct PlyElement {
    std::string name;
    std::uint64_t count = 0;
    std::vector<PlyProperty> properties;
};

struct PlyHeader {
    enum class Format { ascii, little_endian, big_endian } format = Format::ascii;
    std::vector<PlyElement> elements;
    std::vector<std::string> materials, groups;  ///< from comments `material <number> <name>`, as our writer puts them
    std::size_t size = 0;                        ///< bytes up to the data
    std::uint64_t lines = 0;
};

/// @throws Error invalid_input with the line
PlyHeader parse_ply_header(std::string_view bytes, const std::filesystem::path& path);

/// The numbers after the header, one at a time, in any of the three formats.
class PlyValues {
  public:
    PlyValues(std::string_view bytes, const PlyHeader& header, const std::filesystem::path& path);

    /// @throws Error invalid_input: data exhausted or not a number
    double next(PlyType type);
    /// A list's count, checked against what is left of the file.
    std::uint64_t list_count(const PlyProperty& property);
    /// Checks that an element's count is possible in what is left, before anything is allocated for it.
    void check_room(const PlyElement& element) const;
    /// Throws invalid_input with the place: line of a text file, offset of a binary one.
    [[noreturn]] void reject(const std::string& text) const;

  private:
    double next_word();
    std::uint64_t least_bytes(const PlyProperty& property) const;

    std::string_view bytes_;
    std::size_t at_;
    PlyHeader::Format format_;
    std::uint64_t line_;
    const std::filesystem::path& path_;
};

}  // namespace tetrakis::detail
