#include "../../hier/obj/obj_lines.hpp"
#include "mesh_codecs.hpp"

#include <fmt/compile.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <unordered_map>

namespace tetrakis::detail {

namespace {

constexpr std::uint32_t k_no_number = 0xFFFF'FFFFu;

// Numbers given to names in the order that faces first use them.
class Names {
  public:
    void set(std::string name) {
        current_ = std::move(name);
        number_ = k_no_number, named_ = true;
    }
    std::uint32_t use(std::vector<std::string>& names) {
        if (number_ != k_no_number) return number_;
        const auto [place, fresh] = numbers_.try_emplace(current_, static_cast<std::uint32_t>(names.size()));
        if (fresh) names.push_back(current_.empty() ? "default" : current_);
        return number_ = place->second;
    }
    bool named() const { return named_; }

  private:
    std::unordered_map<std::string, std::uint32_t> numbers_;
    std::string current_;
    std::uint32_t number_ = k_no_number;
    bool named_ = false;
};

struct Corner {
    std::uint32_t vertex = k_no_number, uv = k_no_number, normal = k_no_number;
};

class ObjDecoder {
  public:
    ObjDecoder(std::string_view text, const std::filesystem::path& path, const RunContext& context)
        : text_(text), path_(path), context_(context) {}

    TriangleMesh run() {
        constexpr std::uint64_t k_lines_per_report = 1 << 18;
        ObjLines lines(text_);
        for (ObjLine line; lines.next(line);) {
            line_number_ = line.number;
            read_ += line.text.size() + 1;
            if (line_number_ % k_lines_per_report == 0)
                context_.report("load", 0.3 + 0.7 * std::min(1.0, static_cast<double>(read_) / text_.size()));
            ObjWords rest(line.text);
            const std::string_view keyword = rest.next();
            if (keyword == "v")
                mesh_.positions.push_back(numbers<3>(rest, "vertex", 3));
            else if (keyword == "vn")
                normals_.push_back(numbers<3>(rest, "normal", 3));
            else if (keyword == "vt")
                mesh_.uvs.push_back(numbers<2>(rest, "texture coordinate", 1));
            else if (keyword == "f")
                face(rest);
            else if (keyword == "usemtl")
                material_.set(std::string(rest.remainder()));
            else if (keyword == "g" || keyword == "o")
                group_.set(std::string(rest.remainder()));
        }
        finish();
        return std::move(mesh_);
    }

  private:
    [[noreturn]] void reject(const std::string& text, std::uint64_t line) const {
        throw Error(ErrorCode::invalid_input, text, path_, line);
    }

    template <int N>
    glm::vec<N, double> numbers(ObjWords& rest, const char* what, int required) const {
        glm::vec<N, double> values(0.0);
        for (int i = 0; i < N; ++i) {
            const std::string_view word = rest.next();
            if (word.empty() && i >= required) break;
            if (word.empty())
                reject(fmt::format("this {} has {} of {} coordinates; complete the line", what, i, required),
                       line_number_);
            const std::optional<double> value = obj_number(word);
            if (!value)
                reject(fmt::format("coordinate {} of this {} is not a number; correct the line", i + 1, what),
                       line_number_);
            if (!std::isfinite(*value))
                reject(fmt::format("coordinate {} of this {} is not finite; give a finite number", i + 1, what),
                       line_number_);
            values[i] = *value;
        }
        return values;
    }

    // One index: from 1, or from -1 backwards. Positive ones may name what is yet to come and are checked at the end.
    std::uint32_t index(std::string_view& word, std::size_t count, const char* what, std::uint64_t& needed) {
        long long number = 0;
        if (!take_integer(word, number))
            reject(fmt::format("a {} index of this face is not a number; write corners as v, v/vt, v//vn or v/vt/vn",
                               what),
                   line_number_);
        if (number == 0)
            reject(
                fmt::format("this face has {} number 0; OBJ counts from 1 (or back from -1); correct the number", what),
                line_number_);
        if (number < 0) number += static_cast<long long>(count) + 1;
        if (number < 1)
            reject(
                fmt::format("this face counts back to a {} before the first; there are {} so far; correct the number",
                            what, count),
                line_number_);
        if (number > k_most_elements)
            reject(fmt::format("a {} index of this face is too large for any mesh; correct the number", what),
                   line_number_);
        if (static_cast<unsigned long long>(number) > count)
            needed = std::max(needed, static_cast<std::uint64_t>(number));
        return static_cast<std::uint32_t>(number - 1);
    }

