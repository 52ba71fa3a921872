#include "obj_tags.hpp"

#include <fmt/format.h>

#include <array>
#include <limits>
#include <numbers>
#include <string>
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

}  // namespace tetrakis::detail
