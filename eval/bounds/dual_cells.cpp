#include "dual_cells.hpp"

#include "../../refine/points/level_source.hpp"

#include <algorithm>

namespace tetrakis::detail {

namespace {

constexpr std::size_t k_regular = 4;
// At a point of a boundary or crease two cells meet; at a corner of a boundary there is one. Where a crease ends there
// are three: those of both sides of its last vertex, and that of the next vertex.
constexpr std::size_t k_around_an_end = 3;

std::uint32_t last(const VertexCell& cell) { return (1u << cell.level) - 1; }
VertexCell corner_cell(const VertexRoots::Corner& c, int level, std::uint32_t x = 0, std::uint32_t y = 0) {
    const std::uint32_t end = (1u << level) - 1;
    return {c.cell.root,
            {c.corner == 1 || c.corner == 2 ? end - x : x, c.corner >= 2 ? end - y : y},
            static_cast<std::uint8_t>(level)};
}

}  // namespace

std::size_t DualCells::Hash::operator()(const VertexCell& cell) const {
    std::uint64_t h = (std::uint64_t{cell.root} << 8 | cell.level) * 0x9E37'79B9'7F4A'7C15u;
    h = (h ^ (std::uint64_t{cell.at.x} << 32 | cell.at.y)) * 0xBF58'476D'1CE4'E5B9u;
    return static_cast<std::size_t>(h ^ h >> 31);
}

DualCells::DualCells(const LevelSource& points, const VertexRoots& roots)
    : source_(points), roots_(roots), point_at_(4 * std::size_t{roots.count()}, k_none) {
    std::vector<std::uint8_t> seen(point_at_.size(), 0);
    for (std::uint32_t r = 0; r < roots.count(); ++r)
        for (int c = 0; c < 4; ++c) {
            const auto index = [](const VertexRoots::Corner& m) {
                return 4 * std::size_t{m.cell.root} + static_cast<std::size_t>(m.corner);
            };
            const VertexRoots::Corner first{{r, {0, 0}, 0}, c};
            if (seen[index(first)] != 0) continue;
            Point point = roots.fan(first);
            const bool regular =
                point.closed ? point.corners.size() == k_regular : point.corners.size() < k_around_an_end;
            for (const VertexRoots::Corner& m : point.corners) {
                seen[index(m)] = 1;
                if (!regular) point_at_[index(m)] = static_cast<std::uint32_t>(points_.size());
            }
            if (!regular) points_.push_back(std::move(point));
        }
}

std::optional<VertexRoots::Across> DualCells::across(const VertexCell& cell, int side) const {
    const VertexRoots::Across next = roots_.across(cell, side);
    return next.kind == VertexRoots::Across::Kind::neighbour ? std::optional(next) : std::nullopt;
}

std::uint32_t DualCells::point(const VertexCell& cell, int corner) const {
    const bool there =
        cell.at.x == (corner == 1 || corner == 2 ? last(cell) : 0) && cell.at.y == (corner >= 2 ? last(cell) : 0);
    return there ? point_at_[4 * std::size_t{cell.root} + static_cast<std::size_t>(corner)] : k_none;
}

std::uint32_t DualCells::point_of(const VertexCell& cell) const {
    for (int c = 0; c < 4; ++c)
        if (const std::uint32_t p = point(cell, c); p != k_none) return p;
    return k_none;
}

bool DualCells::irregular(const VertexCell& cell) const { return point_of(cell) != k_none; }

Vec2d DualCells::vertex(const VertexCell& cell) const {
    const auto place = [&](std::uint32_t at, int low, int high) {
        if (at == 0 && !across(cell, low)) return 0.0;
        return at == last(cell) && !across(cell, high) ? 1.0 : 0.5;
    };
    return {place(cell.at.x, 3, 1), place(cell.at.y, 0, 2)};
}

void DualCells::add_control_cells(const VertexCell& cell, std::vector<VertexCell>& wanted) const {
    if (irregular(cell)) {
        for (const VertexRoots::Corner& c : points_[point_of(cell)].corners)
            for (const std::uint32_t y : {0u, 1u})
                for (const std::uint32_t x : {0u, 1u}) wanted.push_back(corner_cell(c, cell.level, x, y));
        return;
    }
    constexpr std::array<std::size_t, 4> k_at_side = {1, 5, 7, 3}, k_at_corner = {0, 2, 8, 6};
    std::array<VertexCell, 9> cells;
    cells[4] = cell;
    const auto beside = [&](int side) {
        const auto next = across(cell, side);
        return next ? next->cell : cell;
    };
    for (int k = 0; k < 4; ++k) {
        cells[k_at_side[static_cast<std::size_t>(k)]] = beside(k);
        VertexCell& diagonal = cells[k_at_corner[static_cast<std::size_t>(k)]];
        const auto next = across(cell, (k + 3) % 4);
        diagonal = next ? next->cell : beside(k);
        if (next)
            if (const auto second = across(next->cell, (next->side + 3) % 4)) diagonal = second->cell;
    }
    wanted.insert(wanted.end(), cells.begin(), cells.end());
}

VertexCell DualCells::keeper(const VertexCell& cell) const {
    const std::uint32_t point = point_of(cell);
    return point == k_none ? cell : corner_cell(points_[point].corners[0], cell.level);
}

void DualCells::collect(const VertexCell& cell, int levels, std::vector<VertexCell>& wanted) const {
    if (irregular(cell) && levels > 0) {
        for (int k = 0; k < 4; ++k) collect(quarter(cell, k), levels - 1, wanted);
    } else if (const VertexCell by = keeper(cell); !control_.contains(by)) {
        wanted.push_back(by);
    }
}

void DualCells::find(std::span<const VertexCell> leaves, const std::function<void(double)>& tell, int levels) {
    constexpr std::size_t k_block = 1u << 13;  // cells between two reports
    std::vector<VertexCell> wanted, cells, each;
    for (const VertexCell& leaf : leaves) collect(leaf, levels, wanted);
    std::sort(wanted.begin(), wanted.end());
    wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
    std::vector<Vec3d> found;
    for (std::size_t begin = 0; begin < wanted.size(); begin += k_block) {
        tell(static_cast<double>(begin) / static_cast<double>(wanted.size()));
        const auto some = std::span(wanted).subspan(begin, std::min(k_block, wanted.size() - begin));
        each.clear();
        for (const VertexCell& cell : some) {
            const std::size_t before = each.size();
            add_control_cells(cell, each);
            control_[cell].resize(each.size() - before);
        }
        cells = each;
        std::sort(cells.begin(), cells.end());
        cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
        found.resize(cells.size());
        written_positions(source_, cell_sites(cells), found);
        auto next = each.begin();
        for (const VertexCell& cell : some)
            for (Vec3d& p : control_[cell])
                p = found[static_cast<std::size_t>(std::lower_bound(cells.begin(), cells.end(), *next++) -
                                                   cells.begin())];
    }
}

}  // namespace tetrakis::detail
