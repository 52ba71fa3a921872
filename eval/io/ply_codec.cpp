#include "mesh_codecs.hpp"
#include "mesh_view.hpp"
#include "ply_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace tetrakis::detail {

namespace {

// Where each number of a vertex or face goes.
enum class Role { skip, x, y, z, nx, ny, nz, u, v, corners, texcoord, material, group };

Role vertex_role(const std::string& name) {
    constexpr std::pair<std::string_view, Role> k_names[] = {
        {"x", Role::x},   {"y", Role::y},   {"z", Role::z},         {"nx", Role::nx},
        {"ny", Role::ny}, {"nz", Role::nz}, {"s", Role::u},         {"t", Role::v},
        {"u", Role::u},   {"v", Role::v},   {"texture_u", Role::u}, {"texture_v", Role::v}};
    for (const auto& [key, role] : k_names)
        if (name == key) return role;
    return Role::skip;
}

Role face_role(const std::string& name) {
    if (name == "vertex_indices" || name == "vertex_index") return Role::corners;
    if (name == "texcoord") return Role::texcoord;
    if (name == "material_index") return Role::material;
    if (name == "group_index") return Role::group;
    return Role::skip;
}

class PlyDecoder {
  public:
    PlyDecoder(std::string_view bytes, const std::filesystem::path& path, const RunContext& context)
        : header_(parse_ply_header(bytes, path)), values_(bytes, header_, path), path_(path), context_(context) {}

    TriangleMesh run() {
        for (const PlyElement& element : header_.elements) {
            values_.check_room(element);
            if (element.name == "vertex")
                vertices(element);
            else if (element.name == "face")
                faces(element);
            else
                for (std::uint64_t i = 0; i < element.count; ++i)
                    for (const PlyProperty& property : element.properties) skip(property);
        }
        check_corners();
        name_numbers(mesh_.triangle_material, mesh_.materials, header_.materials, "material");
        name_numbers(mesh_.triangle_group, mesh_.groups, header_.groups, "group");
        if (!mesh_.triangle_uvs.empty() && mesh_.triangle_uvs.size() != mesh_.triangles.size()) {
            mesh_.triangle_uvs.clear();
            mesh_.uvs.clear();
        }
        cut_fans(fans_, mesh_.positions, {&mesh_.triangles, &mesh_.triangle_uvs});
        if (vertex_uvs_ && mesh_.triangle_uvs.empty()) {  // one UV per vertex: the same numbers
            mesh_.uvs = std::move(uv_of_vertex_);
            mesh_.triangle_uvs = mesh_.triangles;
        }
        if (!mesh_.normals.empty()) join_split_vertices(mesh_);
        return std::move(mesh_);
    }

  private:
    static constexpr std::uint64_t k_per_report = 1 << 18;

    void check_count(const PlyElement& element) const {
        if (element.count > k_most_elements)
            throw Error(ErrorCode::unsupported, fmt::format("{} {} elements are too many", element.count, element.name),
                        path_);
    }

    // The last role is that of `property`.
    void reject_second(const std::vector<Role>& roles, const PlyElement& element, const PlyProperty& property) const {
        if (roles.back() != Role::skip && std::count(roles.begin(), roles.end(), roles.back()) > 1)
            throw Error(ErrorCode::invalid_input,
                        fmt::format("the element {} has a second property for what {} says; remove one", element.name,
                                    property.name),
                        path_);
    }

    void skip(const PlyProperty& property) {
        const std::uint64_t count = property.is_list ? values_.list_count(property) : 1;
        for (std::uint64_t i = 0; i < count; ++i) (void)values_.next(property.type);
    }

    void report(std::uint64_t i, const PlyElement& element, double from, double to) const {
        if (i % k_per_report == 0)
            context_.report("load", from + (to - from) * static_cast<double>(i) / static_cast<double>(element.count));
    }

