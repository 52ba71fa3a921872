#include "obj_prescan.hpp"

#include "obj_lines.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

namespace tetrakis::detail {

namespace {

struct Tag {
    std::string_view name;
    std::vector<std::uint32_t> ints;  ///< VertexId::none where the file's number is negative or too large for any mesh
    std::vector<double> reals;
    std::vector<std::string_view> strings;
};

class TagReader {
  public:
    TagReader(ObjWords words, std::uint64_t line, ControlMeshData& data) : words_(words), line_(line), data_(data) {}

    bool run() {
        tag_.name = words_.next();
        if (tag_.name.empty()) fail("the tag has no name; write `t crease 2/1/0 a b sharpness` or the like");
        if (tag_.name == "crease") return read_arguments(), crease(), true;
        if (tag_.name == "corner") return read_arguments(), corner(), true;
        if (tag_.name == "cornerangle") return read_arguments(), corner_angle(), true;
        if (tag_.name == "hole") return read_arguments(), hole(), true;
        if (tag_.name == "interpolateboundary") {
            read_arguments();
            data_.boundary_rule = static_cast<BoundaryRule>(choice(2, "0 none, 1 edge and corner, 2 edge only"));
            return true;
        }
        if (tag_.name == "facevaryinginterpolateboundary") {
            read_arguments();
            data_.face_varying_rule = static_cast<FaceVaryingRule>(choice(
                5, "0 smooth, 1 corners only, 2 corners plus 1, 3 corners plus 2, 4 boundaries, 5 linear everywhere"));
            return true;
        }
        if (tag_.name == "creasemethod") return read_arguments(), crease_method(), true;
        return false;
    }

  private:
    [[noreturn]] void fail(const std::string& text) const {
        throw Error(ErrorCode::invalid_input, text, data_.source, line_);
    }

    // Counts are checked against the words that follow, never allocated from: a line may claim billions.
    void read_arguments() {
        const std::string_view counts = words_.next();
        std::array<std::int64_t, 3> count{};
        std::size_t at = 0;
        for (int i = 0; i < 3; ++i) {
            const std::size_t slash = i < 2 ? counts.find('/', at) : counts.size();
            const auto value =
                slash == std::string_view::npos ? std::nullopt : obj_integer(counts.substr(at, slash - at));
            if (!value || *value < 0)
                fail(fmt::format("tag '{}' needs its counts as ints/reals/strings, not {}", tag_.name,
                                 obj_quote(counts)));
            count[i] = *value;
            at = slash + 1;
        }
        const auto word = [&](const char* what) {
            const std::string_view next = words_.next();
            if (next.empty())
                fail(fmt::format("tag '{}' ends before the {} that its counts {} promise", tag_.name, what,
                                 obj_quote(counts)));
            return next;
        };
        for (std::int64_t i = 0; i < count[0]; ++i) {
            const std::string_view text = word("integers");
            const auto value = obj_integer(text);
            if (!value) fail(fmt::format("{} in tag '{}' is no integer", obj_quote(text), tag_.name));
            tag_.ints.push_back(*value < 0 || *value >= VertexId::none ? VertexId::none
                                                                       : static_cast<std::uint32_t>(*value));
        }
        for (std::int64_t i = 0; i < count[1]; ++i) {
            const std::string_view text = word("reals");
            const auto value = obj_number(text);
            if (!value) fail(fmt::format("{} in tag '{}' is no number", obj_quote(text), tag_.name));
            tag_.reals.push_back(*value);
        }
        for (std::int64_t i = 0; i < count[2]; ++i) tag_.strings.push_back(word("strings"));
        if (const std::string_view extra = words_.next(); !extra.empty())
            fail(fmt::format("tag '{}' goes on with {} after what its counts {} promise", tag_.name, obj_quote(extra),
                             obj_quote(counts)));
    }

    float sharpness(std::size_t i) const {
        const double value = tag_.reals[i];
        return value > std::numeric_limits<float>::max() ? k_sharpness_infinity : static_cast<float>(value);
    }

    void crease() {
        const std::size_t pairs = tag_.ints.size() / 2, reals = tag_.reals.size();
        if (pairs == 0 || tag_.ints.size() % 2 != 0)
            fail(fmt::format("a crease tag needs pairs of vertices, not {} numbers", tag_.ints.size()));
        if (reals != 1 && reals != pairs && reals != 2 * pairs)
            fail(fmt::format("a crease tag of {} edges needs 1 sharpness or one for each edge, not {}", pairs, reals));
        for (std::size_t i = 0; i < pairs; ++i)
            data_.creases.push_back({tag_.ints[2 * i], tag_.ints[2 * i + 1],
                                     sharpness(reals == 1       ? 0
                                               : reals == pairs ? i
                                                                : 2 * i),
                                     line_});
    }

    void corner() {
        const std::size_t count = tag_.ints.size(), reals = tag_.reals.size();
        if (count == 0) fail("a corner tag needs at least one vertex");
        if (reals != 1 && reals != count)
            fail(fmt::format("a corner tag of {} vertices needs 1 sharpness or one for each, not {}", count, reals));
        for (std::size_t i = 0; i < count; ++i)
            data_.corners.push_back({tag_.ints[i], sharpness(reals == 1 ? 0 : i), line_});
    }

    void corner_angle() {
        const std::size_t pairs = tag_.ints.size() / 2, reals = tag_.reals.size();
        if (pairs == 0 || tag_.ints.size() % 2 != 0)
            fail(fmt::format("a cornerangle tag needs pairs of a vertex and a face, not {} numbers", tag_.ints.size()));
        if (reals != 1 && reals != pairs)
            fail(fmt::format("a cornerangle tag of {} corners needs 1 angle or one for each, not {}", pairs, reals));
        for (std::size_t i = 0; i < pairs; ++i)
            data_.corner_angles.push_back({tag_.ints[2 * i], tag_.ints[2 * i + 1],
                                           tag_.reals[reals == 1 ? 0 : i] * std::numbers::pi / 180, line_});
    }

    void hole() {
        if (tag_.ints.empty()) fail("a hole tag needs at least one face");
        for (const std::uint32_t face : tag_.ints) {
            data_.holes.push_back(face);
            data_.hole_lines.push_back(line_);
        }
    }

    std::uint32_t choice(std::uint32_t last, const char* meaning) const {
        if (tag_.ints.size() != 1 || tag_.ints[0] > last)
            fail(fmt::format("tag '{}' needs one integer: {}", tag_.name, meaning));
        return tag_.ints[0];
    }

    void crease_method() {
        if (tag_.strings.size() == 1 && tag_.strings[0] == "chaikin")
            data_.crease_method = CreaseMethod::chaikin;
        else if (tag_.strings.size() == 1 && (tag_.strings[0] == "normal" || tag_.strings[0] == "uniform"))
            data_.crease_method = CreaseMethod::uniform;
        else
            fail("tag 'creasemethod' needs one word: normal or chaikin");
    }

    ObjWords words_;
    std::uint64_t line_;
    ControlMeshData& data_;
    Tag tag_;
};

}  // namespace

bool read_obj_tag(ObjWords words, std::uint64_t line, ControlMeshData& data) {
    return TagReader(words, line, data).run();
}

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
        result.plain = words.remainder().find_first_of("\v\f") == std::string_view::npos;
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
