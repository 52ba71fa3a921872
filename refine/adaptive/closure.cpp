#include "closure.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/parallel.hpp"
#include "../rules/corner_angles.hpp"
#include "../uniform/site_stencils.hpp"

#include <oneapi/tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <variant>
#include <vector>

namespace tetrakis {

namespace detail {

/// The vertices of one level that a block needs, each once, and their stencils on the level above.
class LevelVertices {
  public:
    std::vector<VertexKey> keys;
    std::vector<std::uint32_t> stencil_begin;  ///< per key, into `source` and `weight`
    std::vector<std::uint32_t> source;         ///< vertices of the level above
    std::vector<double> weight;
    std::vector<Vec3d> value;

    std::uint32_t insert(const VertexKey& key) {
        if (2 * (std::size_t{count_} + 1) > slots_.size()) grow();
        Slot& slot = find_slot(key);
        if (slot.number == k_empty) {
            // What may throw comes first: a slot that is not listed would never be emptied.
            keys.push_back(key);
            slot_of_.push_back(static_cast<std::uint32_t>(&slot - slots_.data()));
            slot = {key, count_++};
        }
        return slot.number;
    }
    /// Cost: that of what is in it; the table keeps its size.
    void clear() {
        for (const std::uint32_t s : slot_of_) slots_[s] = Slot{};
        slot_of_.clear();
        keys.clear();
        count_ = 0;
        stencil_begin.clear();
        source.clear();
        weight.clear();
        value.clear();
    }

  private:
    static constexpr std::uint32_t k_empty = 0xFFFF'FFFFu;
    struct Slot {
        VertexKey key{};
        std::uint32_t number = k_empty;
    };

    static std::uint64_t hash(const VertexKey& key) {
        // Multiplicative mixing (Knuth, TAOCP 3, 6.4, with 64-bit odd constants), the upper bits being the good ones.
        std::uint64_t h = (std::uint64_t{key.x} << 32 | key.y) * 0x9E37'79B9'7F4A'7C15u;
        h = (h ^ h >> 29 ^ key.root) * 0xBF58'476D'1CE4'E5B9u;
        return h ^ h >> 32;
    }
    Slot& find_slot(const VertexKey& key) {
        const std::size_t mask = slots_.size() - 1;
        for (std::size_t i = hash(key) & mask;; i = (i + 1) & mask)
            if (slots_[i].number == k_empty || slots_[i].key == key) return slots_[i];
    }
    void grow() {
        slots_.assign(std::max<std::size_t>(64, 2 * slots_.size()), Slot{});
        for (std::uint32_t i = 0; i < keys.size(); ++i) {
            Slot& slot = find_slot(keys[i]);
            slot = {keys[i], i};
            slot_of_[i] = static_cast<std::uint32_t>(&slot - slots_.data());
        }
    }

