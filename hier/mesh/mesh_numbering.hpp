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

/// New numbers of elements of which some stay.
struct Numbering {
    std::vector<std::uint32_t> number, kept;  ///< by old number, k_no_number of those that go; by new number

    /// @param first  by element: itself if it stays, k_no_number if it goes, or an earlier one that it becomes
    explicit Numbering(const std::vector<std::uint32_t>& first) : number(first.size(), k_no_number) {
        for (std::uint32_t i = 0; i < first.size(); ++i) {
            if (first[i] == i) kept.push_back(i);
            if (first[i] != k_no_number)
                number[i] = first[i] == i ? static_cast<std::uint32_t>(kept.size() - 1) : number[first[i]];
        }
    }
    /// Numbers of nothing stay as they are.
    void follow(std::uint32_t& i) const {
        if (i < number.size()) i = number[i];
    }
};

/// Puts elements in place of a layer's own, by the numbers that they have now. An empty layer stays empty.
template <class T>
void gather(std::vector<T>& layer, const std::vector<std::uint32_t>& from) {
    if (layer.empty()) return;
    std::vector<T> result(from.size());
    for (std::size_t i = 0; i < from.size(); ++i) result[i] = layer[from[i]];
    layer = std::move(result);
}

/// Faces made of some corners of a mesh.
struct NewFaces {
    /// Corners, and per face the one that it comes from: ascending numbers. Both by the arrays as they are.
    std::vector<std::uint32_t> offsets{0}, corners, sources;

    void end_face(std::uint32_t source) {
        offsets.push_back(static_cast<std::uint32_t>(corners.size()));
        sources.push_back(source);
    }
};
/// Puts them in place of the mesh's own faces, with their attributes; tags of holes follow.
/// @return  the hole tags whose faces are gone
std::vector<std::uint32_t> replace_faces(ControlMeshData& data, const NewFaces& faces);

/// Whether all coordinates are finite and at most k_max_coordinate.
bool is_sound_position(const Vec3d& p);

/// By vertex: the lowest of the listed ones that have its very coordinates; of others itself. O(n log n).
std::vector<std::uint32_t> first_at_position(std::span<const Vec3d> positions, std::vector<std::uint32_t> listed);

/// By vertex: the lowest one of those that weld() joins it with.
std::vector<std::uint32_t> welded(const std::vector<Vec3d>& positions, double distance);

/// The warning of a mesh of which many boundary edges lie on another one that runs the other way.
/// @param twin  as MeshLinks::twin
std::optional<std::string> unwelded_edges(const ControlMeshData& data, std::span<const std::uint32_t> twin);

}  // namespace tetrakis::detail
