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
using detail::TileHeader;
using detail::TileLayout;
using detail::TilePoint;
using Clock = std::chrono::steady_clock;

// A tile stays for this many uses after the last use that requested it. So a new tile is still there when the views
// that wait for it evaluate it, however small the cache is.
constexpr std::uint64_t k_uses_kept = 4;
constexpr std::uint64_t k_least_cached = 4;  // tiles of the cache that can be replaced

}  // namespace

class TiledTerrain::Impl {
  public:
    Impl(const std::filesystem::path& path, TiledTerrainOptions options)
        : options_(std::move(options)), file_(path, header_) {
        const auto refuse = [&](ErrorCode code, const std::string& text) { throw Error(code, text, path); };
        frame_.columns = header_.columns;
        frame_.rows = header_.rows;
        frame_.spacing = {header_.spacing[0], header_.spacing[1]};
        frame_.origin = {header_.origin[0], header_.origin[1]};
        try {
            detail::check_frame(frame_);
        } catch (const Error& error) {
            refuse(ErrorCode::invalid_input, fmt::format("the tile file is damaged: {}", error.what()));
        }
        if (header_.side < 16 || header_.side > 1024 || !std::has_single_bit(header_.side))
            refuse(ErrorCode::invalid_input, fmt::format("the tile file is damaged: tiles of {} steps", header_.side));
        lattice_ = detail::TerrainLattice(frame_);
        layout_ = TileLayout(lattice_, static_cast<std::int32_t>(header_.side));
        if (file_.size() != layout_.file_bytes())
            refuse(ErrorCode::invalid_input, fmt::format("the tile file has {} bytes, not {}: it is cut off or damaged",
                                                         file_.size(), layout_.file_bytes()));
        // Levels of one tile always stay, and so does the coarsest level, which has the roots.
        const auto& levels = layout_.levels();
        std::size_t k = levels.size() - 1;
        while (k > 0 && levels[k - 1].across == 1 && levels[k - 1].down == 1) --k;
        first_kept_ = levels[k].first_tile;
        const std::uint64_t kept = layout_.tile_count() - first_kept_;
        const std::uint64_t least = (kept + std::min(k_least_cached, first_kept_) + 1) * layout_.tile_bytes();
        if (options_.cache_bytes < least)
            refuse(ErrorCode::memory_limit,
                   fmt::format("a cache of {} bytes is too small; it needs {} at least", options_.cache_bytes, least));
        // One tile less: the loader reads into it.
        most_cached_ = std::min(options_.cache_bytes / layout_.tile_bytes() - 1 - kept, first_kept_);
        for (std::uint64_t i = first_kept_; i < layout_.tile_count(); ++i) {
            file_.read(layout_.offset(i), kept_.emplace_back(layout_).bytes());
            if (!kept_.back().is_sealed())
                refuse(ErrorCode::invalid_input, fmt::format("tile {} of the tile file is damaged", i));
            if (i < levels.back().first_tile) continue;
            const auto cells = static_cast<std::size_t>(layout_.cells().row);
            for (const HeightRange& range :
                 std::span(kept_.back().records<HeightRange>(layout_.cells()), cells * cells))
                heights_.add(range);
        }
        roots_ = lattice_.make_roots([&](LatticePlace p) {
            const Spot spot(*this, p);
            return position(p, spot.point(*find(spot.tile), p));
        });
        if (!options_.read)
            options_.read = [this](std::uint64_t offset, std::span<std::byte> bytes) { file_.read(offset, bytes); };
        loader_ = std::jthread([this](const std::stop_token& stop) { load_tiles(stop); });
    }

