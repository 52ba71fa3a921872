#include "closure.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/parallel.hpp"
#include "../rules/corner_angles.hpp"
#include "../uniform/site_stencils.hpp"
#include "level_vertices.hpp"

#include <oneapi/tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <variant>
#include <vector>

namespace tetrakis {

namespace detail {

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

using detail::evaluate_levels;
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

template <class Stencils>
std::uint32_t number(const Stencils& stencils, const VertexKey& key, int level, Workspace& work) {
    return level == 0 ? stencils.base_number(key) : work.levels[static_cast<std::size_t>(level)].insert(key);
}
template <class Stencils>
std::span<const Vec3d> values(const Stencils& stencils, int level, const Workspace& work) {
    return level == 0 ? stencils.base() : std::span<const Vec3d>(work.levels[static_cast<std::size_t>(level)].value);
}

/// Everything above the collected vertices, then their positions.
template <class Stencils>
void evaluate(const Stencils& stencils, int deepest, Workspace& work) {
    evaluate_levels(
        work.levels, deepest,
        [&](const VertexKey& key, int level, const auto& add) {
            work.entries.clear();
            stencils.stencil(key, level, work.ring, work.entries);
            for (const StencilEntry& entry : work.entries) add(entry.key, entry.weight);
        },
        [&](const VertexKey& key) { return stencils.base_number(key); }, stencils.base());
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
        for (const VertexKey& key : ring.keys) work.rings.push_back(number(stencils, key, v.level, work));
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
            ring.points.push_back(values(stencils, v.level, work)[work.rings[at++]]);
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
        work.rings.push_back(number(stencils, {v.key.root, v.key.x << up, v.key.y << up}, level, work));
    }
    evaluate(stencils, level, work);
    for (std::size_t i = 0; i < sites.size(); ++i) out[i] = values(stencils, level, work)[work.rings[i]];
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
