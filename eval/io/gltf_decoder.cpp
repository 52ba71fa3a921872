#include "mesh_codecs.hpp"
#include "split_vertices.hpp"

#include <fmt/format.h>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>

#include <cmath>
#include <cstring>
#include <optional>

#include <tiny_gltf.h>

namespace tetrakis::detail {

namespace {

/// Reads a number from a buffer. Normalized integers are divided by the largest value of their type.
template <class T>
double number_at(const unsigned char* at, bool normalized) {
    T value;
    std::memcpy(&value, at, sizeof(T));
    const auto number = static_cast<double>(value);
    return normalized ? std::max(-1.0, number / static_cast<double>(std::numeric_limits<T>::max())) : number;
}
/// By component type, from TINYGLTF_COMPONENT_TYPE_BYTE on; null for a type that only tinygltf has (int).
constexpr decltype(&number_at<float>) k_number_at[] = {
    number_at<std::int8_t>,   number_at<std::uint8_t>, number_at<std::int16_t>, number_at<std::uint16_t>, nullptr,
    number_at<std::uint32_t>, number_at<float>};

class GltfDecoder {
  public:
    GltfDecoder(std::string_view bytes, const std::filesystem::path& path) : path_(path) { parse(bytes); }

    TriangleMesh run() {
        for (const std::string& extension : model_.extensionsRequired)
            if (extension == "KHR_draco_mesh_compression" || extension == "EXT_meshopt_compression")
                throw Error(ErrorCode::unsupported,
                            "the meshes are compressed (" + extension + "); export without compression", path_);
        visited_.assign(model_.nodes.size(), false);
        if (!model_.scenes.empty()) {
            const int scene = model_.defaultScene < 0 ? 0 : model_.defaultScene;
            for (const int root : item(model_.scenes, scene, "scene").nodes) visit(root, glm::dmat4(1));
        } else {
            std::vector<bool> is_child(model_.nodes.size(), false);
            for (const tinygltf::Node& node : model_.nodes)
                for (const int child : node.children)
                    if (child >= 0 && static_cast<std::size_t>(child) < is_child.size()) is_child[child] = true;
            for (std::size_t n = 0; n < is_child.size(); ++n)
                if (!is_child[n]) visit(static_cast<int>(n), glm::dmat4(1));
        }
        finish();
        return std::move(mesh_);
    }

  private:
    [[noreturn]] void reject(const std::string& text) const { throw Error(ErrorCode::invalid_input, text, path_); }

