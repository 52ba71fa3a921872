#pragma once

#include "../../hier/base/files.hpp"
#include "../../hier/base/vec.hpp"
#include "../surface/local_frame.hpp"
#include "terrain_lattice.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// A point of the lattice as a tile stores it.
struct TilePoint {
    float height = 0;
    std::uint32_t packed = 0;  ///< lowest 12 bits: error of its diamond; then twice 10 bits: its normal

    /// Stores a float without its sign and its lowest 19 bits, rounded up by at most a sixteenth.
    void set_error(double error) {
        packed = (packed & ~0xFFFu) | (std::bit_cast<std::uint32_t>(round_up(error)) + k_rest) >> k_digits;
    }
    double error() const { return double{std::bit_cast<float>((packed & 0xFFFu) << k_digits)}; }

    /// Maps the normal to the upper half of an octahedron, whose ground plan is a square that stands on a corner.
    void set_normal(const Vec3d& n) {
        const double sum = std::abs(n.x) + std::abs(n.y) + n.z;
        const auto digits = [&](double v) { return static_cast<std::uint32_t>(std::lround((v / sum + 1) * k_half)); };
        packed = (packed & 0xFFFu) | digits(n.x + n.y) << 12 | digits(n.x - n.y) << 22;
    }
    Vec3d normal() const {
        const double u = (packed >> 12 & 0x3FFu) / k_half - 1, v = (packed >> 22) / k_half - 1;
        const double x = (u + v) / 2, y = (u - v) / 2;
        return glm::normalize(Vec3d(x, y, 1 - std::abs(x) - std::abs(y)));
    }

  private:
    static constexpr int k_digits = 19;
    static constexpr std::uint32_t k_rest = (1u << k_digits) - 1;
    static constexpr double k_half = 511;  // so that a normal straight up is exact
};
static_assert(sizeof(TilePoint) == 8);

/// The first bytes of a tile file, in the byte order of the machine that wrote it.
struct TileHeader {
    static constexpr std::array<char, 8> k_magic{'t', 'k', 't', 'i', 'l', 'e', 's', '\n'};
    static constexpr std::uint32_t k_version = 2, k_byte_order = 0x01020304;

    std::array<char, 8> magic = k_magic;
    std::uint32_t version = k_version, byte_order = k_byte_order;
    std::uint32_t columns = 0, rows = 0, side = 0;
    std::uint32_t checksum = 0;  ///< sum() when the file was written
    Vec2d spacing{}, origin{};

    /// Checksum of all members but `checksum`.
    std::uint32_t sum() const;
};
static_assert(sizeof(TileHeader) == 64);

/// The tiles of a file, and the offsets of their parts. Level k has the points whose lattice coordinates are multiples
/// of 2^k, and the diamonds whose step is 2^k. A tile has: the points of side * side squares of its level, border
/// points included; the lowest and highest heights of cells of 4 * 4 squares, with one more row of cells on each side;
/// and a checksum.
struct TileLayout {
    static constexpr int k_log_cell = 2;
    static constexpr std::int32_t k_cell = 1 << k_log_cell;
    struct Level {
        std::int32_t last_x = 0, last_y = 0;  ///< largest coordinates of its points
        std::int32_t across = 0, down = 0;    ///< numbers of tiles along x and y
        std::uint64_t first_tile = 0;
    };
    /// Level of a tile, and the points of that level that it has.
    struct Frame {
        int level;
        GridRectangle points;
    };
    /// An array in a tile: rows of `row` records, of which `margin` are before a tile's own ones.
    struct Array {
        std::size_t offset = 0, record_bytes = 0;
        std::int32_t row = 0, shift = 0, margin = 0;  ///< shift: from a point's coordinates to those of its record

        /// Bytes from the beginning of a tile to a record.
        std::size_t place(const Frame& tile, std::int32_t x, std::int32_t y) const {
            const std::int32_t column = x - (tile.points.x0 >> shift) + margin,
                               line = y - (tile.points.y0 >> shift) + margin;
            return offset + record_bytes * static_cast<std::size_t>(line * row + column);
        }
    };

