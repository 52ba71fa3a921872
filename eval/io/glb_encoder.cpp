#include "../../hier/obj/obj_lines.hpp"
#include "mesh_codecs.hpp"
#include "mesh_writer.hpp"
#include "split_vertices.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <span>
#include <utility>

namespace tetrakis {

namespace {

// Moving the origin gains one bit of precision for each halving of the largest coordinate. For less than two bits it is
// not worthwhile, as some readers ignore the translation.
constexpr double k_worthwhile = 4;

double half_extent(const Box3d& box) {
    const Vec3d half = 0.5 * box.upper - 0.5 * box.lower;
    return std::max({half.x, half.y, half.z});
}

double largest_coordinate(const Box3d& box) {
    return std::max({std::abs(box.lower.x), std::abs(box.lower.y), std::abs(box.lower.z), std::abs(box.upper.x),
                     std::abs(box.upper.y), std::abs(box.upper.z)});
}

}  // namespace

Vec3d glb_origin(const Box3d& box) {
    if (box.empty() || !(largest_coordinate(box) > k_worthwhile * half_extent(box))) return Vec3d(0);
    return Vec3d(Vec3f(0.5 * box.lower + 0.5 * box.upper));
}

double glb_rounding_bound(const Box3d& box) {
    if (box.empty()) return 0;
    const Vec3d origin = glb_origin(box);
    double squares = 0;
    for (int axis = 0; axis < 3; ++axis) {
        // The error is half a unit in the last place of the largest float, plus half of the smallest float for
        // underflow. Before that, the subtraction of the origin is rounded in double.
        const double reach =
            std::max(std::abs(box.lower[axis] - origin[axis]), std::abs(box.upper[axis] - origin[axis]));
        const double error = reach * (0x1p-24 + 0x1p-52) + 0x1p-150;
        squares += error * error;
    }
    return std::sqrt(squares) * (1 + 0x1p-50);
}

double glb_rounding_bound_within(const Box3d& box) {
    if (box.empty()) return 0;
    const double half = half_extent(box), reach = largest_coordinate(box);
    // The largest coordinate of a box inside is at least reach - 2 half. The inner box may keep origin 0 although this
    // one moves it; then its coordinates are at most k_worthwhile times its own half extent.
    if (glb_origin(box) == Vec3d(0) || reach - 2 * half > k_worthwhile * half)
        return glb_rounding_bound(box) * (1 + 0x1p-20);  // the factor covers the origins' own rounding to float
    return glb_rounding_bound({Vec3d(-k_worthwhile * half), Vec3d(k_worthwhile * half)});
}

namespace detail {

namespace {

using Json = nlohmann::ordered_json;

Vec3f unit_normal(const Vec3d& n) {
    const Vec3d unit = unit_or_zero(n);
    return unit != Vec3d(0) ? Vec3f(unit) : Vec3f(0, 0, 1);  // glTF requires unit length
}

class GlbEncoder {
  public:
    GlbEncoder(const MeshView& mesh, const Box3d& whole, const RunContext& context)
        : mesh_(mesh), context_(context), split_(mesh, true), origin_(glb_origin(whole)) {
        const auto key = [&](std::uint64_t f) {
            return std::pair(mesh.face_group.empty() ? 0 : mesh.face_group[f],
                             mesh.face_material.empty() ? 0 : mesh.face_material[f]);
        };
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint64_t> triangles;
        for (std::uint64_t f = 0; f < mesh.face_count(); ++f)
            triangles[key(f)] += mesh.face_end(f) - mesh.face_begin(f) - 2;
        for (const auto& [of, count] : triangles) indices_[of].reserve(3 * count);
        for_each_triangle(mesh, [&](std::uint64_t f, const std::array<std::uint64_t, 3>& corners) {
            auto& indices = indices_[key(f)];
            for (const std::uint64_t c : corners) indices.push_back(split_.corners()[c]);
        });
        const Box3d box = bounding_box(mesh.positions);
        const Vec3d reach = glm::max(glm::abs(box.lower - origin_), glm::abs(box.upper - origin_));
        if (!box.empty() && !fits_float(std::max({reach.x, reach.y, reach.z})))
            throw Error(ErrorCode::unsupported, "the coordinates exceed the floats of GLB; write .obj or .ply");
        for (const Vec2d& uv : mesh.uvs)
            if (!fits_float(uv.x) || !fits_float(uv.y))
                throw Error(ErrorCode::unsupported,
                            "the texture coordinates exceed the floats of GLB; write .obj or .ply");
    }

    void write(AtomicFile& file) {
        Json json = describe();
        std::string text = json.dump();
        text.resize((text.size() + 3) / 4 * 4, ' ');
        const std::uint64_t total = 12 + 8 + text.size() + (buffer_bytes_ > 0 ? 8 + buffer_bytes_ : 0);
        constexpr std::uint64_t k_most_bytes = 0xFFFF'FFFFu;  // GLB counts bytes in 32 bits
        if (total > k_most_bytes)
            throw Error(ErrorCode::unsupported,
                        fmt::format("a GLB of {} bytes exceeds the format's 4 GiB; write .ply", total));
        std::string head = "glTF";
        append_bytes(head, std::uint32_t{2});
        append_bytes(head, static_cast<std::uint32_t>(total));
        append_bytes(head, static_cast<std::uint32_t>(text.size()));
        head += "JSON" + text;
        if (buffer_bytes_ > 0) {
            append_bytes(head, static_cast<std::uint32_t>(buffer_bytes_));
            head += std::string_view("BIN\0", 4);
        }
        file.write(head);
        if (buffer_bytes_ > 0) write_buffer(file);
    }

