#pragma once

#include "surface_family.hpp"

#include <array>
#include <cmath>
#include <numbers>

namespace tetrakis {

/// Where a triangle of the output comes from: a triangle of the hierarchy, or one of a face's fan (eval/README.md).
struct OutputTriangle {
    CellTriangle cell;                          ///< unless it belongs to a fan
    FaceId fan;                                 ///< the face; invalid for triangles of the hierarchy
    std::array<std::uint32_t, 3> fan_corner{};  ///< corners of the face, by number in it

    /// The surface point that belongs to barycentrics (b0, b1, b2). A fan's triangles lie in the regular polygon whose
    /// corners are the face's, each root over its sector of it.
    template <class Family>
    SurfaceParameter parameter(const ControlMesh& mesh, double b0, double b1, double b2) const {
        if (!fan.valid()) return Family::parameter(mesh, cell, b0, b1, b2);
        const std::uint32_t n = mesh.face_size(fan);
        const double turn = 2 * std::numbers::pi / n;
        const double b[3] = {b0, b1, b2};
        double x = 0, y = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            x += b[k] * std::cos(turn * fan_corner[k]);
            y += b[k] * std::sin(turn * fan_corner[k]);
        }
        double angle = std::atan2(y, x);
        if (angle < 0) angle += 2 * std::numbers::pi;
        const std::uint32_t sector = std::min(n - 1, static_cast<std::uint32_t>(angle / turn));
        const double c0 = std::cos(turn * sector), s0 = std::sin(turn * sector);
        const double c1 = std::cos(turn * (sector + 1)), s1 = std::sin(turn * (sector + 1));
        const double det = c0 * s1 - c1 * s0;
        const double v = std::max(0.0, (x * s1 - y * c1) / det), w = std::max(0.0, (y * c0 - x * s0) / det);
        const double sum = std::max(1.0, v + w);
        const CellTriangle root{
            HalfedgeId(mesh.face_halfedge(fan).value + sector), 0, {LatticePoint{0, 0}, {2, 0}, {1, 1}}};
        return Family::parameter(mesh, root, v / sum, w / sum, 1 - (v + w) / sum);
    }
    /// An address of corner k inside one root.
    template <class Family>
    Site corner_site(const ControlMesh& mesh, std::size_t k) const {
        if (!fan.valid()) return Family::corner_site(mesh, cell, k);
        return {HalfedgeId(mesh.face_halfedge(fan).value + fan_corner[k]), {0, 0}, 0};
    }
    /// An address of a point inside the triangle near corner k: `steps` of 2^finer from the corner towards each of the
    /// two others. Of a fan's triangle, in the corner's own root. @param finer  levels below the triangle's
    template <class Family>
    Site inner_site(const ControlMesh& mesh, std::size_t k, int finer, std::uint32_t steps) const {
        if (fan.valid())
            return {HalfedgeId(mesh.face_halfedge(fan).value + fan_corner[k]),
                    {steps, steps},
                    static_cast<std::uint8_t>(finer)};
        const LatticePoint a = cell.corner[k], b = cell.corner[(k + 1) % 3], c = cell.corner[(k + 2) % 3];
        const std::uint32_t rest = (1u << finer) - 2 * steps;
        const LatticePoint p{rest * a.x + steps * (b.x + c.x), rest * a.y + steps * (b.y + c.y)};
        return Family::lattice_site(mesh, cell.root, p, cell.level + finer);
    }
};

}  // namespace tetrakis