    void places(std::span<const Site> sites, std::span<Place> places) {
        const std::lock_guard lock(mutex_);
        for (std::size_t i = 0; i < sites.size(); ++i) {
            const LatticePlace p = lattice_.place(sites[i]);
            const Spot spot(*this, p);
            const Tile* const tile = find(spot.tile);
            places[i].known = tile != nullptr;
            if (tile == nullptr) continue;
            places[i] = lattice_.vertex(p, spot.point(*tile, p).normal(),
                                        [&](LatticePlace of) { return position(of, spot.point(*tile, of)); });
        }
    }

    void bounds(std::span<const Site> sites, std::span<DiamondBounds> bounds) {
        const std::lock_guard lock(mutex_);
        for (std::size_t i = 0; i < sites.size(); ++i) {
            const LatticePlace p = lattice_.place(sites[i]);
            const Spot spot(*this, p);
            const Tile* const tile = find(spot.tile);
            bounds[i].known = tile != nullptr;
            if (tile == nullptr) continue;
            const auto within = lattice_.around(p);
            bounds[i] = lattice_.bounds(within, spot.heights(*tile, within), spot.point(*tile, p).error());
        }
    }

    std::optional<GroundPoint> at(const Vec2d& place) {
        const auto corner = lattice_.square_at(place);
        if (!corner) return {};
        const std::lock_guard lock(mutex_);
        const Spot spot(*this, *corner, 0);
        const Tile* const tile = find(spot.tile);
        if (tile == nullptr) {
            // If the loader waits for room, this call counts as a use, since perhaps no view is updated.
            if (waits_for_use_) {
                ++last_use_;
                changed_.notify_all();
            }
            return {};
        }
        const auto known = [&](LatticePlace p) { return position(p, spot.point(*tile, p)); };
        return detail::GroundSquare(*corner, known).ground(place);
    }

    std::uint64_t revision() const {
        const std::lock_guard lock(mutex_);
        return revision_;
    }
    std::uint64_t begin_use() {
        const std::lock_guard lock(mutex_);
        uses_.push_back(++last_use_);
        return last_use_;
    }
    void end_use(std::uint64_t use) {
        const std::lock_guard lock(mutex_);
        uses_.erase(std::find(uses_.begin(), uses_.end(), use));
        if (waits_for_use_) changed_.notify_all();
    }

    TileStatistics statistics() const {
        const std::lock_guard lock(mutex_);
        TileStatistics result = statistics_;
        result.wanted = wants_.size();
        result.cached_bytes = (kept_.size() + cached_.size() + 1) * layout_.tile_bytes();
        return result;
    }
    void wait(std::uint64_t revision, std::chrono::milliseconds longest) {
        std::unique_lock lock(mutex_);
        arrived_.wait_for(lock, longest, [&] { return revision_ != revision || wants_.empty() || waits_for_use_; });
    }

    const HeightGrid& frame() const { return frame_; }
    std::array<double, 2> lowest_highest() const { return {double{heights_.low}, double{heights_.high}}; }
    const ControlMesh& roots() const { return roots_; }
    int max_depth() const { return 2 * lattice_.log_side - 1; }