  private:
    Vec3f local(std::uint64_t v) const { return Vec3f(mesh_.positions[split_.vertices()[v].position] - origin_); }

    Json describe() {
        Json json;
        json["asset"] = {{"version", "2.0"}, {"generator", "tetrakis"}};
        json["scene"] = 0;
        if (indices_.empty()) {  // an empty scene: glTF allows no accessor without elements
            json["scenes"] = Json::array({Json::object()});
            return json;
        }
        const auto add_view = [&](std::uint64_t bytes, int target) {
            json["bufferViews"].push_back(
                {{"buffer", 0}, {"byteOffset", buffer_bytes_}, {"byteLength", bytes}, {"target", target}});
            buffer_bytes_ += bytes;
            return json["bufferViews"].size() - 1;
        };
        constexpr int k_array_buffer = 34962, k_element_array_buffer = 34963, k_float = 5126, k_unsigned_int = 5125;
        const auto add_vertices = [&](const char* type, std::uint64_t bytes_each) {
            const std::size_t view = add_view(split_.vertices().size() * bytes_each, k_array_buffer);
            json["accessors"].push_back({{"bufferView", view},
                                         {"componentType", k_float},
                                         {"count", split_.vertices().size()},
                                         {"type", type}});
            return json["accessors"].size() - 1;
        };
        Json attributes;
        attributes["POSITION"] = add_vertices("VEC3", sizeof(Vec3f));
        Vec3f lower = local(0), upper = lower;
        for (std::uint64_t v = 1; v < mesh_.positions.size(); ++v) {
            lower = glm::min(lower, local(v));
            upper = glm::max(upper, local(v));
        }
        Json& positions = json["accessors"].back();
        positions["min"] = {lower.x, lower.y, lower.z};
        positions["max"] = {upper.x, upper.y, upper.z};
        if (mesh_.has_normals()) attributes["NORMAL"] = add_vertices("VEC3", sizeof(Vec3f));
        if (mesh_.has_uvs()) attributes["TEXCOORD_0"] = add_vertices("VEC2", sizeof(glm::vec2));
        const std::uint64_t triangles = mesh_.corners.size() - 2 * mesh_.face_count();
        const std::size_t index_view = add_view(3 * sizeof(std::uint32_t) * triangles, k_element_array_buffer);

        Json nodes = Json::array();
        std::uint64_t offset = 0;
        std::optional<std::uint32_t> last_group;
        for (const auto& [key, indices] : indices_) {
            const auto [group, material] = key;
            if (std::exchange(last_group, group) != group) {
                Json mesh, node;
                if (!mesh_.face_group.empty()) mesh["name"] = node["name"] = obj_name(mesh_.groups[group]);
                mesh["primitives"] = Json::array();
                node["mesh"] = json["meshes"].size();
                if (origin_ != Vec3d(0)) node["translation"] = {origin_.x, origin_.y, origin_.z};
                json["meshes"].push_back(std::move(mesh));
                nodes.push_back(std::move(node));
            }
            json["accessors"].push_back({{"bufferView", index_view},
                                         {"byteOffset", offset},
                                         {"componentType", k_unsigned_int},
                                         {"count", indices.size()},
                                         {"type", "SCALAR"}});
            offset += indices.size() * sizeof(std::uint32_t);
            Json part = {{"attributes", attributes}, {"indices", json["accessors"].size() - 1}};
            if (!mesh_.face_material.empty()) part["material"] = material;
            json["meshes"].back()["primitives"].push_back(std::move(part));
        }
        Json members = Json::array();
        for (std::size_t n = 0; n < nodes.size(); ++n) members.push_back(n);
        json["scenes"] = Json::array({{{"nodes", members}}});
        json["nodes"] = std::move(nodes);
        if (!mesh_.face_material.empty())
            for (const std::string& name : mesh_.materials)
                json["materials"].push_back(
                    {{"name", obj_name(name)},
                     {"pbrMetallicRoughness", {{"metallicFactor", 0.0}, {"roughnessFactor", 0.6}}}});
        json["buffers"] = Json::array({{{"byteLength", buffer_bytes_}}});
        return json;
    }

    void write_buffer(AtomicFile& file) const {
        write_in_pieces(file, split_.vertices().size(), context_, 0.0, 0.3,
                        [&](std::string& out, std::uint64_t v) { append_bytes(out, local(v)); });
        write_in_pieces(file, mesh_.has_normals() ? split_.vertices().size() : 0, context_, 0.3, 0.5,
                        [&](std::string& out, std::uint64_t v) {
                            append_bytes(out, unit_normal(mesh_.normals[split_.vertices()[v].normal]));
                        });
        write_in_pieces(file, mesh_.has_uvs() ? split_.vertices().size() : 0, context_, 0.5, 0.6,
                        [&](std::string& out, std::uint64_t v) {
                            const std::uint32_t i = split_.vertices()[v].uv;
                            const Vec2d uv = i == SplitVertices::k_no_uv ? Vec2d(0) : mesh_.uvs[i];
                            append_bytes(out, glm::vec2(uv.x, 1 - uv.y));  // glTF counts v from the top
                        });
        for (const auto& [key, indices] : indices_) {
            context_.report("write", 0.6);
            file.write(std::as_bytes(std::span(indices)));
        }
    }

    const MeshView& mesh_;
    const RunContext& context_;
    SplitVertices split_;
    Vec3d origin_;
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<std::uint32_t>> indices_;  // by group and material
    std::uint64_t buffer_bytes_ = 0;
};

}  // namespace

void encode_glb(const MeshView& mesh, const Box3d& whole, AtomicFile& file, const RunContext& context) {
    GlbEncoder(mesh, whole, context).write(file);
}

}  // namespace detail

}  // namespace tetrakis