    void face(ObjWords& rest) {
        corners_.clear();
        std::uint64_t vertices = 0, uvs = 0, normals = 0;  // how many of each a forward reference needs
        for (std::string_view word = rest.next(); !word.empty(); word = rest.next()) {
            Corner corner;
            corner.vertex = index(word, mesh_.positions.size(), "vertex", vertices);
            if (!word.empty() && word.front() == '/') {
                word.remove_prefix(1);
                if (!word.empty() && word.front() != '/')
                    corner.uv = index(word, mesh_.uvs.size(), "texture coordinate", uvs);
                if (!word.empty() && word.front() == '/') {
                    word.remove_prefix(1);
                    if (!word.empty()) corner.normal = index(word, normals_.size(), "normal", normals);
                }
            }
            if (!word.empty())
                reject("a corner of this face is not v, v/vt, v//vn or v/vt/vn; correct the line", line_number_);
            corners_.push_back(corner);
        }
        if (corners_.size() < 3)
            reject(fmt::format("this face has {} corners; complete it to three or more, or remove it", corners_.size()),
                   line_number_);
        if (vertices > 0 || uvs > 0 || normals > 0) forward_.push_back({line_number_, vertices, uvs, normals});
        const std::uint32_t material = material_.use(mesh_.materials), group = group_.use(mesh_.groups);
        for (const Corner& corner : corners_) {
            has_all_uvs_ = has_all_uvs_ && corner.uv != k_no_number;
            has_all_normals_ = has_all_normals_ && corner.normal != k_no_number;
        }
        if (corners_.size() > 3) fans_.push_back({mesh_.triangles.size(), corners_.size()});
        for (std::size_t i = 1; i + 1 < corners_.size(); ++i) {
            const Corner &a = corners_[0], &b = corners_[i], &c = corners_[i + 1];
            mesh_.triangles.push_back({a.vertex, b.vertex, c.vertex});
            if (has_all_uvs_) mesh_.triangle_uvs.push_back({a.uv, b.uv, c.uv});
            if (has_all_normals_) triangle_normals_.push_back({a.normal, b.normal, c.normal});
            mesh_.triangle_material.push_back(material);
            mesh_.triangle_group.push_back(group);
        }
    }

    void finish() {
        for (const Forward& f : forward_) {
            const auto check = [&](std::uint64_t needed, std::size_t count, const char* what) {
                if (needed > count)
                    reject(fmt::format("this face uses {} {}, but the file has {}; the file may be cut short", what,
                                       needed, count),
                           f.line);
            };
            check(f.vertices, mesh_.positions.size(), "vertex");
            check(f.uvs, mesh_.uvs.size(), "texture coordinate");
            check(f.normals, normals_.size(), "normal");
        }
        if (!has_all_uvs_ || mesh_.triangles.empty()) {
            mesh_.triangle_uvs.clear();
            mesh_.uvs.clear();
        }
        if (!has_all_normals_) triangle_normals_.clear();
        cut_fans(fans_, mesh_.positions, {&mesh_.triangles, &mesh_.triangle_uvs, &triangle_normals_});
        if (!material_.named()) mesh_.materials.clear(), mesh_.triangle_material.clear();
        if (!group_.named()) mesh_.groups.clear(), mesh_.triangle_group.clear();
        if (has_all_normals_) keep_normals();
    }

    // By vertex where all vertices have the normal of their own number, as in files of tetrakis without creases.
    void keep_normals() {
        if (mesh_.triangles.empty()) return;
        mesh_.normals = std::move(normals_);
        if (triangle_normals_ != mesh_.triangles || mesh_.normals.size() != mesh_.positions.size())
            mesh_.triangle_normals = std::move(triangle_normals_);
    }

