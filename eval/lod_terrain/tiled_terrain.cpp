#include "tiled_terrain.hpp"

#include "../../hier/base/error.hpp"
#include "tile_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <condition_variable>
#include <mutex>
#include <stop_token>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

namespace tetrakis::lod {

namespace {

using detail::HeightRange;
using detail::LatticePlace;
using detail::Tile;
using Clock = std::chrono::steady_clock;

// A tile stays for this many uses after the last use that requested it. So a new tile is still there when the views
// that wait for it evaluate it, however small the cache is.
constexpr std::uint64_t k_uses_kept = 4;
constexpr std::uint64_t k_least_cached = 4;  // tiles of the cache that can be replaced
constexpr std::uint64_t k_none = ~std::uint64_t{0};

}  // namespace

/// What the loader shares with the callers of TiledTerrain.
struct TiledTerrain::Impl {
    /// A tile that has been requested.
    struct Entry {
        std::optional<Tile> tile{};  ///< nothing: not loaded yet
        std::uint64_t use = 0;       ///< the newest use when the tile was last requested; k_none: it always stays
        int failures = 0;
        Clock::time_point not_before{};
    };

    Impl(const std::filesystem::path& path, TiledTerrainOptions terrain_options)
        : options(std::move(terrain_options)), file(path, header) {
        const auto refuse = [&](ErrorCode code, const std::string& text) { throw Error(code, text, path); };
        frame = {header.columns, header.rows, {}, header.spacing, header.origin};
        try {
            detail::check_frame(frame);
        } catch (const Error& error) {
            refuse(ErrorCode::invalid_input, fmt::format("the tile file is damaged: {}", error.what()));
        }
        if (header.side < 16 || header.side > 1024 || !std::has_single_bit(header.side))
            refuse(ErrorCode::invalid_input, fmt::format("the tile file is damaged: tiles of {} steps", header.side));
        lattice = detail::TerrainLattice(frame);
        layout = detail::TileLayout(lattice, static_cast<std::int32_t>(header.side));
        if (file.size() != layout.file_bytes())
            refuse(ErrorCode::invalid_input, fmt::format("the tile file has {} bytes, not {}: it is cut off or damaged",
                                                         file.size(), layout.file_bytes()));
        // Levels of one tile always stay, and so does the coarsest level, which has the roots.
        const auto& levels = layout.levels;
        std::size_t k = levels.size() - 1;
        while (k > 0 && levels[k - 1].across == 1 && levels[k - 1].down == 1) --k;
        const std::uint64_t first_kept = levels[k].first_tile, kept = layout.tile_count - first_kept,
                            least = (kept + std::min(k_least_cached, first_kept) + 1) * layout.tile_bytes;
        if (options.cache_bytes < least)
            refuse(ErrorCode::memory_limit,
                   fmt::format("a cache of {} bytes is too small; it needs {} at least", options.cache_bytes, least));
        most_loaded = options.cache_bytes / layout.tile_bytes - 1;  // the loader reads into another one
        for (loaded = 0; loaded < kept; ++loaded) {
            const std::uint64_t number = first_kept + loaded;
            Tile& tile = tiles[number].tile.emplace(layout, number);
            tiles[number].use = k_none;
            file.read(layout.offset(number), tile.bytes());
            if (!tile.is_sealed())
                refuse(ErrorCode::invalid_input, fmt::format("tile {} of the tile file is damaged", number));
            const auto [x0, x1, y0, y1] = tile.frame.points;
            const int shift = tile.frame.level;
            heights.add(tile.heights({x0 << shift, x1 << shift, y0 << shift, y1 << shift}));
        }
        roots = lattice.make_roots([&](LatticePlace p) { return position(*find(p), p); });
        if (!options.read)
            options.read = [this](std::uint64_t offset, std::span<std::byte> bytes) { file.read(offset, bytes); };
        loader = std::jthread([this](const std::stop_token& stop) { load_tiles(stop); });
    }

    Vec3d position(Tile& tile, LatticePlace p) const { return lattice.position(p, double{tile.point(p).height}); }

