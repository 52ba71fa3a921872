#include "obj_text.hpp"

#include "obj_lines.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

namespace tetrakis::detail {

namespace {

/// Reads a tag line after its `t`.
class TagReader {
  public:
    TagReader(ObjWords words, std::uint64_t line, ControlMeshData& data) : words_(words), line_(line), data_(data) {}

    /// Returns false for a tag of another name, and ignores it.
    bool run() {
        name_ = words_.next();
        if (name_.empty()) fail("the tag has no name; write `t crease 2/1/0 a b sharpness` or the like");
        constexpr std::pair<std::string_view, void (TagReader::*)()> k_tags[] = {
            {"crease", &TagReader::crease},
            {"corner", &TagReader::corner},
            {"cornerangle", &TagReader::corner_angle},
            {"hole", &TagReader::hole},
            {"interpolateboundary", &TagReader::boundary_rule},
            {"facevaryinginterpolateboundary", &TagReader::face_varying_rule},
            {"creasemethod", &TagReader::crease_method}};
        for (const auto& [name, read] : k_tags)
            if (name_ == name) {
                read_arguments();
                (this->*read)();
                return true;
            }
        return false;
    }

  private:
    [[noreturn]] void fail(const std::string& text) const {
        throw Error(ErrorCode::invalid_input, text, data_.source, line_);
    }

    // Counts are only compared with the words that follow: a line may claim billions, so nothing is allocated by them.
    void read_arguments() {
        const std::string_view counts = words_.next();
        std::array<std::int64_t, 3> count{};
        std::size_t at = 0;
        for (int i = 0; i < 3; ++i) {
            const std::size_t slash = i < 2 ? counts.find('/', at) : counts.size();
            const auto value =
                slash == std::string_view::npos ? std::nullopt : obj_integer(counts.substr(at, slash - at));
            if (!value || *value < 0)
                fail(fmt::format("tag '{}' needs its counts as ints/reals/strings, not {}", name_, obj_quote(counts)));
            count[i] = *value;
            at = slash + 1;
        }
        const auto word = [&](const char* what) {
            const std::string_view next = words_.next();
            if (next.empty())
                fail(fmt::format("tag '{}' ends before the {} that its counts {} promise", name_, what,
                                 obj_quote(counts)));
            return next;
        };
        const auto number = [&](const char* what, const char* one, auto parse) {
            const std::string_view text = word(what);
            const auto value = parse(text);
            if (!value) fail(fmt::format("{} in tag '{}' is no {}", obj_quote(text), name_, one));
            return *value;
        };
        for (std::int64_t i = 0; i < count[0]; ++i) {
            const std::int64_t value = number("integers", "integer", obj_integer);
            ints_.push_back(value < 0 || value >= VertexId::none ? VertexId::none : static_cast<std::uint32_t>(value));
        }
        for (std::int64_t i = 0; i < count[1]; ++i) reals_.push_back(number("reals", "number", obj_number));
        for (std::int64_t i = 0; i < count[2]; ++i) strings_.push_back(word("strings"));
        if (const std::string_view extra = words_.next(); !extra.empty())
            fail(fmt::format("tag '{}' goes on with {} after what its counts {} promise", name_, obj_quote(extra),
                             obj_quote(counts)));
    }

    float sharpness(std::size_t i) const {
        const double value = reals_[i];
        return value > std::numeric_limits<float>::max() ? k_sharpness_infinity : static_cast<float>(value);
    }

    void crease() {
        const std::size_t pairs = ints_.size() / 2, reals = reals_.size();
        if (pairs == 0 || ints_.size() % 2 != 0)
            fail(fmt::format("a crease tag needs pairs of vertices, not {} numbers", ints_.size()));
        if (reals != 1 && reals != pairs && reals != 2 * pairs)
            fail(fmt::format("a crease tag of {} edges needs 1 sharpness or one for each edge, not {}", pairs, reals));
        for (std::size_t i = 0; i < pairs; ++i)
            data_.creases.push_back({ints_[2 * i], ints_[2 * i + 1],
                                     sharpness(reals == 1       ? 0
                                               : reals == pairs ? i
                                                                : 2 * i),
                                     line_});
    }