    TileLayout() = default;
    TileLayout(const TerrainLattice& lattice, std::int32_t side);

    std::int32_t side = 0;
    std::vector<Level> levels;
    std::uint64_t tile_count = 0;
    std::size_t tile_bytes = 0;
    Array points, cells;

    /// The tile of a level that owns the point.
    std::uint64_t tile(int level, std::int32_t x, std::int32_t y) const {
        const Level& l = levels[level];
        const std::int32_t c = std::min(x / side, l.across - 1), r = std::min(y / side, l.down - 1);
        return l.first_tile + static_cast<std::uint64_t>(r) * static_cast<std::uint64_t>(l.across) +
               static_cast<std::uint64_t>(c);
    }
    Frame frame(std::uint64_t tile) const;
    std::uint64_t offset(std::uint64_t tile) const { return sizeof(TileHeader) + tile * tile_bytes; }
    std::uint64_t file_bytes() const { return offset(tile_count); }
};

/// A tile's records. A layout must outlive its tiles.
class Tile {
  public:
    Tile(const TileLayout& layout, std::uint64_t number)
        : frame(layout.frame(number)), layout_(&layout), bytes_(layout.tile_bytes / sizeof(std::uint64_t)) {}

    TileLayout::Frame frame;

    std::span<std::byte> bytes() { return std::as_writable_bytes(std::span(bytes_)); }
    /// @param x, y  coordinates in its level
    TilePoint& point(std::int32_t x, std::int32_t y) { return record<TilePoint>(layout_->points, x, y); }
    HeightRange& cell(std::int32_t x, std::int32_t y) { return record<HeightRange>(layout_->cells, x, y); }
    /// By coordinates in the lattice.
    TilePoint& point(LatticePlace p) { return point(p.x >> frame.level, p.y >> frame.level); }
    /// Lowest and highest heights of all cells that overlap the open rectangle of the lattice.
    HeightRange heights(const GridRectangle& within) {
        const int shift = frame.level + TileLayout::k_log_cell;
        return heights_over(
            {within.x0 >> shift, (within.x1 - 1) >> shift, within.y0 >> shift, (within.y1 - 1) >> shift},
            [&](std::int32_t x, std::int32_t y) { return cell(x, y); });
    }
    void seal() { bytes_.back() = checksum(); }
    bool is_sealed() const { return bytes_.back() == checksum(); }

  private:
    template <class Record>
    Record& record(const TileLayout::Array& array, std::int32_t x, std::int32_t y) {
        return *reinterpret_cast<Record*>(bytes().data() + array.place(frame, x, y));
    }
    std::uint64_t checksum() const;

    const TileLayout* layout_;
    std::vector<std::uint64_t> bytes_;
};

/// A file that several threads may read and write at any offset at once.
class TileFile {
  public:
    /// Opens an existing file and reads its header. @throws Error  io, invalid_input, unsupported
    TileFile(const std::filesystem::path& path, TileHeader& header);
    /// Creates a file, which appears by commit(). @throws Error io
    explicit TileFile(const std::filesystem::path& path);
    ~TileFile();
    TileFile(const TileFile&) = delete;
    TileFile& operator=(const TileFile&) = delete;

    /// Bytes of an existing file, when it was opened.
    std::uint64_t size() const { return size_; }
    /// @throws Error io
    void read(std::uint64_t offset, std::span<std::byte> bytes) const;
    void write(std::uint64_t offset, std::span<const std::byte> bytes);
    void commit() { output_->commit(); }
    const std::filesystem::path& path() const { return path_; }

  private:
    [[noreturn]] void fail(const char* what) const;

    std::filesystem::path path_;
    std::uint64_t size_ = 0;
    std::optional<AtomicFile> output_;  // of a new file
    int descriptor_ = -1;
};

}  // namespace tetrakis::detail
