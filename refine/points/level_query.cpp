#include "level_query.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/spread_bits.hpp"
#include "../../hier/forest/corner_cell.hpp"

#include <string>

namespace tetrakis::detail {

namespace {

[[noreturn]] void refuse_address(std::size_t i, const std::string& what) {
    throw Error(ErrorCode::invalid_input, "address " + std::to_string(i) + " of those asked for " + what);
}

}  // namespace

std::uint64_t curve_place(const LevelQuery& query) {
    const std::uint64_t x = query.cell.x, y = query.cell.y;
    const int shift = k_max_level - query.level;
    return spread_bits((x ^ y) << shift) | spread_bits(y << shift) << 1;
}

std::vector<LevelQuery> site_queries(const ControlMesh& mesh, FanLattice lattice, std::span<const Site> sites,
                                     bool minimal) {
    if (lattice == FanLattice::dual)
        throw Error(ErrorCode::invalid_input, "the vertices of a dual scheme are named by cells, not by sites");
    std::vector<LevelQuery> queries(sites.size());
    for (std::size_t i = 0; i < sites.size(); ++i) {
        const Site site = minimal && sites[i].level <= k_max_level ? minimal_level(sites[i]) : sites[i];
        const bool triangles = lattice == FanLattice::triangles;
        if (site.level > k_max_level) refuse_address(i, "has a level beyond the deepest");
        if (site.root.value >= mesh.halfedge_count() || (triangles && site.root.value % 3 != 0))
            refuse_address(i, "has no such root");
        const std::uint64_t n = std::uint64_t{1} << site.level, x = site.at.x, y = site.at.y;
        if (triangles ? x + y > n : x > n || y > n) refuse_address(i, "lies outside its root");
        LatticePoint cell = site.at;
        if (!triangles) {
            if (x == n) --cell.x;
            if (y == n) --cell.y;
        } else if (x + y == n) {
            --(x > 0 ? cell.x : cell.y);
        }
        queries[i] = {site.root.value, cell, site.at, site.level};
    }
    return queries;
}

std::vector<LevelQuery> cell_queries(FanLattice lattice, std::size_t roots, std::span<const VertexCell> cells) {
    if (lattice != FanLattice::dual)
        throw Error(ErrorCode::invalid_input, "only the vertices of dual schemes are named by cells");
    std::vector<LevelQuery> queries(cells.size());
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const VertexCell& c = cells[i];
        if (c.level > k_max_level) refuse_address(i, "has a level beyond the deepest");
        if (c.root >= roots) refuse_address(i, "has no such root");
        if (c.at.x >> c.level != 0 || c.at.y >> c.level != 0) refuse_address(i, "lies outside its root");
        queries[i] = {c.root, c.at, c.at, c.level};
    }
    return queries;
}

}  // namespace tetrakis::detail