  private:
    /// Location of a point in the tile that owns it, at the point's level or at a finer level.
    struct Spot {
        Spot(const Impl& terrain, LatticePlace p)
            : Spot(terrain, p,
                   std::min(std::countr_zero(static_cast<std::uint32_t>(p.x | p.y)),
                            static_cast<int>(terrain.layout_.levels().size()) - 1)) {}
        Spot(const Impl& terrain, LatticePlace p, int of_level) : layout(terrain.layout_), level(of_level) {
            const TileLayout::Level& l = layout.levels()[static_cast<std::size_t>(level)];
            column = std::min((p.x >> level) / layout.side(), l.across - 1);
            row = std::min((p.y >> level) / layout.side(), l.down - 1);
            tile = layout.tile(static_cast<std::size_t>(level), p.x >> level, p.y >> level);
        }
        const TilePoint& point(const Tile& in, LatticePlace p) const {
            const TileLayout::Array& array = layout.points();
            return in.records<TilePoint>(
                array)[((p.y >> level) - row * array.step) * array.row + (p.x >> level) - column * array.step];
        }
        /// Lowest and highest height of all cells that overlap the open rectangle.
        HeightRange heights(const Tile& in, const detail::TerrainLattice::Rectangle& within) const {
            const TileLayout::Array& array = layout.cells();
            const auto cell = [&](std::int32_t at, std::int32_t tile_at) {
                return (at >> level) / TileLayout::k_cell - tile_at * array.step + array.margin;
            };
            HeightRange range;
            const std::int32_t last_row = cell(within.y1 - 1, row), last_column = cell(within.x1 - 1, column);
            for (std::int32_t r = cell(within.y0, row); r <= last_row; ++r)
                for (std::int32_t c = cell(within.x0, column); c <= last_column; ++c)
                    range.add(in.records<HeightRange>(array)[r * array.row + c]);
            return range;
        }
        const TileLayout& layout;
        int level;
        std::int32_t column, row;
        std::uint64_t tile;
    };
    struct Cached {
        Tile tile;
        std::uint64_t use;  ///< the newest use when the tile was last requested
    };
    /// A tile that is requested and not loaded.
    struct Want {
        std::uint64_t use = 0;
        int failures = 0;
        Clock::time_point not_before{};
    };

    Vec3d position(LatticePlace p, const TilePoint& point) const { return lattice_.position(p, double{point.height}); }

    /// The tile if it is in memory; else nullptr, and the tile is requested.
    const Tile* find(std::uint64_t tile) {
        if (tile >= first_kept_) return &kept_[tile - first_kept_];
        if (const auto there = cached_.find(tile); there != cached_.end()) {
            there->second.use = last_use_;
            return &there->second.tile;
        }
        const auto [want, is_new] = wants_.try_emplace(tile);
        want->second.use = last_use_;
        if (is_new) changed_.notify_all();
        return nullptr;
    }

    /// The tile to be loaded next: of the most recently requested ones, the last in the file, as no other is coarser.
    std::uint64_t next_want(Clock::time_point& earliest) const {
        std::uint64_t best = k_none, best_use = 0;
        const auto now = Clock::now();
        earliest = Clock::time_point::max();
        for (const auto& [tile, want] : wants_) {
            if (want.not_before > now) {
                earliest = std::min(earliest, want.not_before);
            } else if (best == k_none || std::pair(want.use, tile) > std::pair(best_use, best)) {
                best = tile;
                best_use = want.use;
            }
        }
        return best;
    }

    /// Whether there is room for another tile. A full cache drops the least recently requested one unless it is used.
    bool make_room() {
        waits_for_use_ = false;
        if (cached_.size() < most_cached_) return true;
        const auto latest = std::ranges::min_element(cached_, {}, [](const auto& entry) { return entry.second.use; });
        const std::uint64_t oldest_use = uses_.empty() ? last_use_ + 1 : *std::ranges::min_element(uses_);
        waits_for_use_ = latest->second.use + k_uses_kept > oldest_use;
        if (waits_for_use_)
            arrived_.notify_all();
        else
            cached_.erase(latest);
        return !waits_for_use_;
    }

    void put(std::uint64_t number, Tile tile) {
        cached_.insert({number, {std::move(tile), last_use_}});
        wants_.erase(number);
        ++statistics_.loads;
        ++revision_;
        // Views that wait evaluate again now, and repeat the requests that still count; old requests are dropped.
        if (last_use_ >= last_drop_ + k_uses_kept) {
            std::erase_if(wants_, [&](const auto& want) { return want.second.use <= last_drop_; });
            last_drop_ = last_use_;
        }
        arrived_.notify_all();
    }

