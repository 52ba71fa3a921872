#pragma once

#include "root_lattices.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tetrakis::detail {

/// For each corner of a net's roots, whether it is regular: inside the net, between six triangles or four quads.
inline std::vector<char> regular_corners(const RootLattices& net) {
    const RuleMesh& base = net.base();
    const int regular = net.side_count() == 4 ? 4 : 6;
    std::vector<char> result(base.vertex_count(), 0);
    for (int v = 0; v < base.vertex_count(); ++v) {
        int roots = 0;
        const bool closed = base.for_each_leaving(v, [&](int) { ++roots; });
        result[v] = closed && roots == regular ? 1 : 0;
    }
    return result;
}

/// A root's lattice with rings of ghosts around it: points of the neighbouring roots, where the lattice would continue.
/// There are no ghosts beyond a boundary, nor between the neighbours at a corner that is not regular.
class GhostGrid {
  public:
    using Place = FarPlace;
    /// @param regular  regular_corners(net)
    /// @param rings    at most the lattice's segments
    GhostGrid(const RootLattices& net, const RootLayout& at, const std::vector<char>& regular, std::uint32_t rings)
        : net_(net), at_(at), regular_(regular), rings_(rings), last_(net.last_place(at)) {
        for (std::uint32_t s = 0; s < net.side_count(); ++s) {
            const auto seen = [&](std::ptrdiff_t a, std::ptrdiff_t b) {
                return index(turned_place<Place>(net.side_count() == 4, std::ptrdiff_t{last_}, s, a, b));
            };
            sides_[s] = {seen(0, 0), seen(1, 0) - seen(0, 0), seen(0, 1) - seen(0, 0)};
        }
    }

    std::ptrdiff_t stride() const { return last_ + 1 + 2 * static_cast<std::ptrdiff_t>(rings_); }
    std::size_t size() const { return static_cast<std::size_t>(stride() * stride()); }
    std::ptrdiff_t index(const Place& p) const {
        const auto w = static_cast<std::ptrdiff_t>(rings_);
        return (p.y + w) * stride() + p.x + w;
    }
    Place place(std::ptrdiff_t index) const {
        const auto w = static_cast<std::ptrdiff_t>(rings_);
        return {index % stride() - w, index / stride() - w};
    }
    /// The lattice seen from a side: index of its place (0, 0), and index steps along the side and away from it.
    struct Side {
        std::ptrdiff_t origin, along, away;
        std::ptrdiff_t index(std::ptrdiff_t a, std::ptrdiff_t b) const { return origin + a * along + b * away; }
    };
    const Side& side(std::uint32_t s) const { return sides_[s]; }

    /// Copies the values at the places of root f and of its ghosts. Other entries of `grid` stay unchanged.
    /// @param own_only  only ghosts across edges that the root leads, and around regular vertices that it is the first
    ///                  root of (it leads both edges there)
    template <class T>
    void fill(std::uint32_t f, const T* in, T* grid, bool own_only = false) const {
        fill_root(f, in, grid);
        if (rings_ == 0) return;
        const RuleMesh& base = net_.base();
        const std::uint32_t sides = net_.side_count();
        for (std::uint32_t s = 0, h = sides * f; s < sides; ++s, ++h) {
            if (!own_only || base.leads(h)) fill_side(h, s, in, grid);
            const int v = base.origin(h);
            if (regular_[v] != 0 && (!own_only || base.first(v) == static_cast<int>(h))) fill_corner(h, s, in, grid);
        }
    }

  private:
    static constexpr std::uint32_t none = RootLattices::none;

    template <class T>
    void fill_root(std::uint32_t f, const T* in, T* grid) const {
        const std::uint32_t n = last_, sides = net_.side_count();
        if (net_.in_cells()) {
            for (std::uint32_t y = 0; y <= n; ++y)
                std::copy_n(in + net_.number_at(at_, f, {0, y}), n + 1, grid + index({0, y}));
            return;
        }
        for (std::uint32_t s = 0; s < sides; ++s) {
            T* const first = grid + sides_[s].origin;
            const std::ptrdiff_t step = sides_[s].along;
            at_.for_each_along(sides * f + s, [&](std::uint32_t a, std::uint32_t v) { first[a * step] = in[v]; });
        }
        const T* inner = in + at_.face_begin(f);
        for (std::uint32_t y = 1; y < n; ++y) {
            const std::uint32_t count = (sides == 4 ? n : n - y) - 1;
            std::copy_n(inner, count, grid + index({1, y}));
            inner += count;
        }
    }

    template <class T>
    void fill_side(std::uint32_t h, std::uint32_t s, const T* in, T* grid) const {
        const std::uint32_t t = net_.base().twin(h);
        if (t == none) return;
        for (std::uint32_t b = 1; b <= rings_; ++b) {
            const std::uint32_t line = net_.in_cells() ? b - 1 : b;
            if (line > last_) return;
            T* const first = grid + sides_[s].index(last_, -static_cast<std::ptrdiff_t>(b));
            const std::ptrdiff_t step = -sides_[s].along;
            net_.for_each_on_line(at_, t, line, 0, last_ + 1, [&](std::uint32_t a, std::uint32_t v) {
                first[static_cast<std::ptrdiff_t>(a) * step] = in[v];
            });
        }
    }

    /// Copies values from the roots at a regular corner that share no side with this root.
    template <class T>
    void fill_corner(std::uint32_t h, std::uint32_t s, const T* in, T* grid) const {
        std::uint32_t g = net_.turned(h);
        const auto reach = static_cast<std::ptrdiff_t>(std::min(rings_, at_.segments()));
        const auto at = [&](std::ptrdiff_t a, std::ptrdiff_t b) {
            return in[net_.number(at_, g, static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b))];
        };
        if (net_.side_count() == 4) {
            g = net_.turned(g);
            const std::ptrdiff_t first = net_.in_cells() ? 0 : 1, end = net_.in_cells() ? reach : reach + 1;
            const std::ptrdiff_t shift = net_.in_cells() ? 1 : 0;
            for (std::ptrdiff_t b = first; b < end; ++b)
                for (std::ptrdiff_t a = first; a < end; ++a) grid[sides_[s].index(-a - shift, -b - shift)] = at(a, b);
            return;
        }
        // A turn by 60 degrees takes (a, b) to (-b, a + b). The last ray of a root is left to the next root.
        for (int turn = 0; turn < 3; ++turn) {
            g = net_.turned(g);
            for (std::ptrdiff_t b = 0; b <= reach; ++b)
                for (std::ptrdiff_t a = 1; a + b <= reach; ++a) {
                    const std::ptrdiff_t x[] = {-a - b, -a, b}, y[] = {a, -b, -a - b};
                    grid[sides_[s].index(x[turn], y[turn])] = at(a, b);
                }
        }
    }

    const RootLattices& net_;
    RootLayout at_;
    const std::vector<char>& regular_;
    std::uint32_t rings_, last_;
    Side sides_[4] = {};
};

}  // namespace tetrakis::detail