    /// The tile of a level, by default the point's own, that has the point. Else nullptr, and the tile is requested.
    Tile* find(LatticePlace p, int level = 31) {
        level = std::min({level, std::countr_zero(static_cast<std::uint32_t>(p.x | p.y)),
                          static_cast<int>(layout.levels.size()) - 1});
        const auto [found, is_new] = tiles.try_emplace(layout.tile(level, p.x >> level, p.y >> level));
        Entry& entry = found->second;
        entry.use = std::max(entry.use, last_use);
        if (is_new) changed.notify_all();
        return entry.tile ? &*entry.tile : nullptr;
    }

    /// The tile to be loaded next, after its use: of the most recently requested ones, the last in the file, as no
    /// other is coarser.
    std::optional<std::pair<std::uint64_t, std::uint64_t>> next_want(Clock::time_point& earliest) const {
        std::optional<std::pair<std::uint64_t, std::uint64_t>> best;
        const auto now = Clock::now();
        earliest = now + std::chrono::hours(1);
        for (const auto& [number, entry] : tiles) {
            if (entry.tile) continue;
            if (entry.not_before > now)
                earliest = std::min(earliest, entry.not_before);
            else
                best = std::max(best, std::optional(std::pair(entry.use, number)));
        }
        return best;
    }

    /// Whether there is room for another tile. A full cache drops the least recently requested one unless it is used.
    bool make_room() {
        waits_for_use = false;
        if (loaded < most_loaded) return true;
        const auto latest = std::ranges::min_element(
            tiles, {}, [](const auto& entry) { return entry.second.tile ? entry.second.use : k_none; });
        const std::uint64_t oldest_use = uses.empty() ? last_use + 1 : *std::ranges::min_element(uses);
        waits_for_use = latest->second.use + k_uses_kept > oldest_use;
        if (waits_for_use) {
            arrived.notify_all();
        } else {
            tiles.erase(latest);
            --loaded;
        }
        return !waits_for_use;
    }

    void load_tiles(const std::stop_token& stop) {
        std::unique_lock lock(mutex);
        while (!stop.stop_requested()) {
            Clock::time_point earliest;
            const auto next = next_want(earliest);
            if (!next) {
                arrived.notify_all();
                changed.wait_until(lock, stop, earliest, [&, count = tiles.size()] { return tiles.size() != count; });
                continue;
            }
            const std::uint64_t number = next->second;
            lock.unlock();
            std::optional<Tile> tile;
            const std::string error = read(number, tile);
            lock.lock();
            Entry& entry = tiles[number];
            if (!error.empty()) {
                ++statistics.failures;
                statistics.last_error = error;
                entry.not_before = Clock::now() + options.pause * (1 << std::min(entry.failures, 6));
                ++entry.failures;
                continue;
            }
            if (!changed.wait(lock, stop, [&] { return make_room(); })) return;
            entry = {.tile = std::move(tile), .use = last_use};
            ++loaded;
            ++statistics.loads;
            ++revision;
            // Views that wait evaluate again now, and repeat the requests that still count; old requests are dropped.
            if (last_use >= last_drop + k_uses_kept) {
                std::erase_if(tiles,
                              [&](const auto& other) { return !other.second.tile && other.second.use <= last_drop; });
                last_drop = last_use;
            }
            arrived.notify_all();
        }
    }

    /// @return  the error's message; empty if there is no error
    std::string read(std::uint64_t number, std::optional<Tile>& tile) const {
        try {
            tile.emplace(layout, number);
            options.read(layout.offset(number), tile->bytes());
            return tile->is_sealed() ? "" : fmt::format("{}: tile {} is damaged", file.path().string(), number);
        } catch (const std::exception& error) {
            return *error.what() != 0 ? error.what() : "a tile could not be read";
        } catch (...) {
            return "a tile could not be read";
        }
    }

    TiledTerrainOptions options;
    detail::TileHeader header;
    detail::TileFile file;
    HeightGrid frame;
    detail::TerrainLattice lattice;
    detail::TileLayout layout;
    ControlMesh roots;
    HeightRange heights;
    std::size_t most_loaded = 0;