    void corner() {
        const std::size_t count = ints_.size(), reals = reals_.size();
        if (count == 0) fail("a corner tag needs at least one vertex");
        if (reals != 1 && reals != count)
            fail(fmt::format("a corner tag of {} vertices needs 1 sharpness or one for each, not {}", count, reals));
        for (std::size_t i = 0; i < count; ++i)
            data_.corners.push_back({ints_[i], sharpness(reals == 1 ? 0 : i), line_});
    }

    void corner_angle() {
        const std::size_t pairs = ints_.size() / 2, reals = reals_.size();
        if (pairs == 0 || ints_.size() % 2 != 0)
            fail(fmt::format("a cornerangle tag needs pairs of a vertex and a face, not {} numbers", ints_.size()));
        if (reals != 1 && reals != pairs)
            fail(fmt::format("a cornerangle tag of {} corners needs 1 angle or one for each, not {}", pairs, reals));
        for (std::size_t i = 0; i < pairs; ++i)
            data_.corner_angles.push_back(
                {ints_[2 * i], ints_[2 * i + 1], reals_[reals == 1 ? 0 : i] * std::numbers::pi / 180, line_});
    }

    void hole() {
        if (ints_.empty()) fail("a hole tag needs at least one face");
        for (const std::uint32_t face : ints_) {
            data_.holes.push_back(face);
            data_.hole_lines.push_back(line_);
        }
    }

    std::uint32_t choice(std::uint32_t last, const char* meaning) const {
        if (ints_.size() != 1 || ints_[0] > last) fail(fmt::format("tag '{}' needs one integer: {}", name_, meaning));
        return ints_[0];
    }

    void boundary_rule() {
        data_.boundary_rule = static_cast<BoundaryRule>(choice(2, "0 none, 1 edge and corner, 2 edge only"));
    }
    void face_varying_rule() {
        data_.face_varying_rule = static_cast<FaceVaryingRule>(choice(
            5, "0 smooth, 1 corners only, 2 corners plus 1, 3 corners plus 2, 4 boundaries, 5 linear everywhere"));
    }
    void crease_method() {
        if (strings_.size() == 1 && strings_[0] == "chaikin")
            data_.crease_method = CreaseMethod::chaikin;
        else if (strings_.size() == 1 && (strings_[0] == "normal" || strings_[0] == "uniform"))
            data_.crease_method = CreaseMethod::uniform;
        else
            fail("tag 'creasemethod' needs one word: normal or chaikin");
    }

    ObjWords words_;
    std::uint64_t line_;
    ControlMeshData& data_;
    std::string_view name_;
    std::vector<std::uint32_t> ints_;  ///< VertexId::none if the file's number is negative or too large for any mesh
    std::vector<double> reals_;
    std::vector<std::string_view> strings_;
};

// Largest number of values on a `v` line: position, weight and colour.
constexpr std::size_t k_most_numbers = 8;
// Largest number of unknown keywords that each get their own warning.
constexpr std::size_t k_named_keywords = 8;
// Largest number of corners; 32-bit numbers above it are reserved for missing elements.
constexpr std::size_t k_most_corners = 0xFFFF'FFFBu;

// Lines that do not concern the surface; they are skipped without a warning.
bool is_decoration(std::string_view keyword) {
    constexpr std::array<std::string_view, 11> k_words = {
        "mtllib", "s", "lod", "bevel", "c_interp", "d_interp", "shadow_obj", "trace_obj", "usemap", "maplib", "mg"};
    return std::ranges::find(k_words, keyword) != k_words.end();
}

// The current name. Its number is looked up once per change, when a face first uses it: this orders the numbers.
struct CurrentName {
    std::string name;
    std::uint32_t number = VertexId::none;
    bool given = false;  ///< whether the file has such a line
    std::unordered_map<std::string, std::uint32_t> numbers;

    void set(std::string_view bytes) {
        name = obj_name(bytes);
        number = VertexId::none;
        given = true;
    }
    std::uint32_t use(std::vector<std::string>& names) {
        if (number != VertexId::none) return number;
        const auto [it, added] = numbers.try_emplace(name, static_cast<std::uint32_t>(names.size()));
        if (added) names.push_back(name);
        return number = it->second;
    }
};

// Number of lines with one kind of oddity.
struct Tally {
    std::uint64_t count = 0, first = 0;

    void add(std::uint64_t line) {
        if (count++ == 0) first = line;
    }
};

class Reader {
  public:
    Reader(std::string_view text, std::string source, ObjUse use, const RunContext& context)
        : text_(text), use_(use), context_(context) {
        data_.source = std::move(source);
        data_.first_number = 1;
        data_.face_offsets.push_back(0);
    }