    void parse(std::string_view bytes) {
        if (bytes.size() > 0xFFFF'FFFFu) throw Error(ErrorCode::unsupported, "a glTF of more than 4 GiB", path_);
        tinygltf::TinyGLTF loader;
        // Pictures are not needed, so they are not decoded.
        loader.SetImageLoader([](tinygltf::Image*, const int, std::string*, std::string*, int, int,
                                 const unsigned char*, int, void*) { return true; },
                              nullptr);
        std::string problem, warning;
        const auto length = static_cast<unsigned int>(bytes.size());
        const bool binary = bytes.substr(0, 4) == "glTF";
        if (binary) require_whole(bytes);
        const std::string base = path_.has_parent_path() ? path_.parent_path().string() : ".";
        bool good = false;
        try {
            good = binary
                       ? loader.LoadBinaryFromMemory(&model_, &problem, &warning,
                                                     reinterpret_cast<const unsigned char*>(bytes.data()), length, base)
                       : loader.LoadASCIIFromString(&model_, &problem, &warning, bytes.data(), length, base);
        } catch (const std::bad_alloc&) {
            throw;
        } catch (const std::exception& error) {  // from tinygltf's JSON library
            reject(std::string("malformed glTF: ") + error.what());
        }
        while (!problem.empty() && problem.back() == '\n') problem.pop_back();
        if (!good)
            reject("malformed glTF: " + (problem.empty() ? "the file may be cut short" : problem) +
                   "; export it again, or see what a glTF validator says");
    }

    /// Checks the length in the header of a binary file: 12 bytes of magic number, version and length, little-endian.
    void require_whole(std::string_view bytes) const {
        constexpr std::size_t k_header = 12;
        std::uint32_t length = k_header;
        if (bytes.size() >= k_header) std::memcpy(&length, &bytes[8], sizeof(length));
        if (bytes.size() < length)
            reject(fmt::format("the file is cut short: {} of {} bytes are there; copy or export it again", bytes.size(),
                               length));
    }

    template <class T>
    const T& item(const std::vector<T>& items, int index, const char* what) const {
        if (index < 0 || static_cast<std::size_t>(index) >= items.size())
            reject(fmt::format("there is no {} number {}; the file has {}", what, index, items.size()));
        return items[static_cast<std::size_t>(index)];
    }

    static glm::dmat4 transform_of(const tinygltf::Node& node) {
        if (node.matrix.size() == 16) return glm::make_mat4(node.matrix.data());
        glm::dmat4 result(1);
        if (node.translation.size() == 3)
            result[3] = {node.translation[0], node.translation[1], node.translation[2], 1};
        if (node.rotation.size() == 4)
            result *=
                glm::mat4_cast(glm::dquat(node.rotation[3], node.rotation[0], node.rotation[1], node.rotation[2]));
        if (node.scale.size() == 3)
            for (int axis = 0; axis < 3; ++axis) result[axis] *= node.scale[axis];
        return result;
    }

    void visit(int root, const glm::dmat4& root_parent) {
        std::vector<std::pair<int, glm::dmat4>> open{{root, root_parent}};
        while (!open.empty()) {
            const auto [index, parent] = open.back();
            open.pop_back();
            const tinygltf::Node& node = item(model_.nodes, index, "node");
            if (visited_[index]) reject(fmt::format("node {} has two parents or is its own ancestor", index));
            visited_[index] = true;
            const glm::dmat4 here = parent * transform_of(node);
            if (node.mesh >= 0) add_mesh(item(model_.meshes, node.mesh, "mesh"), here, node.name);
            for (auto child = node.children.rbegin(); child != node.children.rend(); ++child)
                open.emplace_back(*child, here);
        }
    }

    // The numbers of an accessor; numbers() has checked that they lie within the buffer.
    struct Numbers {
        const unsigned char* data = nullptr;
        std::uint64_t count = 0, stride = 0;
        int component_type = 0, component_size = 0;
        bool normalized = false;

        double operator()(std::uint64_t i, int component) const {
            return k_number_at[component_type - TINYGLTF_COMPONENT_TYPE_BYTE](
                data + i * stride + component * component_size, normalized);
        }
    };

    Numbers numbers(int index, int components, const char* what) const {
        const tinygltf::Accessor& accessor = item(model_.accessors, index, "accessor");
        if (accessor.sparse.isSparse)
            throw Error(ErrorCode::unsupported, fmt::format("accessor {} is sparse; export without it", index), path_);
        const tinygltf::BufferView& view = item(model_.bufferViews, accessor.bufferView, "buffer view");
        const tinygltf::Buffer& buffer = item(model_.buffers, view.buffer, "buffer");
        const int component_size =
            tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(accessor.componentType));
        const int found = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type));
        const auto type = static_cast<std::size_t>(accessor.componentType - TINYGLTF_COMPONENT_TYPE_BYTE);
        if (type >= std::size(k_number_at) || k_number_at[type] == nullptr || found != components)
            reject(fmt::format("accessor {} has the wrong type for a {}", index, what));
        const auto element = static_cast<std::uint64_t>(component_size * components);
        const std::uint64_t stride = view.byteStride == 0 ? element : view.byteStride;
        const std::uint64_t available = view.byteLength;
        if (view.byteOffset > buffer.data.size() || available > buffer.data.size() - view.byteOffset)
            reject(fmt::format("buffer view {} exceeds its buffer; the file may be cut short", accessor.bufferView));
        if (accessor.byteOffset > available || stride < element ||
            (accessor.count > 0 && (available - accessor.byteOffset < element ||
                                    accessor.count - 1 > (available - accessor.byteOffset - element) / stride)))
            reject(fmt::format("accessor {} exceeds its buffer view", index));
        const Numbers result{buffer.data.data() + view.byteOffset + accessor.byteOffset,
                             accessor.count,
                             stride,
                             accessor.componentType,
                             component_size,
                             accessor.normalized && component_size < 4};
        for (std::uint64_t i = 0; i < result.count; ++i)
            for (int c = 0; c < components; ++c)
                if (!std::isfinite(result(i, c)))
                    reject(fmt::format("{} {} of accessor {} is not finite", what, i, index));
        return result;
    }

