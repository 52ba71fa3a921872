#include "files.hpp"

#include "error.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cctype>
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
    std::string bytes(size + 1, '\0');  // with room to find the end; pipes and growing files have no size to rely on
    std::size_t filled = 0;
    for (;;) {
        context.report("load", 0.3 * static_cast<double>(filled) / static_cast<double>(bytes.size()));
        if (filled == bytes.size()) bytes.resize(filled + k_block);
        const ssize_t got = ::read(file.value, bytes.data() + filled, std::min(k_block, bytes.size() - filled));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) throw Error(ErrorCode::io, std::strerror(errno), path);
        if (got == 0) break;
        filled += static_cast<std::size_t>(got);
    }
    bytes.resize(filled);
    return bytes;
}

std::string lower_extension(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    std::ranges::transform(extension, extension.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension;
}

}  // namespace tetrakis::detail

namespace tetrakis {

namespace fs = std::filesystem;

namespace {

// Linux moves at most about 2 GiB per call anyway; smaller pieces let a signal in between.
constexpr std::size_t k_most_per_write = std::size_t{1} << 30;

// Links are followed, so that the file they name is replaced and not the link; a dangling link names the file to make.
fs::path resolve_links(fs::path path) {
    constexpr int k_most_links = 40;  // what Linux itself follows
    std::error_code error;
    for (int i = 0; i < k_most_links && fs::is_symlink(fs::symlink_status(path, error)); ++i) {
        const fs::path link = fs::read_symlink(path, error);
        if (error) break;
        path = link.is_absolute() ? link : path.parent_path() / link;
    }
    return path;
}

}  // namespace

AtomicFile::AtomicFile(const fs::path& path) : path_(path), target_(resolve_links(path)) {
    if (!target_.has_filename())
        throw Error(ErrorCode::io,
                    path.empty() ? "the name of the output file is empty" : "this names a directory, not a file", path);
    const fs::path directory = target_.has_parent_path() ? target_.parent_path() : fs::path(".");
    struct stat there {};
    if (::stat(directory.c_str(), &there) != 0)
        throw Error(ErrorCode::io,
                    errno == ENOENT ? fmt::format("there is no directory {}; create it first", directory.string())
                                    : fmt::format("cannot enter {}: {}", directory.string(), std::strerror(errno)),
                    path);
    if (!S_ISDIR(there.st_mode))
        throw Error(ErrorCode::io, fmt::format("{} is not a directory", directory.string()), path);
    const bool exists = ::stat(target_.c_str(), &there) == 0;
    if (exists && S_ISDIR(there.st_mode)) throw Error(ErrorCode::io, "this is a directory; name a file", path);
    if (exists && !S_ISREG(there.st_mode)) {
        descriptor_ = ::open(target_.c_str(), O_WRONLY | O_CLOEXEC);
        if (descriptor_ < 0) fail("cannot open");
        return;
    }
    // Renaming would get around the write protection of the file itself: the user meant it.
    if (exists && ::access(target_.c_str(), W_OK) != 0)
        throw Error(ErrorCode::io, "the file is write-protected; change its mode or choose another name", path);
    static std::atomic<unsigned> counter{0};
    constexpr int k_attempts = 1000;  // names left over by processes that were killed
    for (int i = 0; i < k_attempts && descriptor_ < 0; ++i) {
        temporary_ = directory / fmt::format(".tetrakis-{}-{}.tmp", ::getpid(), counter++);
        descriptor_ = ::open(temporary_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (descriptor_ < 0 && errno != EEXIST) break;
    }
    if (descriptor_ < 0) {
        temporary_.clear();
        fail("cannot create the file");
    }
    if (exists) (void)::fchmod(descriptor_, there.st_mode & 07777);  // a replaced file keeps its mode where it can
}

AtomicFile::~AtomicFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void AtomicFile::write(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t written = ::write(descriptor_, bytes.data(), std::min(bytes.size(), k_most_per_write));
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) fail("cannot write");
        size_ += static_cast<std::uint64_t>(written);
        bytes = bytes.subspan(static_cast<std::size_t>(written));
    }
}

void AtomicFile::finish() {
    if (descriptor_ < 0) return;
    // Some file systems report a full disk only now. Pipes and devices cannot be synchronised (EINVAL), nor need they.
    if (::fsync(descriptor_) != 0 && errno != EINVAL && errno != ENOTSUP) fail("cannot write");
    const int closed = ::close(descriptor_);
    descriptor_ = -1;
    if (closed != 0 && errno != EINTR) fail("cannot write");
}

void AtomicFile::commit() {
    finish();
    if (temporary_.empty()) return;
    if (::rename(temporary_.c_str(), target_.c_str()) != 0) fail("cannot put the finished file in place");
    temporary_.clear();
}

void AtomicFile::fail(const char* what) const {
    throw Error(ErrorCode::io, fmt::format("{}: {}", what, std::strerror(errno)), path_);
}

AtomicFile& FileSet::add(const fs::path& path) {
    const auto same = [&](const AtomicFile& file) {
        return fs::absolute(file.path()).lexically_normal() == fs::absolute(path).lexically_normal();
    };
    if (std::any_of(files_.begin(), files_.end(), same) && !fs::is_character_file(path))
        throw Error(ErrorCode::io, "two outputs have this name; give one of them another", path);
    return files_.emplace_back(path);
}

void FileSet::finish() {
    for (AtomicFile& file : files_) file.finish();
}

void FileSet::commit() {
    finish();
    for (AtomicFile& file : files_) file.commit();
}

void write_file(const fs::path& path, std::string_view bytes) {
    AtomicFile file(path);
    file.write(bytes);
    file.commit();
}

void check_writable(const fs::path& path) { AtomicFile{path}; }

}  // namespace tetrakis
