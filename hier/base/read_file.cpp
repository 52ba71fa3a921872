#include "read_file.hpp"

#include "error.hpp"

#include <fmt/format.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>

namespace tetrakis::detail {

std::string read_file(const std::filesystem::path& path, const RunContext& context) {
    struct Descriptor {
        int value;
        ~Descriptor() {
            if (value >= 0) ::close(value);
        }
    } file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
    if (file.value < 0)
        throw Error(ErrorCode::io,
                    errno == ENOENT ? "there is no such file; check the path" : std::string(std::strerror(errno)),
                    path);
    struct stat there {};
    if (::fstat(file.value, &there) == 0 && S_ISDIR(there.st_mode))
        throw Error(ErrorCode::io, "this is a directory; give a file", path);
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

}  // namespace tetrakis::detail