    ControlMeshData run() {
        if (const std::size_t zero = text_.find('\0'); zero != std::string_view::npos) {
            line_ = 1 + static_cast<std::uint64_t>(std::count(text_.begin(), text_.begin() + zero, '\n'));
            fail("a zero byte: this is no text file; give an OBJ file");
        }
        constexpr std::uint64_t k_lines_per_report = 1 << 18;
        ObjLines lines(text_);
        std::size_t read = 0;
        for (ObjLine line; lines.next(line);) {
            line_ = line.number;
            read += line.text.size() + 1;
            if (line_ % k_lines_per_report == 0)
                context_.report("load", 0.3 + 0.7 * std::min(1.0, static_cast<double>(read) / text_.size()));
            ObjWords words(line.text);
            if (const std::string_view keyword = words.next(); !keyword.empty()) read_line(keyword, words);
        }
        finish();
        return std::move(data_);
    }

  private:
    [[noreturn]] void fail(const std::string& text) const {
        throw Error(ErrorCode::invalid_input, text, data_.source, line_);
    }

    void read_line(std::string_view keyword, ObjWords& words) {
        if (keyword == "v") return vertex(words);
        if (keyword == "f") return face(words);
        if (keyword == "vt") return uv(words);
        if (keyword == "vn") return normal(words);
        if (keyword == "t") {
            const std::string_view rest = words.remainder();
            if (use_ == ObjUse::control_mesh && !TagReader(words, line_, data_).run())
                ignore("t " + std::string(rest.substr(0, rest.find(' '))));
            return;
        }
        if (keyword == "usemtl") return material_.set(words.remainder());
        if (keyword == "g" || keyword == "o") return group_.set(words.remainder());
        if (!is_decoration(keyword)) ignore(std::string(keyword));
    }

    void ignore(const std::string& keyword) {
        auto known = std::ranges::find(ignored_, keyword, &Ignored::keyword);
        if (known == ignored_.end() && ignored_.size() == k_named_keywords) return void(++ignored_others_);
        if (known == ignored_.end()) known = ignored_.insert(known, {keyword, {}});
        known->lines.add(line_);
    }

    struct Numbers {
        std::array<double, k_most_numbers> value{};
        std::size_t count = 0;
    };

    Numbers numbers(ObjWords& words, const char* what, std::size_t least, std::size_t most) {
        Numbers result;
        for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
            const auto value = obj_number(word);
            if (!value)
                fail(fmt::format("{} in {} is no number; {}", obj_quote(word), what,
                                 word.find(',') != std::string_view::npos ? "write a decimal point, not a comma"
                                                                          : "correct the line"));
            if (use_ == ObjUse::triangles && !std::isfinite(*value))
                fail(fmt::format("{} in {} is not finite; give a finite number", obj_quote(word), what));
            if (result.count == most) fail(fmt::format("{} has more than {} numbers; correct the line", what, most));
            result.value[result.count++] = *value;
        }
        if (result.count < least)
            fail(fmt::format("{} has {} coordinate{}, it needs {}; complete the line", what, result.count,
                             result.count == 1 ? "" : "s", least));
        return result;
    }

    void vertex(ObjWords& words) {
        const Numbers n = numbers(words, "the vertex", 3, k_most_numbers);
        // x y z w; x y z and a colour; or x y z w and a colour: 4, 6 or 7 numbers.
        if ((n.count == 4 || n.count == 5 || n.count >= 7) && n.value[3] != 1.0) weighted_.add(line_);
        if (n.count == 5 || n.count == 8) surplus_.add(line_);
        if (n.count >= 6) coloured_.add(line_);
        data_.positions.emplace_back(n.value[0], n.value[1], n.value[2]);
        data_.vertex_lines.push_back(line_);
    }

    void uv(ObjWords& words) {
        const Numbers n = numbers(words, "the texture coordinate", 1, 3);
        data_.uvs.emplace_back(n.value[0], n.value[1]);
        data_.uv_lines.push_back(line_);
    }

    void normal(ObjWords& words) {
        const Numbers n = numbers(words, "the normal", 3, 3);
        data_.normals.emplace_back(n.value[0], n.value[1], n.value[2]);
    }

