#pragma once

#include "../lod_surfaces/surface.hpp"
#include "../terrain/height_grid.hpp"

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

namespace tetrakis::lod {

struct TiledTerrainOptions {
    std::uint64_t cache_bytes = std::uint64_t{512} << 20;  ///< of tiles in memory, never more
    /// Before a tile that could not be loaded is tried again; doubled each time, up to 64 times as long.
    std::chrono::milliseconds pause{50};
    /// Reads the file's bytes from an offset on, instead of the file itself; called by the loading thread alone, and
    /// may take its time or throw.
    std::function<void(std::uint64_t offset, std::span<std::byte> bytes)> read{};
};

/// How loading goes.
struct TileStatistics {
    std::uint64_t loads = 0, failures = 0;  ///< tiles so far
    std::uint64_t wanted = 0;               ///< tiles that were asked for and are not there yet
    std::uint64_t cached_bytes = 0;
    std::string last_error;
};

/// A terrain of write_tiles() that need not fit into memory. The coarsest levels are read at once; a thread of its own
/// loads other tiles as they are asked for, coarse ones first, and drops those that were not asked for the longest
/// time. No other call waits for the disk. What cannot be read, or has a wrong checksum, is tried again and again.
///
/// A diamond's error is an upper bound, vertically: the sum of what splits change on the way to the samples.
class TiledTerrain final : public Terrain {
  public:
    /// @throws Error  io; invalid_input: no tile file, or one that is cut off or damaged; unsupported: of another
    ///                version; memory_limit: cache_bytes are too few
    explicit TiledTerrain(const std::filesystem::path& path, TiledTerrainOptions options = {});
    ~TiledTerrain() override;  ///< waits for a tile that is being read
    TiledTerrain(const TiledTerrain&) = delete;
    TiledTerrain& operator=(const TiledTerrain&) = delete;

    std::optional<GroundPoint> at(const Vec2d& place) const override;
    const ControlMesh& roots() const override;
    int max_depth() const override;
    void places(std::span<const Site> sites, std::span<Place> places) const override;
    void bounds(std::span<const Site> sites, std::span<DiamondBounds> bounds) const override;
    std::uint64_t revision() const override;
    std::uint64_t begin_use() const override;
    void end_use(std::uint64_t use) const override;

    const HeightGrid& frame() const;               ///< the grid, without its heights
    std::array<double, 2> lowest_highest() const;  ///< heights
    TileStatistics statistics() const;
    /// For programs that want all of a picture: returns when another update of a view gets on, as revision() has
    /// changed or nothing is to be loaded; or after the longest time.
    void wait(std::uint64_t revision, std::chrono::milliseconds longest = std::chrono::seconds(10)) const;

  private:
    class Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace tetrakis::lod
