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
    std::uint64_t cache_bytes = std::uint64_t{512} << 20;  ///< limit for the tiles in memory
    /// Pause before a failed tile is loaded again. It doubles with each failure, up to 64 times this value.
    std::chrono::milliseconds pause{50};
    /// Replaces reading of the file: fills `bytes` from `offset` of the file on. Called by the loading thread alone;
    /// may be slow or throw.
    std::function<void(std::uint64_t offset, std::span<std::byte> bytes)> read{};
};

/// Counts of loaded and requested tiles.
struct TileStatistics {
    std::uint64_t loads = 0, failures = 0;  ///< successful and failed reads of tiles so far
    std::uint64_t wanted = 0;               ///< tiles that are requested and not loaded yet
    std::uint64_t cached_bytes = 0;
    std::string last_error;
};

/// A terrain from a file of write_tiles(), which need not fit into memory. The constructor reads the coarsest levels. A
/// thread loads other tiles on request, coarse ones first, and drops the least recently requested ones. No call but the
/// constructor and wait() waits for the disk; all calls may come from several threads at once. A tile that cannot be
/// read, or has a wrong checksum, is tried again and again.
///
/// A diamond's error is a vertical upper bound, from the errors of finer diamonds (lemma in README.md).
class TiledTerrain final : public Terrain {
  public:
    /// @throws Error  io; invalid_input: no tile file, or a damaged or incomplete one; unsupported: of another
    ///                version; memory_limit: cache_bytes are too few
    explicit TiledTerrain(const std::filesystem::path& path, TiledTerrainOptions options = {});
    ~TiledTerrain() override;  ///< waits until a tile that is being read is finished
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
    std::array<double, 2> lowest_highest() const;  ///< the lowest and the highest height
    TileStatistics statistics() const;
    /// For programs that need a complete picture: returns when View::update() can make progress, because revision()
    /// differs from `revision`, no tile is requested, or the loader waits for uses; or after the time `longest`, of at
    /// most a day.
    void wait(std::uint64_t revision, std::chrono::milliseconds longest = std::chrono::seconds(10)) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace tetrakis::lod
