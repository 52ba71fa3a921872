#include "tile_file.hpp"

#include "../../hier/base/error.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

namespace tetrakis::detail {

TileLayout::TileLayout(const TerrainLattice& lattice, std::int32_t tile_side) : side(tile_side) {
    for (int k = 0; k < lattice.log_side; ++k) {
        Level level{lattice.last_x() >> k, lattice.last_y() >> k, 0, 0, tile_count};
        level.across = (level.last_x + side - 1) / side;
        level.down = (level.last_y + side - 1) / side;
        tile_count += static_cast<std::uint64_t>(level.across) * static_cast<std::uint64_t>(level.down);
        levels.push_back(level);
    }
    const auto bytes = [](const Array& array) {
        return array.record_bytes * static_cast<std::size_t>(array.row) * static_cast<std::size_t>(array.row);
    };
    points = {0, sizeof(TilePoint), side + 1, 0, 0};
    cells = {bytes(points), sizeof(HeightRange), side / k_cell + 2, k_log_cell, 1};
    tile_bytes = cells.offset + bytes(cells) + sizeof(std::uint64_t);
}

TileLayout::Frame TileLayout::frame(std::uint64_t tile) const {
    int k = 0;
    while (k + 1 < std::ssize(levels) && levels[k + 1].first_tile <= tile) ++k;
    const Level& level = levels[k];
    const auto number = static_cast<std::int32_t>(tile - level.first_tile);
    const std::int32_t x = number % level.across * side, y = number / level.across * side;
    return {k, {x, std::min(x + side, level.last_x), y, std::min(y + side, level.last_y)}};
}

namespace {

/// As FNV, for words: the rotation makes the order of words count, and an odd factor loses no bits.
std::uint64_t checksum_of(std::span<const std::uint64_t> words) {
    std::uint64_t sum = words.size() + 1;
    for (const std::uint64_t word : words) sum = (std::rotl(sum, 23) ^ word) * 0x9E3779B97F4A7C15u;
    return sum;
}

}  // namespace

std::uint64_t Tile::checksum() const { return checksum_of(std::span(bytes_).first(bytes_.size() - 1)); }

std::uint32_t TileHeader::sum() const {
    TileHeader other = *this;
    other.checksum = 0;
    return static_cast<std::uint32_t>(
        checksum_of(std::bit_cast<std::array<std::uint64_t, sizeof(TileHeader) / sizeof(std::uint64_t)>>(other)) >> 32);
}

TileFile::TileFile(const std::filesystem::path& path, TileHeader& header)
    : path_(path), descriptor_(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)) {
    if (descriptor_ < 0) fail(errno == ENOENT ? "there is no such file; check the path" : std::strerror(errno));
    const auto refuse = [&](ErrorCode code, const std::string& text) {
        ::close(descriptor_);
        throw Error(code, text, path_);
    };
    struct stat there {};
    if (::fstat(descriptor_, &there) != 0 || !S_ISREG(there.st_mode)) refuse(ErrorCode::io, "this is no regular file");
    size_ = static_cast<std::uint64_t>(there.st_size);
    const auto got = ::pread(descriptor_, &header, sizeof header, 0);
    if (got < static_cast<ssize_t>(sizeof header.magic) || header.magic != TileHeader::k_magic)
        refuse(ErrorCode::invalid_input, "this is no tile file; write_tiles() makes one of heights");
    if (got < static_cast<ssize_t>(sizeof header)) refuse(ErrorCode::invalid_input, "the tile file is cut off");
    if (header.byte_order != TileHeader::k_byte_order)
        refuse(ErrorCode::unsupported, "the tile file is from a machine with another byte order; make it anew");
    if (header.version != TileHeader::k_version)
        refuse(ErrorCode::unsupported, fmt::format("the tile file has version {}, and this build reads version {}",
                                                   header.version, TileHeader::k_version));
    if (header.checksum != header.sum()) refuse(ErrorCode::invalid_input, "the tile file is damaged: its header");
}

TileFile::TileFile(const std::filesystem::path& path) : path_(path) {
    std::error_code none;
    if (const auto there = std::filesystem::status(path, none);
        std::filesystem::exists(there) && !std::filesystem::is_regular_file(there))
        throw Error(ErrorCode::io, "this is no regular file, as tile files have to be", path);
    output_.emplace(path);
    descriptor_ = output_->descriptor();
}

TileFile::~TileFile() {
    if (!output_) ::close(descriptor_);
}

void TileFile::read(std::uint64_t offset, std::span<std::byte> bytes) const {
    while (!bytes.empty()) {
        const ssize_t got = ::pread(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) fail(got == 0 ? "the tile file is cut off" : std::strerror(errno));
        bytes = bytes.subspan(static_cast<std::size_t>(got));
        offset += static_cast<std::uint64_t>(got);
    }
}

void TileFile::write(std::uint64_t offset, std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t put = ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
        if (put < 0 && errno == EINTR) continue;
        if (put < 0) fail("cannot be written");
        bytes = bytes.subspan(static_cast<std::size_t>(put));
        offset += static_cast<std::uint64_t>(put);
    }
}

void TileFile::fail(const char* what) const {
    const int number = errno;
    throw Error(ErrorCode::io, output_ ? fmt::format("{}: {}", what, std::strerror(number)) : std::string(what), path_);
}

}  // namespace tetrakis::detail