    struct Forward {
        std::uint64_t line, vertices, uvs, normals;
    };
    std::string_view text_;
    std::uint64_t line_number_ = 0, read_ = 0;
    const std::filesystem::path& path_;
    const RunContext& context_;
    TriangleMesh mesh_;
    std::vector<Vec3d> normals_;
    std::vector<std::array<std::uint32_t, 3>> triangle_normals_;
    std::vector<Corner> corners_;
    std::vector<Forward> forward_;
    std::vector<Fan> fans_;
    Names material_, group_;
    bool has_all_uvs_ = true, has_all_normals_ = true;
};

}  // namespace

TriangleMesh decode_obj(std::string_view text, const std::filesystem::path& path, const RunContext& context) {
    return ObjDecoder(text, path, context).run();
}

std::string printable_name(std::string_view name) {
    std::string result(name.empty() ? "unnamed" : name);
    for (char& c : result)
        if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = '_';
    if (result.back() == '\\') result.back() = '_';  // it would join the next line to this one
    return result;
}

namespace {

void append_face(std::string& out, const MeshView& mesh, std::uint64_t f) {
    const auto end = std::back_inserter(out);
    out += 'f';
    for (std::uint64_t c = mesh.face_begin(f); c < mesh.face_end(f); ++c) {
        const std::uint64_t v = std::uint64_t{mesh.corners[c]} + 1;
        if (mesh.has_uvs() && mesh.has_normals())
            fmt::format_to(end, FMT_COMPILE(" {}/{}/{}"), v, std::uint64_t{mesh.corner_uvs[c]} + 1,
                           std::uint64_t{mesh.normal(c)} + 1);
        else if (mesh.has_uvs())
            fmt::format_to(end, FMT_COMPILE(" {}/{}"), v, std::uint64_t{mesh.corner_uvs[c]} + 1);
        else if (mesh.has_normals())
            fmt::format_to(end, FMT_COMPILE(" {}//{}"), v, std::uint64_t{mesh.normal(c)} + 1);
        else
            fmt::format_to(end, FMT_COMPILE(" {}"), v);
    }
    out += '\n';
}

}  // namespace

void encode_obj(const MeshView& mesh, AtomicFile& file, const RunContext& context) {
    file.write("# tetrakis\n");
    write_in_pieces(file, mesh.positions.size(), context, 0.0, 0.35, [&](std::string& out, std::uint64_t v) {
        const Vec3d& p = mesh.positions[v];
        fmt::format_to(std::back_inserter(out), FMT_COMPILE("v {} {} {}\n"), p.x, p.y, p.z);
    });
    write_in_pieces(file, mesh.has_uvs() ? mesh.uvs.size() : 0, context, 0.35, 0.5,
                    [&](std::string& out, std::uint64_t i) {
                        const Vec2d& uv = mesh.uvs[i];
                        fmt::format_to(std::back_inserter(out), FMT_COMPILE("vt {} {}\n"), uv.x, uv.y);
                    });
    write_in_pieces(file, mesh.normals.size(), context, 0.5, 0.75, [&](std::string& out, std::uint64_t v) {
        const Vec3d& n = mesh.normals[v];
        fmt::format_to(std::back_inserter(out), FMT_COMPILE("vn {} {} {}\n"), n.x, n.y, n.z);
    });
    std::vector<std::string> materials, groups;
    for (const std::string& name : mesh.materials) materials.push_back("usemtl " + printable_name(name) + "\n");
    for (const std::string& name : mesh.groups) groups.push_back("g " + printable_name(name) + "\n");
    write_in_pieces(file, mesh.face_count(), context, 0.75, 1.0, [&](std::string& out, std::uint64_t f) {
        const auto changes = [&](std::span<const std::uint32_t> numbers) {
            return !numbers.empty() && (f == 0 || numbers[f] != numbers[f - 1]);
        };
        if (changes(mesh.face_group)) out += groups[mesh.face_group[f]];
        if (changes(mesh.face_material)) out += materials[mesh.face_material[f]];
        append_face(out, mesh, f);
    });
}

}  // namespace tetrakis::detail
