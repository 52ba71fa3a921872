#include "obj_prescan.hpp"

#include "obj_lines.hpp"
#include "obj_tags.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>
#include <optional>
#include <string>
#include <unordered_map>

namespace tetrakis::detail {

namespace {

// Most numbers on a `v` line: position, weight and colour.
constexpr std::size_t k_most_numbers = 8;
// Different unknown keywords that get a warning of their own.
constexpr std::size_t k_named_keywords = 8;
// Magnitudes that tinyobjloader's decimal reader handles without overflow or loss on the way.
constexpr double k_plain_smallest = 1e-30, k_plain_largest = 1e30;

// Lines that say nothing about the surface and are passed over in silence.
bool is_decoration(std::string_view keyword) {
    constexpr std::array<std::string_view, 11> k_words = {
        "mtllib", "s", "lod", "bevel", "c_interp", "d_interp", "shadow_obj", "trace_obj", "usemap", "maplib", "mg"};
    return std::ranges::find(k_words, keyword) != k_words.end();
}

// Numbers names in order of first use.
class NameTable {
  public:
    std::uint32_t number(const std::string& name, std::vector<std::string>& names) {
        const auto [it, added] = numbers_.try_emplace(name, static_cast<std::uint32_t>(names.size()));
        if (added) names.push_back(name);
        return it->second;
    }

  private:
    std::unordered_map<std::string, std::uint32_t> numbers_;
};

// The name in force, looked up once per change and only if a face uses it.
struct CurrentName {
    std::string name;
    std::uint32_t number = VertexId::none;
    bool given = false;  ///< the file has such a line at all
    NameTable table;

    void set(std::string_view bytes) {
        name = obj_name(bytes);
        number = VertexId::none;
        given = true;
    }
    std::uint32_t use(std::vector<std::string>& names) {
        if (number == VertexId::none) number = table.number(name, names);
        return number;
    }
};

class Prescan {
  public:
    Prescan(std::string_view text, std::string source) : text_(text) {
        scan_.data.source = std::move(source);
        scan_.data.first_number = 1;
    }

    ObjScan run() {
        scan_.normalised.reserve(text_.size() / 2);
        if (const std::size_t zero = text_.find('\0'); zero != std::string_view::npos) {
            line_ = 1 + static_cast<std::uint64_t>(std::count(text_.begin(), text_.begin() + zero, '\n'));
            fail("a zero byte: this is no text file; give an OBJ file");
        }
        ObjLines lines(text_);
        ObjLine line;
        while (lines.next(line)) {
            line_ = line.number;
            ObjWords words(line.text);
            if (const std::string_view keyword = words.next(); !keyword.empty()) read_line(keyword, words);
        }
        finish();
        return std::move(scan_);
    }

  private:
    [[noreturn]] void fail(const std::string& text) const {
        throw Error(ErrorCode::invalid_input, text, scan_.data.source, line_);
    }

    void read_line(std::string_view keyword, ObjWords& words) {
        if (keyword == "v") return vertex(words);
        if (keyword == "f") return face(words);
        if (keyword == "vt") return uv(words);
        if (keyword == "vn") return normal(words);
        if (keyword == "t") {
            const std::string_view rest = words.remainder();
            if (!read_obj_tag(words, line_, scan_.data)) ignore("t " + std::string(rest.substr(0, rest.find(' '))));
            return;
        }
        if (keyword == "usemtl") return material_.set(words.remainder());
        if (keyword == "g" || keyword == "o") return group_.set(words.remainder());
        if (!is_decoration(keyword)) ignore(std::string(keyword));
    }

    void ignore(const std::string& keyword) {
        const auto [it, added] = ignored_.try_emplace(keyword, ignored_list_.size());
        if (added) ignored_list_.push_back({keyword, line_, 0});
        ++ignored_list_[it->second].count;
    }

    struct Numbers {
        std::array<double, k_most_numbers> value;
        std::size_t count = 0;
        bool plain = true;  ///< tinyobjloader reads each of them right
    };

