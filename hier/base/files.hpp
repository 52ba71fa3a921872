#pragma once

#include "run_context.hpp"

#include <cstdint>
#include <filesystem>
#include <list>
#include <span>
#include <string>
#include <string_view>

namespace tetrakis::detail {

/// The bytes of a file, a pipe or a device; progress goes from 0 to 0.3 of the stage "load".
/// @throws Error io: no such file, a directory, not readable; memory_limit; cancelled
std::string read_file(const std::filesystem::path& path, const RunContext& context = {});

/// The extension of a file's name, in lower case: ".obj" for "A.OBJ".
std::string lower_extension(const std::filesystem::path& path);

}  // namespace tetrakis::detail

namespace tetrakis {

/// A file that appears whole or not at all. Bytes go to a temporary name in the same directory; commit() flushes them
/// to the disk, checks, and renames. Without commit() (an exception, say) the temporary file is removed and a file that
/// was there before stays as it was. A device or pipe is written straight through; a symbolic link stays a link.
class AtomicFile {
  public:
    /// @throws Error io: no such directory, a directory of that name, not writable
    explicit AtomicFile(const std::filesystem::path& path);
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    /// @throws Error io: disk full, file too large, device failure
    void write(std::span<const std::byte> bytes);
    void write(std::string_view text) { write(std::as_bytes(std::span(text))); }
    /// Flushes the file to the disk and closes it, as commit() does first: errors of writing are reported here.
    /// @throws Error io
    void finish();
    /// Makes the file appear. @throws Error io
    void commit();

    const std::filesystem::path& path() const { return path_; }  ///< as given
    std::uint64_t size() const { return size_; }
    int descriptor() const { return descriptor_; }  ///< open until finish(); of a regular file, for reading, too

  private:
    [[noreturn]] void fail(const char* what) const;

    std::filesystem::path path_, target_, temporary_;  // as given; with links resolved; empty when written through
    std::uint64_t size_ = 0;
    int descriptor_ = -1;
};

/// Files that belong together and appear together: all are written and on the disk before the first gets its name, so
/// that a file that fails leaves none of them.
class FileSet {
  public:
    /// Adds a file to the set; the reference is valid as long as the set.
    /// @throws Error io: as AtomicFile; the set has a file of that name already
    AtomicFile& add(const std::filesystem::path& path);
    /// AtomicFile::finish() for all. @throws Error io
    void finish();
    /// Makes all appear. @throws Error io
    void commit();

  private:
    std::list<AtomicFile> files_;
};

/// Writes a whole file in one go, by the rules of AtomicFile.
void write_file(const std::filesystem::path& path, std::string_view bytes);

/// Finds out before long work whether `path` could be written: its directory exists and is writable, and what is there
/// now may be replaced. Leaves nothing behind. @throws Error io
void check_writable(const std::filesystem::path& path);

}  // namespace tetrakis
