#include "mesh_reader.hpp"

#include "../../hier/base/files.hpp"
#include "mesh_codecs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdlib>

namespace tetrakis {

namespace detail {

bool take_number(std::string_view& text, double& value) {
    const char* begin = text.data();
    const char* end = begin + text.size();
    if (begin != end && *begin == '+') ++begin;
    const auto [next, error] = std::from_chars(begin, end, value);
    if (error == std::errc::invalid_argument) return false;
    if (error == std::errc::result_out_of_range) value = std::strtod(std::string(begin, next).c_str(), nullptr);
    text.remove_prefix(static_cast<std::size_t>(next - text.data()));
    return true;
}

bool take_integer(std::string_view& text, long long& value) {
    const char* begin = text.data();
    const char* end = begin + text.size();
    if (begin != end && *begin == '+') ++begin;
    const auto [next, error] = std::from_chars(begin, end, value);
    if (error != std::errc{}) return false;
    text.remove_prefix(static_cast<std::size_t>(next - text.data()));
    return true;
}

}  // namespace detail

TriangleMesh read_triangle_mesh(const std::filesystem::path& path, const RunContext& context) {
    std::string extension = path.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const bool obj = extension == ".obj", ply = extension == ".ply", gltf = extension == ".glb" || extension == ".gltf";
    if (!obj && !ply && !gltf)
        throw Error(ErrorCode::unsupported, "meshes are read from .obj, .ply, .glb and .gltf files", path);
    const std::string bytes = detail::read_file(path, context);
    if (bytes.empty()) throw Error(ErrorCode::invalid_input, "the file is empty", path);
    TriangleMesh mesh = obj   ? detail::decode_obj(bytes, path, context)
                        : ply ? detail::decode_ply(bytes, path, context)
                              : detail::decode_gltf(bytes, path);
    if (mesh.triangles.empty()) throw Error(ErrorCode::invalid_input, "the file has no faces", path);
    return mesh;
}

}  // namespace tetrakis