    static bool is_plain(std::string_view word, double value) {
        const std::size_t digit = word.front() == '-' ? 1 : 0;
        const double size = std::abs(value);
        // word[digit]: the word is a number, so that a minus sign is followed by something.
        return word[digit] >= '0' && word[digit] <= '9' &&
               (value == 0 || (size >= k_plain_smallest && size <= k_plain_largest));
    }

    Numbers numbers(ObjWords& words, const char* what, std::size_t least, std::size_t most) {
        Numbers result;
        for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
            const auto value = obj_number(word);
            if (!value)
                fail(fmt::format("{} in {} is no number; {}", obj_quote(word), what,
                                 word.find(',') != std::string_view::npos ? "write a decimal point, not a comma"
                                                                          : "correct the line"));
            if (result.count == most) fail(fmt::format("{} has more than {} numbers; correct the line", what, most));
            result.value[result.count++] = *value;
            result.plain &= is_plain(word, *value);
        }
        if (result.count < least)
            fail(fmt::format("{} has {} coordinate{}, it needs {}; complete the line", what, result.count,
                             result.count == 1 ? "" : "s", least));
        return result;
    }

    void vertex(ObjWords& words) {
        const Numbers n = numbers(words, "the vertex", 3, k_most_numbers);
        // x y z w, or with a colour behind: 3 + 1, 3 + 1 + 3.
        if ((n.count == 4 || n.count == 5 || n.count >= 7) && n.value[3] != 1.0 && weighted_++ == 0)
            first_weight_ = line_;
        if ((n.count == 5 || n.count == 8) && surplus_++ == 0) first_surplus_ = line_;
        if (n.count >= 6 && coloured_++ == 0) first_colour_ = line_;
        scan_.data.positions.emplace_back(n.value[0], n.value[1], n.value[2]);
        scan_.data.vertex_lines.push_back(line_);
        if (scan_.data.positions.size() >= ObjScan::k_no_element) fail("more than 2^31 vertices; split the model");
    }

    void append_numbers(const char* keyword, std::string_view raw, bool plain, std::string_view instead) {
        scan_.normalised.append(keyword).append(plain ? raw : instead).push_back('\n');
    }

    void uv(ObjWords& words) {
        const std::string_view raw = words.remainder();
        const Numbers n = numbers(words, "the texture coordinate", 1, 3);
        if (!n.plain) scan_.uvs.emplace_back(scan_.uv_count, Vec2d(n.value[0], n.count > 1 ? n.value[1] : 0.0));
        scan_.data.uv_lines.push_back(line_);
        append_numbers("vt ", raw, n.plain, "0 0");
        if (++scan_.uv_count == ObjScan::k_no_element) fail("more than 2^31 texture coordinates; split the model");
    }

    void normal(ObjWords& words) {
        const std::string_view raw = words.remainder();
        const Numbers n = numbers(words, "the normal", 3, 3);
        if (!n.plain) scan_.normals.emplace_back(scan_.normal_count, Vec3d(n.value[0], n.value[1], n.value[2]));
        append_numbers("vn ", raw, n.plain, "0 0 0");
        if (++scan_.normal_count == ObjScan::k_no_element) fail("more than 2^31 normals; split the model");
    }

    // One index of a corner as tinyobjloader shall see it. Negative ones count back from the last element so far.
    std::int64_t index(std::string_view digits, std::string_view word, const char* what, std::size_t so_far) {
        const auto value = obj_integer(digits);
        if (!value) fail(fmt::format("{} is no face corner; write it as v, v/vt, v//vn or v/vt/vn", obj_quote(word)));
        if (*value == 0)
            fail(fmt::format("{} in a face has {} number 0; OBJ counts from 1 (or back from -1); correct the number",
                             obj_quote(word), what));
        const std::int64_t i = *value > 0 ? *value : static_cast<std::int64_t>(so_far) + 1 + *value;
        return i < 1 || i > ObjScan::k_no_element ? ObjScan::k_no_element : i;
    }