    std::vector<Slot> slots_;
    std::vector<std::uint32_t> slot_of_;  // per key
    std::uint32_t count_ = 0;             // of the keys
};

/// What a site's ring is but for its points; tags are asked for again.
struct Outline {
    std::uint32_t points = 0;
    int faces = 0;
    bool boundary = false, tags = false;
};

struct Workspace {
    std::array<LevelVertices, k_max_level + 1> levels;
    std::vector<std::uint32_t> rings;  ///< per site: its ring's vertices at its level
    std::vector<Outline> outlines;     ///< per site
    std::vector<StencilEntry> entries;
    KeyRing ring;
    VertexRing points;
};

}  // namespace detail

namespace {

using detail::KeyRing;
using detail::LevelVertices;
using detail::Outline;
using detail::StencilEntry;
using detail::VertexKey;
using detail::Workspace;

// Sites evaluated together: enough to share ancestors, few enough for their levels to stay in the cache.
constexpr std::uint32_t k_block = 2048;

struct Vertex {
    VertexKey key;
    int level;
};

/// The site's point in lowest terms, in the frame of its own.
template <class Stencils>
Vertex lowest(const Stencils& stencils, const Site& site) {
    assert(site.level <= k_max_level);
    const std::uint32_t bits = site.at.x | site.at.y;
    const int shift = std::min<int>(site.level, bits == 0 ? site.level : std::countr_zero(bits));
    const int level = site.level - shift;
    return {stencils.canonical({site.root.value, site.at.x >> shift, site.at.y >> shift}, level), level};
}

/// Everything above the collected vertices, then their positions.
template <class Stencils>
void evaluate(const Stencils& stencils, int deepest, Workspace& work) {
    for (int l = deepest; l > 0; --l) {
        LevelVertices& level = work.levels[l];
        level.stencil_begin.push_back(0);
        for (const VertexKey& key : level.keys) {
            work.entries.clear();
            stencils.stencil(key, l, work.ring, work.entries);
            for (const StencilEntry& entry : work.entries) {
                level.source.push_back(work.levels[l - 1].insert(entry.key));
                level.weight.push_back(entry.weight);
            }
            level.stencil_begin.push_back(static_cast<std::uint32_t>(level.source.size()));
        }
    }
    LevelVertices& base = work.levels[0];
    for (const VertexKey& key : base.keys) base.value.push_back(stencils.base_point(key));
    for (int l = 1; l <= deepest; ++l) {
        LevelVertices& level = work.levels[l];
        const std::vector<Vec3d>& above = work.levels[l - 1].value;
        level.value.resize(level.keys.size());
        for (std::size_t i = 0; i < level.keys.size(); ++i) {
            Vec3d sum(0);
            for (std::uint32_t k = level.stencil_begin[i]; k < level.stencil_begin[i + 1]; ++k)
                sum += level.weight[k] * above[level.source[k]];
            level.value[i] = sum;
        }
    }
}

/// Calls write(number, ring) for each of the sites.
template <class Stencils, class Write>
void limit_block(const Stencils& stencils, std::span<const Site> sites, Workspace& work, Write&& write) {
    for (LevelVertices& level : work.levels) level.clear();
    work.rings.clear();
    work.outlines.clear();
    int deepest = 0;
    for (const Site& site : sites) {
        const Vertex v = lowest(stencils, site);
        deepest = std::max(deepest, v.level);
        stencils.ring(v.key, v.level, work.ring);
        const KeyRing& ring = work.ring;
        for (const VertexKey& key : ring.keys) work.rings.push_back(work.levels[v.level].insert(key));
        work.outlines.push_back({static_cast<std::uint32_t>(ring.keys.size()), ring.faces, ring.boundary,
                                 ring.vertex_sharpness != 0 || !ring.sharpness.empty() || !ring.outer_child.empty()});
    }
    evaluate(stencils, deepest, work);
    std::size_t at = 0;
    for (std::size_t i = 0; i < sites.size(); ++i) {
        const Vertex v = lowest(stencils, sites[i]);
        const Outline& outline = work.outlines[i];
        VertexRing& ring = work.points;
        ring.clear();
        ring.faces = outline.faces;
        ring.boundary = outline.boundary;
        if (outline.tags) {
            stencils.ring(v.key, v.level, work.ring);
            ring.vertex_sharpness = work.ring.vertex_sharpness;
            ring.sharpness = work.ring.sharpness;
            ring.outer_child = work.ring.outer_child;
        }
        for (std::uint32_t k = 0; k < outline.points; ++k)
            ring.points.push_back(work.levels[v.level].value[work.rings[at++]]);
        write(i, ring);
    }
}

template <class Stencils>
void control_block(const Stencils& stencils, std::span<const Site> sites, int level, Workspace& work,
                   std::span<Vec3d> out) {
    for (LevelVertices& vertices : work.levels) vertices.clear();
    work.rings.clear();
    for (const Site& site : sites) {
        const Vertex v = lowest(stencils, site);
        assert(v.level <= level);
        const int up = level - v.level;
        work.rings.push_back(work.levels[level].insert({v.key.root, v.key.x << up, v.key.y << up}));
    }
    evaluate(stencils, level, work);
    for (std::size_t i = 0; i < sites.size(); ++i) out[i] = work.levels[level].value[work.rings[i]];
}

}  // namespace

struct Closure::Impl {
    std::variant<detail::QuadStencils, detail::TriangleStencils> stencils;
    CreaseMethod method;
    mutable oneapi::tbb::enumerable_thread_specific<Workspace> workspaces{};  ///< what blocks have grown

    template <class Body>
    void blocks(std::size_t count, Body&& body) const {
        std::visit(
            [&](const auto& s) {
                for_each_block(static_cast<std::uint32_t>(count), k_block, [&](std::uint32_t begin, std::uint32_t end) {
                    body(s, begin, end - begin, workspaces.local());
                });
            },
            stencils);
    }
};

namespace {

std::variant<detail::QuadStencils, detail::TriangleStencils> make_stencils(const ControlMesh& mesh, SchemeKind scheme) {
    if (scheme == SchemeKind::catmull_clark) return detail::QuadStencils(mesh);
    if (!mesh.all_triangles())
        throw Error(ErrorCode::invalid_input, "Loop subdivision needs a mesh of triangles; triangulate it first",
                    mesh.data().source);
    return detail::TriangleStencils(mesh);
}

}  // namespace

Closure::Closure(const ControlMesh& mesh, SchemeKind scheme) {
    detail::refuse_corner_angles(mesh);
    impl_.reset(new Impl{make_stencils(mesh, scheme), mesh.crease_method()});
}
Closure::~Closure() = default;
Closure::Closure(Closure&&) noexcept = default;
Closure& Closure::operator=(Closure&&) noexcept = default;

void Closure::positions(std::span<const Site> sites, std::span<Vec3d> positions) const {
    assert(sites.size() == positions.size());
    impl_->blocks(sites.size(), [&](const auto& s, std::size_t begin, std::size_t count, Workspace& work) {
        limit_block(s, sites.subspan(begin, count), work, [&](std::size_t i, VertexRing& ring) {
            positions[begin + i] = limit_position(s.scheme, impl_->method, ring);
        });
    });
}

void Closure::limits(std::span<const Site> sites, std::span<LimitPoint> out) const {
    assert(sites.size() == out.size());
    impl_->blocks(sites.size(), [&](const auto& s, std::size_t begin, std::size_t count, Workspace& work) {
        limit_block(s, sites.subspan(begin, count), work, [&](std::size_t i, VertexRing& ring) {
            out[begin + i] = limit_point(s.scheme, impl_->method, ring);
        });
    });
}

LimitPoint Closure::limit(const Site& site) const {
    LimitPoint point;
    limits({&site, 1}, {&point, 1});
    return point;
}

void Closure::control_positions(std::span<const Site> sites, int level, std::span<Vec3d> out) const {
    assert(sites.size() == out.size() && level >= 0 && level <= k_max_level);
    impl_->blocks(sites.size(), [&](const auto& s, std::size_t begin, std::size_t count, Workspace& work) {
        control_block(s, sites.subspan(begin, count), level, work, out.subspan(begin, count));
    });
}

}  // namespace tetrakis