    std::mutex mutex;                              // guards all members below; never held for long
    std::condition_variable_any changed, arrived;  // wake the loader; wake callers of wait()
    std::unordered_map<std::uint64_t, Entry> tiles;
    std::size_t loaded = 0;           // of them
    std::vector<std::uint64_t> uses;  // not ended yet
    std::uint64_t last_use = 0, revision = 0;
    std::uint64_t last_drop = 0;  // the newest use when old requests were dropped
    bool waits_for_use = false;
    TileStatistics statistics;

    std::jthread loader;  // last member, so that it is destroyed first
};

TiledTerrain::TiledTerrain(const std::filesystem::path& path, TiledTerrainOptions options)
    : impl_(std::make_unique<Impl>(path, std::move(options))) {}
TiledTerrain::~TiledTerrain() = default;

const ControlMesh& TiledTerrain::roots() const { return impl_->roots; }
int TiledTerrain::max_depth() const { return 2 * impl_->lattice.log_side - 1; }
const HeightGrid& TiledTerrain::frame() const { return impl_->frame; }
std::array<double, 2> TiledTerrain::lowest_highest() const {
    return {double{impl_->heights.low}, double{impl_->heights.high}};
}

void TiledTerrain::places(std::span<const Site> sites, std::span<Place> places) const {
    const std::lock_guard lock(impl_->mutex);
    for (std::size_t i = 0; i < sites.size(); ++i) {
        const LatticePlace p = impl_->lattice.place(sites[i]);
        Tile* const tile = impl_->find(p);
        places[i].known = tile != nullptr;
        if (tile == nullptr) continue;
        places[i] = impl_->lattice.vertex(p, tile->point(p).normal(),
                                          [&](LatticePlace of) { return impl_->position(*tile, of); });
    }
}

void TiledTerrain::bounds(std::span<const Site> sites, std::span<DiamondBounds> bounds) const {
    const std::lock_guard lock(impl_->mutex);
    for (std::size_t i = 0; i < sites.size(); ++i) {
        const LatticePlace p = impl_->lattice.place(sites[i]);
        Tile* const tile = impl_->find(p);
        bounds[i].known = tile != nullptr;
        if (tile == nullptr) continue;
        const auto within = impl_->lattice.around(p);
        bounds[i] = impl_->lattice.bounds(within, tile->heights(within), tile->point(p).error());
    }
}

std::optional<GroundPoint> TiledTerrain::at(const Vec2d& place) const {
    const auto corner = impl_->lattice.square_at(place);
    if (!corner) return {};
    const std::lock_guard lock(impl_->mutex);
    Tile* const tile = impl_->find(*corner, 0);
    if (tile != nullptr) {
        const auto known = [&](LatticePlace p) { return impl_->position(*tile, p); };
        return detail::ground(detail::ground_square(*corner, known), place);
    }
    // If the loader waits for room, this call counts as a use, since perhaps no view is updated.
    if (impl_->waits_for_use) {
        ++impl_->last_use;
        impl_->changed.notify_all();
    }
    return {};
}

std::uint64_t TiledTerrain::revision() const {
    const std::lock_guard lock(impl_->mutex);
    return impl_->revision;
}
std::uint64_t TiledTerrain::begin_use() const {
    const std::lock_guard lock(impl_->mutex);
    return impl_->uses.emplace_back(++impl_->last_use);
}
void TiledTerrain::end_use(std::uint64_t use) const {
    const std::lock_guard lock(impl_->mutex);
    impl_->uses.erase(std::ranges::find(impl_->uses, use));
    if (impl_->waits_for_use) impl_->changed.notify_all();
}

TileStatistics TiledTerrain::statistics() const {
    const std::lock_guard lock(impl_->mutex);
    TileStatistics result = impl_->statistics;
    result.wanted = impl_->tiles.size() - impl_->loaded;
    result.cached_bytes = (impl_->loaded + 1) * impl_->layout.tile_bytes;
    return result;
}
void TiledTerrain::wait(std::uint64_t revision, std::chrono::milliseconds longest) const {
    std::unique_lock lock(impl_->mutex);
    impl_->arrived.wait_for(lock, std::min<std::chrono::milliseconds>(longest, std::chrono::hours(24)), [&] {
        return impl_->revision != revision || impl_->tiles.size() == impl_->loaded || impl_->waits_for_use;
    });
}

}  // namespace tetrakis::lod
