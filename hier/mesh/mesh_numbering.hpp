#pragma once

#include "control_mesh.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace tetrakis::detail {

inline constexpr std::uint32_t k_no_number = VertexId::none;
inline std::uint32_t count_of(std::size_t size) { return static_cast<std::uint32_t>(size); }

/// New numbers of elements, some of which are removed.
struct Numbering {
    std::vector<std::uint32_t> number, kept;  ///< by old number, k_no_number if removed; by new number

    /// @param first  by element: itself if it stays, k_no_number if it is removed, or an earlier one to replace it
    explicit Numbering(const std::vector<std::uint32_t>& first) : number(first.size(), k_no_number) {
        for (std::uint32_t i = 0; i < first.size(); ++i) {
            if (first[i] == i) kept.push_back(i);
            if (first[i] != k_no_number)
                number[i] = first[i] == i ? static_cast<std::uint32_t>(kept.size() - 1) : number[first[i]];
        }
    }
    /// Leaves numbers of missing elements as they are.
    void follow(std::uint32_t& i) const {
        if (i < number.size()) i = number[i];
    }
};

/// Replaces a layer's elements: element i becomes the old element from[i]. An empty layer stays empty.
template <class T>
void gather(std::vector<T>& layer, const std::vector<std::uint32_t>& from) {
    if (layer.empty()) return;
    std::vector<T> result(from.size());
    for (std::size_t i = 0; i < from.size(); ++i) result[i] = layer[from[i]];
    layer = std::move(result);
}

/// Faces made of corners of a mesh.
struct NewFaces {
    /// Corners, and the source face of each new face (ascending), both by the old numbers.
    std::vector<std::uint32_t> offsets{0}, corners, sources;

    void end_face(std::uint32_t source) {
        offsets.push_back(static_cast<std::uint32_t>(corners.size()));
        sources.push_back(source);
    }
};
/// Replaces the mesh's faces by these. Attributes and hole tags follow.
/// @return  the hole tags of faces that are gone
std::vector<std::uint32_t> replace_faces(ControlMeshData& data, const NewFaces& faces);

/// Whether all coordinates are finite and at most k_max_coordinate.
bool is_sound_position(const Vec3d& p);

/// By vertex: of the listed vertices with exactly its coordinates the lowest; an unlisted vertex itself. O(n log n).
std::vector<std::uint32_t> first_at_position(std::span<const Vec3d> positions, std::vector<std::uint32_t> listed);

/// By vertex: the lowest of the vertices that weld() joins it with.
std::vector<std::uint32_t> welded(const std::vector<Vec3d>& positions, double distance);

/// A warning, if many boundary edges of a mesh coincide with one other boundary edge of opposite direction.
/// @param twin  as MeshLinks::twin
std::optional<std::string> unwelded_edges(const ControlMeshData& data, std::span<const std::uint32_t> twin);

}  // namespace tetrakis::detail
