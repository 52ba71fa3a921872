#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>

namespace tetrakis {

/// Index of one kind of element: 4 bytes, converts to and from nothing by itself.
template <class Tag>
struct Id {
    static constexpr std::uint32_t none = 0xFFFF'FFFFu;
    std::uint32_t value = none;

    constexpr Id() = default;
    constexpr explicit Id(std::uint32_t v) : value(v) {}
    constexpr bool valid() const { return value != none; }
    friend constexpr auto operator<=>(Id, Id) = default;
};

using VertexId = Id<struct VertexTag>;      ///< a control vertex
using HalfedgeId = Id<struct HalfedgeTag>;  ///< a half-edge, i.e. a face corner: number in `face_vertices`
using EdgeId = Id<struct EdgeTag>;          ///< an undirected edge
using FaceId = Id<struct FaceTag>;          ///< a control face
using LeafId = Id<struct LeafTag>;          ///< a slot of a hierarchy's leaf pool
using PointId = Id<struct PointTag>;        ///< a vertex of a hierarchy (one per site)

}  // namespace tetrakis

template <class Tag>
struct std::hash<tetrakis::Id<Tag>> {
    std::size_t operator()(tetrakis::Id<Tag> id) const noexcept { return std::hash<std::uint32_t>{}(id.value); }
};
