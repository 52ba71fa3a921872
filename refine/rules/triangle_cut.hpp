#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// Replaces the items (of faces or face corners) by the items with the given numbers. An empty list stays empty.
template <class T>
void pick(const std::vector<std::uint32_t>& places, std::vector<T>& items) {
    if (items.empty()) return;
    std::vector<T> picked;
    picked.reserve(places.size());
    for (const std::uint32_t i : places) picked.push_back(items[i]);
    items.swap(picked);
}

/// Polygons cut into triangles, in their order.
struct TriangleCut {
    std::vector<std::uint32_t> corners;  ///< three per triangle: numbers of face corners of the polygons
    std::vector<std::uint32_t> faces;    ///< per triangle: its polygon

    /// Face offsets of the triangles: 0, 3, 6, ... up to the number of corners.
    std::vector<std::uint32_t> offsets() const {
        std::vector<std::uint32_t> result(faces.size() + 1);
        for (std::uint32_t t = 0; t < result.size(); ++t) result[t] = 3 * t;
        return result;
    }
};

/// Cuts quads along their diagonal in the 4-8 pattern, larger faces into fans.
/// @param face_offsets       F + 1
/// @param diagonal_at_first  per face, see DualFaces
inline TriangleCut cut_polygons(std::span<const std::uint32_t> face_offsets,
                                std::span<const std::uint8_t> diagonal_at_first) {
    TriangleCut cut;
    for (std::uint32_t f = 0; f + 1 < face_offsets.size(); ++f) {
        const std::uint32_t begin = face_offsets[f], size = face_offsets[f + 1] - begin;
        const std::uint32_t start = size == 4 && diagonal_at_first[f] == 0 ? 1 : 0;
        const auto corner = [&](std::uint32_t k) { return begin + (start + k) % size; };
        for (std::uint32_t k = 1; k + 1 < size; ++k) {
            cut.corners.insert(cut.corners.end(), {corner(0), corner(k), corner(k + 1)});
            cut.faces.push_back(f);
        }
    }
    return cut;
}

}  // namespace tetrakis::detail