    void face(ObjWords& words) {
        std::uint32_t size = 0;
        std::string& out = scan_.normalised;
        out.append("f");
        for (std::string_view word = words.next(); !word.empty(); word = words.next(), ++size) {
            const std::size_t slash = word.find('/');
            const std::string_view v = word.substr(0, slash);
            std::string_view vt, vn;
            if (slash != std::string_view::npos) {
                const std::size_t second = word.find('/', slash + 1);
                vt = word.substr(slash + 1, second == std::string_view::npos ? second : second - slash - 1);
                if (second != std::string_view::npos) vn = word.substr(second + 1);
            }
            std::array<std::int64_t, 3> i = {index(v, word, "vertex", scan_.data.positions.size()), 0, 0};
            if (!vt.empty()) i[1] = index(vt, word, "texture coordinate", scan_.uv_count);
            if (!vn.empty()) i[2] = index(vn, word, "normal", scan_.normal_count);
            append_corner(i);
        }
        if (size == 0)
            out.pop_back();  // tinyobjloader does not report it; face_sizes does
        else
            out.push_back('\n');
        corner_count_ += size;
        if (corner_count_ >= ObjScan::k_no_element) fail("more than 2^31 face corners; split the model");
        scan_.face_sizes.push_back(size);
        scan_.data.face_lines.push_back(line_);
        scan_.data.face_material.push_back(material_.use(scan_.data.materials));
        scan_.data.face_group.push_back(group_.use(scan_.data.groups));
    }

    void append_corner(const std::array<std::int64_t, 3>& i) {
        constexpr int k_digits = 20;  // of any 64-bit number
        std::array<char, 3 * (k_digits + 1)> buffer;
        char* p = buffer.data();
        *p++ = ' ';
        const auto put = [&](std::int64_t value) { p = std::to_chars(p, p + k_digits, value).ptr; };
        put(i[0]);
        if (i[1] != 0 || i[2] != 0) {
            *p++ = '/';
            if (i[1] != 0) put(i[1]);
            if (i[2] != 0) {
                *p++ = '/';
                put(i[2]);
            }
        }
        scan_.normalised.append(buffer.data(), p);
    }

    void finish() {
        ControlMeshData& data = scan_.data;
        if (!material_.given) {
            data.face_material.clear();
            data.materials.clear();
        }
        if (!group_.given) {
            data.face_group.clear();
            data.groups.clear();
        }
        if (weighted_ != 0)
            data.warnings.push_back(
                fmt::format("{} vertices have a weight other than 1 (the first is on line {}); "
                            "weights are ignored",
                            weighted_, first_weight_));
        if (surplus_ != 0)
            data.warnings.push_back(
                fmt::format("{} vertices have 5 or 8 numbers, one more than x y z with a weight or a colour or both "
                            "(the first is on "
                            "line {}); it is ignored",
                            surplus_, first_surplus_));
        if (coloured_ != 0)
            data.warnings.push_back(
                fmt::format("{}: vertex colours are not carried over ({} vertices have one, the "
                            "first is on line {})",
                            data.source, coloured_, first_colour_));
        std::uint64_t others = 0;
        for (std::size_t i = 0; i < ignored_list_.size(); ++i) {
            const Ignored& ignored = ignored_list_[i];
            if (i < k_named_keywords)
                data.warnings.push_back(fmt::format("{} line{} of kind {} ignored (the first is line {})",
                                                    ignored.count, ignored.count == 1 ? "" : "s",
                                                    obj_quote(ignored.keyword), ignored.line));
            else
                others += ignored.count;
        }
        if (others != 0) data.warnings.push_back(fmt::format("{} lines of other unknown kinds ignored", others));
    }

    struct Ignored {
        std::string keyword;
        std::uint64_t line, count;
    };

    std::string_view text_;
    ObjScan scan_;
    std::uint64_t line_ = 0;
    CurrentName material_, group_;
    std::uint64_t corner_count_ = 0, weighted_ = 0, first_weight_ = 0, surplus_ = 0, first_surplus_ = 0;
    std::uint64_t coloured_ = 0, first_colour_ = 0;
    std::unordered_map<std::string, std::size_t> ignored_;
    std::vector<Ignored> ignored_list_;
};

}  // namespace

ObjScan prescan_obj(std::string_view text, std::string source) { return Prescan(text, std::move(source)).run(); }

}  // namespace tetrakis::detail