    // Vertices added before with the same transform: primitives often share vertices.
    struct Vertices {
        int positions, normals, uvs;
        glm::dmat4 transform;
        std::uint32_t first, count;
        std::optional<std::uint32_t> first_uv;
    };

    const Vertices& add_vertices(const tinygltf::Primitive& primitive, const glm::dmat4& transform) {
        const auto attribute = [&](const char* name) {
            const auto found = primitive.attributes.find(name);
            return found == primitive.attributes.end() ? -1 : found->second;
        };
        Vertices vertices{attribute("POSITION"), attribute("NORMAL"), attribute("TEXCOORD_0"), transform, 0, 0, {}};
        for (const Vertices& known : vertices_)
            if (known.positions == vertices.positions && known.normals == vertices.normals &&
                known.uvs == vertices.uvs && known.transform == transform)
                return known;
        const Numbers positions = numbers(vertices.positions, 3, "position");
        if (mesh_.positions.size() + positions.count > k_most_elements)
            throw Error(ErrorCode::unsupported, "too many vertices", path_);
        vertices.first = static_cast<std::uint32_t>(mesh_.positions.size());
        vertices.count = static_cast<std::uint32_t>(positions.count);
        for (std::uint64_t i = 0; i < positions.count; ++i) {
            const Vec3d p(transform * glm::dvec4(positions(i, 0), positions(i, 1), positions(i, 2), 1));
            if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
                reject(fmt::format("vertex {} of accessor {} is not finite", i, vertices.positions));
            mesh_.positions.push_back(p);
        }
        add_normals(vertices, transform);
        if (vertices.uvs >= 0) {
            const Numbers uvs = numbers(vertices.uvs, 2, "texture coordinate");
            if (uvs.count != positions.count) reject("a mesh has fewer texture coordinates than positions");
            vertices.first_uv = static_cast<std::uint32_t>(mesh_.uvs.size());
            for (std::uint64_t i = 0; i < uvs.count; ++i) mesh_.uvs.emplace_back(uvs(i, 0), 1 - uvs(i, 1));
        }
        vertices_.push_back(vertices);
        return vertices_.back();
    }

    void add_normals(const Vertices& vertices, const glm::dmat4& transform) {
        if (vertices.normals < 0) {
            has_all_normals_ = false;
            mesh_.normals.resize(mesh_.positions.size(), Vec3d(0));
            return;
        }
        const Numbers normals = numbers(vertices.normals, 3, "normal");
        if (normals.count != vertices.count) reject("a mesh has fewer normals than positions");
        const glm::dmat3 linear(transform);
        const bool identity = linear == glm::dmat3(1);
        const glm::dmat3 cofactors(glm::cross(linear[1], linear[2]), glm::cross(linear[2], linear[0]),
                                   glm::cross(linear[0], linear[1]));
        const double sign = glm::determinant(linear) < 0 ? -1 : 1;
        for (std::uint64_t i = 0; i < normals.count; ++i) {
            Vec3d n(normals(i, 0), normals(i, 1), normals(i, 2));
            if (!identity) {
                n = sign * (cofactors * n);
                const double length = glm::length(n);
                if (length > 0) n /= length;
            }
            mesh_.normals.push_back(n);
        }
    }