    void vertices(const PlyElement& element) {
        check_count(element);
        std::vector<Role> roles;
        bool has[static_cast<int>(Role::group) + 1] = {};
        for (const PlyProperty& property : element.properties) {
            roles.push_back(property.is_list ? Role::skip : vertex_role(property.name));
            reject_second(roles, element, property);
            has[static_cast<int>(roles.back())] = true;
        }
        const auto all_of = [&](std::initializer_list<Role> wanted) {
            return std::all_of(wanted.begin(), wanted.end(), [&](Role r) { return has[static_cast<int>(r)]; });
        };
        if (!all_of({Role::x, Role::y, Role::z}))
            throw Error(ErrorCode::invalid_input, "the vertices have no x, y and z", path_);
        const bool normals = all_of({Role::nx, Role::ny, Role::nz});
        vertex_uvs_ = all_of({Role::u, Role::v});
        mesh_.positions.resize(element.count);
        if (normals) mesh_.normals.resize(element.count);
        if (vertex_uvs_) uv_of_vertex_.resize(element.count);
        for (std::uint64_t v = 0; v < element.count; ++v) {
            report(v, element, 0.3, 0.6);
            double value[static_cast<int>(Role::group) + 1] = {};
            for (std::size_t p = 0; p < roles.size(); ++p) {
                if (roles[p] == Role::skip) {
                    skip(element.properties[p]);
                    continue;
                }
                const double number = values_.next(element.properties[p].type);
                if (!std::isfinite(number))
                    values_.reject(fmt::format("{} of vertex {} is not finite", element.properties[p].name, v));
                value[static_cast<int>(roles[p])] = number;
            }
            const auto at = [&](Role r) { return value[static_cast<int>(r)]; };
            mesh_.positions[v] = {at(Role::x), at(Role::y), at(Role::z)};
            if (normals) mesh_.normals[v] = {at(Role::nx), at(Role::ny), at(Role::nz)};
            if (vertex_uvs_) uv_of_vertex_[v] = {at(Role::u), at(Role::v)};
        }
    }

    void faces(const PlyElement& element) {
        check_count(element);
        std::vector<Role> roles;
        for (const PlyProperty& property : element.properties) {
            roles.push_back(face_role(property.name));
            reject_second(roles, element, property);
        }
        if (std::find(roles.begin(), roles.end(), Role::corners) == roles.end())
            throw Error(ErrorCode::invalid_input, "the faces have no list vertex_indices", path_);
        std::vector<double> texcoords;
        for (std::uint64_t f = 0; f < element.count; ++f) {
            report(f, element, 0.6, 1.0);
            corners_.clear();
            texcoords.clear();
            std::optional<std::uint32_t> material, group;
            for (std::size_t p = 0; p < roles.size(); ++p) {
                const PlyProperty& property = element.properties[p];
                if (roles[p] == Role::corners && property.is_list) {
                    const std::uint64_t count = values_.list_count(property);
                    if (count < 3) values_.reject(fmt::format("face {} has {} corners; it needs three", f, count));
                    for (std::uint64_t i = 0; i < count; ++i) corners_.push_back(index(property, "vertex", f));
                } else if (roles[p] == Role::texcoord && property.is_list) {
                    const std::uint64_t count = values_.list_count(property);
                    for (std::uint64_t i = 0; i < count; ++i) texcoords.push_back(values_.next(property.type));
                } else if (roles[p] == Role::material && !property.is_list) {
                    material = index(property, "material", f);
                } else if (roles[p] == Role::group && !property.is_list) {
                    group = index(property, "group", f);
                } else {
                    skip(property);
                }
            }
            add_face(texcoords, material, group, f);
        }
    }

    std::uint32_t index(const PlyProperty& property, const char* what, std::uint64_t f) {
        const double number = values_.next(property.type);
        if (!(number >= 0 && number <= static_cast<double>(k_most_elements)) || number != std::floor(number))
            values_.reject(fmt::format("a {} index of face {} is no index", what, f));
        return static_cast<std::uint32_t>(number);
    }

    void add_face(const std::vector<double>& texcoords, std::optional<std::uint32_t> material,
                  std::optional<std::uint32_t> group, std::uint64_t f) {
        const bool uvs = texcoords.size() == 2 * corners_.size();
        const auto first_uv = static_cast<std::uint32_t>(mesh_.uvs.size());
        if (uvs)
            for (std::size_t i = 0; i < corners_.size(); ++i) {
                mesh_.uvs.emplace_back(texcoords[2 * i], texcoords[2 * i + 1]);
                if (!std::isfinite(texcoords[2 * i]) || !std::isfinite(texcoords[2 * i + 1]))
                    values_.reject(fmt::format("a texture coordinate of face {} is not finite", f));
            }
        if (corners_.size() > 3) fans_.push_back({mesh_.triangles.size(), corners_.size()});
        for (std::uint32_t i = 1; i + 1 < corners_.size(); ++i) {
            mesh_.triangles.push_back({corners_[0], corners_[i], corners_[i + 1]});
            if (uvs) mesh_.triangle_uvs.push_back({first_uv, first_uv + i, first_uv + i + 1});
            if (material) mesh_.triangle_material.push_back(*material);
            if (group) mesh_.triangle_group.push_back(*group);
        }
        if (mesh_.triangles.size() > k_most_elements || mesh_.uvs.size() > k_most_elements)
            throw Error(ErrorCode::unsupported, "too many triangles", path_);
    }

