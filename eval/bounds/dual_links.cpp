#include "dual_links.hpp"

#include <algorithm>

namespace tetrakis::detail {

DualLinks::Entry DualLinks::entry(const Side& side) const {
    const std::uint32_t begin = net_.faces.face_offsets[side.face];
    const std::uint32_t n = net_.faces.face_offsets[side.face + std::size_t{1}] - begin;
    const std::uint32_t start = n == 4 && net_.faces.diagonal_at_first[side.face] == 0 ? 1 : 0;
    const auto vertex = [&](std::uint32_t i) {
        const std::uint32_t corner = plane_[side.face] == 0 ? i : i % 3 == 0 ? start : start + side.piece + i % 3;
        return net_.faces.face_vertices[begin + corner % n];
    };
    const std::uint32_t a = vertex(side.side), b = vertex(side.side + 1);
    return {std::min(a, b), std::max(a, b), side};
}

DualLinks::DualLinks(const DualNet& net, std::span<const std::uint8_t> plane) : net_(net), plane_(plane) {
    for (std::uint32_t f = 0; f < net.face_count; ++f) {
        const std::uint32_t n = net.faces.face_offsets[f + std::size_t{1}] - net.faces.face_offsets[f];
        const std::uint32_t pieces = plane[f] != 0 ? n - 2 : 1, sides = plane[f] != 0 ? 3 : n;
        for (std::uint32_t p = 0; p < pieces; ++p)
            for (std::uint32_t s = 0; s < sides; ++s) entries_.push_back(entry({f, p, s}));
    }
    // An end of a crease lies over one edge.
    for (auto f = static_cast<std::uint32_t>(net.face_count); f < net.size(); ++f) {
        const std::uint32_t begin = net.faces.face_offsets[f];
        const std::uint32_t a = net.faces.face_vertices[begin], b = net.faces.face_vertices[begin + 1];
        entries_.push_back({std::min(a, b), std::max(a, b), {f, 0, 0}});
    }
    std::sort(entries_.begin(), entries_.end());
}

std::optional<DualLinks::Side> DualLinks::across(const Side& side) const {
    const Entry own = entry(side);
    const auto range = std::equal_range(entries_.begin(), entries_.end(), own, [](const Entry& a, const Entry& b) {
        return a.low != b.low ? a.low < b.low : a.high < b.high;
    });
    if (range.second - range.first != 2) return std::nullopt;
    const Side other = range.first->side == side ? range.first[1].side : range.first->side;
    return other;
}

}  // namespace tetrakis::detail