    void add_mesh(const tinygltf::Mesh& mesh, const glm::dmat4& transform, const std::string& name) {
        const bool mirrored = glm::determinant(glm::dmat3(transform)) < 0;
        const auto group = static_cast<std::uint32_t>(mesh_.groups.size());
        mesh_.groups.push_back(name.empty() ? "unnamed" : name);
        named_ = named_ || !name.empty();
        for (const tinygltf::Primitive& primitive : mesh.primitives) {
            const int mode = primitive.mode;
            if (mode != TINYGLTF_MODE_TRIANGLES && mode != TINYGLTF_MODE_TRIANGLE_STRIP &&
                mode != TINYGLTF_MODE_TRIANGLE_FAN)
                continue;  // points and lines are ignored
            const Vertices vertices = add_vertices(primitive, transform);
            std::optional<Numbers> indices;
            if (primitive.indices >= 0) {
                indices = numbers(primitive.indices, 1, "vertex index");
                if (indices->component_type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE &&
                    indices->component_type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
                    indices->component_type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
                    reject(fmt::format("accessor {} has the wrong type for a vertex index", primitive.indices));
                indices->normalized = false;
            }
            const std::uint64_t count = indices ? indices->count : vertices.count;
            const std::uint32_t material = primitive.material < 0
                                               ? static_cast<std::uint32_t>(model_.materials.size())
                                               : (item(model_.materials, primitive.material, "material"),
                                                  static_cast<std::uint32_t>(primitive.material));
            has_material_ = has_material_ || primitive.material >= 0;
            const auto index = [&](std::uint64_t i) {
                const auto v = indices ? static_cast<std::uint64_t>((*indices)(i, 0)) : i;
                if (v >= vertices.count)
                    reject(fmt::format("a triangle uses vertex {}, but its mesh has {}", v, vertices.count));
                return static_cast<std::uint32_t>(v);
            };
            const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
                if (mirrored) std::swap(b, c);
                mesh_.triangles.push_back({vertices.first + a, vertices.first + b, vertices.first + c});
                if (vertices.first_uv) {
                    const std::uint32_t uv = *vertices.first_uv;
                    mesh_.triangle_uvs.push_back({uv + a, uv + b, uv + c});
                }
                mesh_.triangle_material.push_back(material);
                mesh_.triangle_group.push_back(group);
            };
            if (mode == TINYGLTF_MODE_TRIANGLES && count % 3 != 0)
                reject(fmt::format("{} vertex indices are no whole number of triangles", count));
            for (std::uint64_t i = 0; i + 2 < count; i += mode == TINYGLTF_MODE_TRIANGLES ? 3 : 1) {
                // Every second triangle of a strip has the opposite orientation.
                const std::uint64_t odd = mode == TINYGLTF_MODE_TRIANGLE_STRIP ? i % 2 : 0;
                add(index(mode == TINYGLTF_MODE_TRIANGLE_FAN ? 0 : i + odd), index(i + 1 - odd), index(i + 2));
            }
        }
    }

    void finish() {
        if (!has_all_normals_) mesh_.normals.clear();
        if (mesh_.triangle_uvs.size() != mesh_.triangles.size()) {
            mesh_.triangle_uvs.clear();
            mesh_.uvs.clear();
        }
        if (!named_) mesh_.groups.clear(), mesh_.triangle_group.clear();
        if (has_material_) {
            for (const tinygltf::Material& material : model_.materials) mesh_.materials.push_back(material.name);
            if (std::ranges::count(mesh_.triangle_material, model_.materials.size()) != 0)
                mesh_.materials.push_back("default");  // for primitives without one
        } else {
            mesh_.triangle_material.clear();
        }
        join_split_vertices(mesh_);
    }

    const std::filesystem::path& path_;
    tinygltf::Model model_;
    TriangleMesh mesh_;
    std::vector<Vertices> vertices_;
    std::vector<bool> visited_;
    bool has_all_normals_ = true, named_ = false, has_material_ = false;
};

}  // namespace

TriangleMesh decode_gltf(std::string_view bytes, const std::filesystem::path& path) {
    return GltfDecoder(bytes, path).run();
}

}  // namespace tetrakis::detail
