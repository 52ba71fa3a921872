#include "mesh_reader.hpp"

#include "mesh_decoders.hpp"

#include <fmt/format.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>

namespace tetrakis {

namespace detail {

std::string read_file(const std::filesystem::path& path, const RunContext& context) {
    struct Descriptor {
        int value;
        ~Descriptor() {
            if (value >= 0) ::close(value);
        }
    } file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
    if (file.value < 0)
        throw Error(ErrorCode::io, errno == ENOENT ? "there is no such file" : std::string(std::strerror(errno)), path);
    struct stat there {};
    if (::fstat(file.value, &there) == 0 && S_ISDIR(there.st_mode))
        throw Error(ErrorCode::io, "this is a directory, not a file", path);
    const auto size = static_cast<std::uint64_t>(std::max<off_t>(0, there.st_size));
    if (context.max_memory_bytes > 0 && size > context.max_memory_bytes)
        throw Error(ErrorCode::memory_limit,
                    fmt::format("the file has {} bytes, the memory limit is {}", size, context.max_memory_bytes), path);
    constexpr std::size_t k_block = std::size_t{16} << 20;
    std::string bytes;
    bytes.resize(size);
    std::size_t filled = 0;
    for (;;) {  // pipes and growing files have no size to rely on
        if (filled == bytes.size()) {
            char probe;
            const ssize_t more = ::read(file.value, &probe, 1);
            if (more == 0) break;
            if (more > 0) {
                bytes.push_back(probe);
                ++filled;
                bytes.resize(filled + k_block);
                continue;
            }
            if (errno != EINTR) throw Error(ErrorCode::io, std::strerror(errno), path);
            continue;
        }
        context.report("load", 0.3 * static_cast<double>(filled) / static_cast<double>(bytes.size()));
        const ssize_t got = ::read(file.value, bytes.data() + filled, std::min(k_block, bytes.size() - filled));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) throw Error(ErrorCode::io, std::strerror(errno), path);
        if (got == 0) break;
        filled += static_cast<std::size_t>(got);
    }
    bytes.resize(filled);
    return bytes;
}

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