    // One index of a corner, counted from 0. Negative numbers count back from the latest element.
    std::uint32_t index(std::string_view digits, std::string_view word, const char* what, std::size_t so_far,
                        std::uint32_t no_such) {
        const auto value = obj_integer(digits);
        if (!value) fail(fmt::format("{} is no face corner; write it as v, v/vt, v//vn or v/vt/vn", obj_quote(word)));
        if (*value == 0)
            fail(fmt::format("{} in a face has {} number 0; OBJ counts from 1 (or back from -1); correct the number",
                             obj_quote(word), what));
        const std::int64_t i = *value > 0 ? *value - 1 : static_cast<std::int64_t>(so_far) + *value;
        return i < 0 || i >= k_obj_no_such ? no_such : static_cast<std::uint32_t>(i);
    }

    // Adds a corner's number to a layer, which starts at the first corner that has one.
    void put(std::vector<std::uint32_t>& layer, std::uint32_t number) const {
        if (layer.empty() && number == k_obj_absent) return;
        layer.resize(data_.face_vertices.size() - 1, k_obj_absent);
        layer.push_back(number);
    }

    void face(ObjWords& words) {
        for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
            const std::size_t slash = word.find('/');
            std::string_view vt, vn;
            if (slash != std::string_view::npos) {
                const std::size_t second = word.find('/', slash + 1);
                vt = word.substr(slash + 1, second == std::string_view::npos ? second : second - slash - 1);
                if (second != std::string_view::npos) vn = word.substr(second + 1);
            }
            data_.face_vertices.push_back(
                index(word.substr(0, slash), word, "vertex", data_.positions.size(), VertexId::none));
            put(data_.face_uvs,
                vt.empty() ? k_obj_absent : index(vt, word, "texture coordinate", data_.uvs.size(), k_obj_no_such));
            put(data_.face_normals,
                vn.empty() ? k_obj_absent : index(vn, word, "normal", data_.normals.size(), k_obj_no_such));
        }
        if (data_.face_vertices.size() > k_most_corners) fail("more than 2^32 - 5 face corners; split the model");
        data_.face_offsets.push_back(static_cast<std::uint32_t>(data_.face_vertices.size()));
        data_.face_lines.push_back(line_);
        data_.face_material.push_back(material_.use(data_.materials));
        data_.face_group.push_back(group_.use(data_.groups));
    }

    void finish() {
        for (auto* const layer : {&data_.face_uvs, &data_.face_normals})
            if (!layer->empty()) layer->resize(data_.face_vertices.size(), k_obj_absent);
        if (!material_.given) data_.face_material.clear(), data_.materials.clear();
        if (!group_.given) data_.face_group.clear(), data_.groups.clear();
        const auto warn = [&](const Tally& lines, std::string_view text) {
            if (lines.count != 0)
                data_.warnings.push_back(
                    fmt::vformat(text, fmt::make_format_args(lines.count, lines.first, data_.source)));
        };
        warn(weighted_, "{} vertices have a weight other than 1 (the first is on line {}); weights are ignored");
        warn(surplus_,
             "{} vertices have 5 or 8 numbers, one more than x y z with a weight or a colour or both (the first is on "
             "line {}); it is ignored");
        warn(coloured_, "{2}: vertex colours are not carried over ({0} vertices have one, the first is on line {1})");
        for (const auto& [keyword, lines] : ignored_)
            data_.warnings.push_back(fmt::format("{} line{} of kind {} ignored (the first is line {})", lines.count,
                                                 lines.count == 1 ? "" : "s", obj_quote(keyword), lines.first));
        if (ignored_others_ != 0)
            data_.warnings.push_back(fmt::format("{} lines of other unknown kinds ignored", ignored_others_));
    }

    struct Ignored {
        std::string keyword;
        Tally lines;
    };

    std::string_view text_;
    ObjUse use_;
    const RunContext& context_;
    ControlMeshData data_;
    std::uint64_t line_ = 0;
    CurrentName material_, group_;
    Tally weighted_, surplus_, coloured_;
    std::vector<Ignored> ignored_;
    std::uint64_t ignored_others_ = 0;  ///< lines with other unknown keywords
};

}  // namespace

ControlMeshData read_obj_text(std::string_view text, std::string source, ObjUse use, const RunContext& context) {
    return Reader(text, std::move(source), use, context).run();
}

}  // namespace tetrakis::detail