    // Faces may come before the vertices, so this waits for the end.
    void check_corners() const {
        for (const auto& triangle : mesh_.triangles)
            for (const std::uint32_t v : triangle)
                if (v >= mesh_.positions.size())
                    throw Error(
                        ErrorCode::invalid_input,
                        fmt::format("a face uses vertex {}, but there are {} vertices", v, mesh_.positions.size()),
                        path_);
    }

    // Names come from comments of the header; numbers without one get their number as name.
    void name_numbers(const std::vector<std::uint32_t>& numbers, std::vector<std::string>& names,
                      const std::vector<std::string>& given, const char* what) const {
        if (numbers.empty()) return;
        constexpr std::uint32_t k_most_names = 1 << 20;
        const std::uint32_t largest = *std::max_element(numbers.begin(), numbers.end());
        if (largest >= std::max<std::size_t>(given.size(), k_most_names))
            throw Error(ErrorCode::invalid_input, fmt::format("{} number {} is absurd", what, largest), path_);
        names = given;
        while (names.size() <= largest) names.push_back(fmt::format("{}_{}", what, names.size()));
    }

    PlyHeader header_;
    PlyValues values_;
    const std::filesystem::path& path_;
    const RunContext& context_;
    TriangleMesh mesh_;
    std::vector<Vec2d> uv_of_vertex_;
    std::vector<std::uint32_t> corners_;
    std::vector<Fan> fans_;
    bool vertex_uvs_ = false;
};

}  // namespace

TriangleMesh decode_ply(std::string_view bytes, const std::filesystem::path& path, const RunContext& context) {
    return PlyDecoder(bytes, path, context).run();
}

void encode_ply(const MeshView& mesh, AtomicFile& file, const RunContext& context) {
    const SplitVertices split(mesh, false);
    std::uint64_t largest_face = 3;
    for (std::uint64_t f = 0; f + 1 < mesh.face_offsets.size(); ++f)
        largest_face = std::max(largest_face, mesh.face_end(f) - mesh.face_begin(f));
    // Texture coordinates are a list of two numbers a corner; most readers expect counts in one byte.
    const bool short_lists = 2 * largest_face <= 255;
    const char* count_type = short_lists ? "uchar" : "uint";
    // Readers expect signed indices; unsigned ones only where they must be.
    const char* index_type = split.count <= 0x7FFF'FFFFu ? "int" : "uint";

    std::string header = "ply\nformat binary_little_endian 1.0\ncomment tetrakis\n";
    for (std::size_t i = 0; i < mesh.materials.size(); ++i)
        header += fmt::format("comment material {} {}\n", i, printable_name(mesh.materials[i]));
    for (std::size_t i = 0; i < mesh.groups.size(); ++i)
        header += fmt::format("comment group {} {}\n", i, printable_name(mesh.groups[i]));
    header += fmt::format("element vertex {}\nproperty double x\nproperty double y\nproperty double z\n", split.count);
    if (mesh.has_normals()) header += "property double nx\nproperty double ny\nproperty double nz\n";
    header +=
        fmt::format("element face {}\nproperty list {} {} vertex_indices\n", mesh.face_count(), count_type, index_type);
    if (mesh.has_uvs()) header += fmt::format("property list {} double texcoord\n", count_type);
    if (!mesh.face_material.empty()) header += "property int material_index\n";
    if (!mesh.face_group.empty()) header += "property int group_index\n";
    file.write(header + "end_header\n");

    write_in_pieces(file, split.count, context, 0.0, 0.5, [&](std::string& out, std::uint64_t v) {
        append_bytes(out, mesh.positions[split.original(v)]);
        if (mesh.has_normals()) append_bytes(out, mesh.normals[split.normal(v)]);
    });
    const auto append_count = [&](std::string& out, std::uint64_t count) {
        if (short_lists)
            append_bytes(out, static_cast<std::uint8_t>(count));
        else
            append_bytes(out, static_cast<std::uint32_t>(count));
    };
    write_in_pieces(file, mesh.face_count(), context, 0.5, 1.0, [&](std::string& out, std::uint64_t f) {
        const std::uint64_t begin = mesh.face_begin(f), end = mesh.face_end(f);
        append_count(out, end - begin);
        for (std::uint64_t c = begin; c < end; ++c)
            append_bytes(out, split.corner_vertex.empty() ? mesh.corners[c] : split.corner_vertex[c]);
        if (mesh.has_uvs()) {
            append_count(out, 2 * (end - begin));
            for (std::uint64_t c = begin; c < end; ++c) append_bytes(out, mesh.uvs[mesh.corner_uvs[c]]);
        }
        if (!mesh.face_material.empty()) append_bytes(out, mesh.face_material[f]);
        if (!mesh.face_group.empty()) append_bytes(out, mesh.face_group[f]);
    });
}

}  // namespace tetrakis::detail