    void load_tiles(const std::stop_token& stop) {
        std::unique_lock lock(mutex_);
        while (!stop.stop_requested()) {
            Clock::time_point earliest;
            const std::uint64_t number = next_want(earliest);
            if (number == k_none) {
                arrived_.notify_all();
                const auto has_more = [&, count = wants_.size()] { return wants_.size() != count; };
                if (earliest == Clock::time_point::max())
                    changed_.wait(lock, stop, has_more);
                else
                    changed_.wait_until(lock, stop, earliest, has_more);
                continue;
            }
            lock.unlock();
            Tile tile(layout_);
            const std::string error = read(number, tile);
            lock.lock();
            Want& want = wants_[number];
            if (!error.empty()) {
                ++statistics_.failures;
                statistics_.last_error = error;
                want.not_before = Clock::now() + options_.pause * (1 << std::min(want.failures, 6));
                ++want.failures;
                continue;
            }
            if (!changed_.wait(lock, stop, [&] { return make_room(); })) return;
            put(number, std::move(tile));
        }
    }

    /// @return  the error's message; empty if there is no error
    std::string read(std::uint64_t number, Tile& tile) const {
        try {
            options_.read(layout_.offset(number), tile.bytes());
            return tile.is_sealed() ? "" : fmt::format("{}: tile {} is damaged", file_.path().string(), number);
        } catch (const std::exception& error) {
            return *error.what() != 0 ? error.what() : "a tile could not be read";
        } catch (...) {
            return "a tile could not be read";
        }
    }

    static constexpr std::uint64_t k_none = ~std::uint64_t{0};

    TiledTerrainOptions options_;
    TileHeader header_;
    detail::TileFile file_;
    HeightGrid frame_;
    detail::TerrainLattice lattice_;
    TileLayout layout_;
    ControlMesh roots_;
    HeightRange heights_;
    std::uint64_t first_kept_ = 0;  // number of the first tile that always stays
    std::vector<Tile> kept_;
    std::size_t most_cached_ = 0;

    mutable std::mutex mutex_;                       // guards all members below; never held for long
    std::condition_variable_any changed_, arrived_;  // wake the loader; wake callers of wait()
    std::unordered_map<std::uint64_t, Cached> cached_;
    std::unordered_map<std::uint64_t, Want> wants_;
    std::vector<std::uint64_t> uses_;  // not ended yet
    std::uint64_t last_use_ = 0, revision_ = 0;
    std::uint64_t last_drop_ = 0;  // the newest use when old requests were dropped
    bool waits_for_use_ = false;
    TileStatistics statistics_;

    std::jthread loader_;  // last member, so that it is destroyed first
};

TiledTerrain::TiledTerrain(const std::filesystem::path& path, TiledTerrainOptions options)
    : impl_(std::make_unique<Impl>(path, std::move(options))) {}
TiledTerrain::~TiledTerrain() = default;

std::optional<GroundPoint> TiledTerrain::at(const Vec2d& place) const { return impl_->at(place); }
const ControlMesh& TiledTerrain::roots() const { return impl_->roots(); }
int TiledTerrain::max_depth() const { return impl_->max_depth(); }
void TiledTerrain::places(std::span<const Site> sites, std::span<Place> places) const { impl_->places(sites, places); }
void TiledTerrain::bounds(std::span<const Site> sites, std::span<DiamondBounds> bounds) const {
    impl_->bounds(sites, bounds);
}
std::uint64_t TiledTerrain::revision() const { return impl_->revision(); }
std::uint64_t TiledTerrain::begin_use() const { return impl_->begin_use(); }
void TiledTerrain::end_use(std::uint64_t use) const { impl_->end_use(use); }
const HeightGrid& TiledTerrain::frame() const { return impl_->frame(); }
std::array<double, 2> TiledTerrain::lowest_highest() const { return impl_->lowest_highest(); }
TileStatistics TiledTerrain::statistics() const { return impl_->statistics(); }
void TiledTerrain::wait(std::uint64_t revision, std::chrono::milliseconds longest) const {
    impl_->wait(revision, longest);
}

}  // namespace tetrakis::lod
