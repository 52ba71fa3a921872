#pragma once

#include "../../hier/base/vec.hpp"
#include "../terrain/height_grid.hpp"
#include "terrain_lattice.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// A point of the lattice as a tile stores it.
struct TilePoint {
    float height = 0;
    std::uint32_t packed = 0;  ///< lowest 12 bits: error of its diamond; then twice 10 bits: its normal

    /// Stores a float without its sign and its lowest 19 bits, rounded up by at most a sixteenth.
    void set_error(double error) {
        auto above = static_cast<float>(error);
        if (double{above} < error) above = std::nextafter(above, std::numeric_limits<float>::infinity());
        packed = (packed & ~0xFFFu) | (std::bit_cast<std::uint32_t>(above) + k_rest) >> k_digits;
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
    std::array<double, 2> spacing{}, origin{};

    /// Checksum of all members but `checksum`.
    std::uint32_t sum() const;
};
static_assert(sizeof(TileHeader) == 64);

/// The tiles of a file, and the offsets of their parts. Level k has the points whose lattice coordinates are multiples
/// of 2^k, and the diamonds whose step is 2^k. A tile has: the points of side * side squares of its level, border
/// points included; the lowest and highest heights of cells of 4 * 4 squares, with one more row of cells on each side;
/// and a checksum.
class TileLayout {
  public:
    static constexpr std::int32_t k_cell = 4;
    struct Level {
        std::int32_t last_x = 0, last_y = 0;  ///< largest coordinates of its points
        std::int32_t across = 0, down = 0;    ///< numbers of tiles along x and y
        std::uint64_t first_tile = 0;
    };
    /// An array in a tile: rows of `row` records.
    struct Array {
        std::size_t offset = 0, record_bytes = 0;
        std::int32_t row = 0, step = 0, margin = 0;  ///< records from tile to tile; before a tile's own ones
    };

    TileLayout() = default;
    TileLayout(const TerrainLattice& lattice, std::int32_t side);

    std::int32_t side() const { return side_; }
    const std::vector<Level>& levels() const { return levels_; }
    std::uint64_t tile_count() const { return tile_count_; }
    std::size_t tile_bytes() const { return tile_bytes_; }
    const Array& points() const { return points_; }
    const Array& cells() const { return cells_; }

    /// The tile of a level that owns the point.
    std::uint64_t tile(std::size_t level, std::int32_t x, std::int32_t y) const {
        const Level& l = levels_[level];
        const std::int32_t c = std::min(x / side_, l.across - 1), r = std::min(y / side_, l.down - 1);
        return l.first_tile + static_cast<std::uint64_t>(r) * static_cast<std::uint64_t>(l.across) +
               static_cast<std::uint64_t>(c);
    }
    std::uint64_t offset(std::uint64_t tile) const { return sizeof(TileHeader) + tile * tile_bytes_; }
    std::uint64_t file_bytes() const { return offset(tile_count_); }

  private:
    std::int32_t side_ = 0;
    std::vector<Level> levels_;
    std::uint64_t tile_count_ = 0;
    std::size_t tile_bytes_ = 0;
    Array points_, cells_;
};

/// A tile's bytes.
class Tile {
  public:
    explicit Tile(const TileLayout& layout) : bytes_(layout.tile_bytes() / sizeof(std::uint64_t)) {}

    std::span<std::byte> bytes() { return std::as_writable_bytes(std::span(bytes_)); }
    template <class T>
    T* records(const TileLayout::Array& array) {
        return reinterpret_cast<T*>(bytes().data() + array.offset);
    }
    template <class T>
    const T* records(const TileLayout::Array& array) const {
        return reinterpret_cast<const T*>(std::as_bytes(std::span(bytes_)).data() + array.offset);
    }
    void seal() { bytes_.back() = checksum(); }
    bool is_sealed() const { return bytes_.back() == checksum(); }

  private:
    std::uint64_t checksum() const;
    std::vector<std::uint64_t> bytes_;
};

/// A file that several threads may read and write at any offset at once.
class TileFile {
  public:
    /// Opens an existing file and reads its header. @throws Error  io, invalid_input, unsupported
    TileFile(const std::filesystem::path& path, TileHeader& header);
    /// Creates a file, which has a temporary name until commit(). @throws Error io
    explicit TileFile(const std::filesystem::path& path);
    ~TileFile();
    TileFile(const TileFile&) = delete;
    TileFile& operator=(const TileFile&) = delete;

    /// @throws Error io
    void read(std::uint64_t offset, std::span<std::byte> bytes) const;
    void write(std::uint64_t offset, std::span<const std::byte> bytes);
    void resize(std::uint64_t bytes);
    std::uint64_t size() const;
    void commit();
    const std::filesystem::path& path() const { return path_; }

  private:
    [[noreturn]] void fail(const char* what) const;

    std::filesystem::path path_, temporary_;
    int descriptor_ = -1;
};

}  // namespace tetrakis::detail
