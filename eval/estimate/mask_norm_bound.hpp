#pragma once

#include "../../refine/adaptive/hierarchy.hpp"
#include "../bounds/labelled_polygon.hpp"
#include "../triangles/triangle_distance.hpp"
#include "cell_norms.hpp"
#include "surface_bound.hpp"

#include <oneapi/tbb/concurrent_unordered_map.h>

#include <array>
#include <vector>

namespace tetrakis {

/// Whether a scheme has the bounds below: those of triangles and quads by face split, averaging in even numbers of
/// steps (two at least) among them.
bool has_mask_norms(const SchemeInfo& scheme, const RuleOptions& rules = {});

/// Certified errors over limit surfaces that are no polynomials: those of interpolating schemes and others, on
/// triangles and quads. The error of a triangle is that of CellBounder. It is found on the mesh of a finer level, at
/// the corners of the parts of its cells that lie over the triangle, and how far the limit is from that mesh is known
/// by mask norms (CellNormTable): errors change no faster than points move. Levels are made around a triangle until
/// that does: by the rules, in a part of the mesh, until a cell has norms, and from there on by the rows that come with
/// these. The rounding of positions is included.
template <class Family>
class MaskNormBound final : public SurfaceBound {
  public:
    /// Whether there is one over this mesh. Semi-sharp tags change the rules from level to level, and the bound has to
    /// wait for the levels where they are smooth: none may last for more than six. Nor may a vertex have more than 64
    /// edges, or a face more than 64 corners: the weights would take too long to find.
    static bool has(const SchemeInfo& scheme, const RuleOptions& rules, const ControlMesh& mesh);

    /// @param points  gives the limit points; lives longer
    /// @param rules   live longer
    /// @param aim     errors above it are lower bounds; 0: there is none, and all are tight
    /// @param tight   bounds are tight where they are within this factor of an error that there is
    MaskNormBound(const Hierarchy& points, const SchemeInfo& scheme, const RuleOptions& rules, double aim,
                  double tight = 1.05);

    void bound(std::span<const CellTriangle> triangles, std::optional<double> known,
               std::span<double> errors) const override;
    void bound_fans(const FanChoice& fans, std::span<const FaceId> faces, std::span<const Vec3d> corners,
                    std::optional<double> known, std::span<double> errors) const override;

  private:
    /// What a root's cell has of a flat triangle.
    struct Piece {
        HalfedgeId cell;
        int level = 0;                   ///< of cells that are as large as the triangle
        detail::LabelledPolygon part{};  ///< in lengths of the cell's sides
        detail::TriangleDistance triangle{};
    };
    /// The mesh of a level, or a part of it.
    struct Level {
        RuleStep made;  ///< its mesh, and how the level above has become it
        std::vector<Vec3d> net{};
        /// By face, found when they are first asked for.
        mutable oneapi::tbb::concurrent_unordered_map<int, detail::NormedCell> cells{};
    };
    struct Walker;
    class MeshDescent;
    /// How well an error is to be known.
    struct Wanted {
        double floor;  ///< errors up to this need not be tighter
        bool decide;   ///< errors above it may be lower bounds; else they are tight
    };

    /// The level that so many steps make of the control mesh, from the one above.
    Level level(std::size_t depth, const RuleMesh& mesh, std::span<const Vec3d> net) const;
    void add_pieces(const CellTriangle& cells, const std::array<Vec3d, 3>& corners, std::vector<Piece>& pieces) const;
    Wanted wanted(std::optional<double> known) const;
    /// @param of      per piece: whose part it is
    /// @param errors  receives the largest of its pieces for each
    void bound_pieces(std::span<const Piece> pieces, std::span<const std::uint32_t> of, Wanted wanted,
                      std::span<double> errors) const;
    void bound_block(std::span<const Piece> pieces, Wanted wanted, std::span<double> errors) const;

    const ControlMesh& mesh_;
    const Hierarchy& points_;
    const SchemeInfo& scheme_;
    RuleOptions rules_;
    bool decides_;
    double aim_, tight_, rounding_;
    detail::CellNormTable norms_;
    RuleStep (*first_step_)(const RuleMesh&, const RuleOptions&) = nullptr;
    std::vector<Level> whole_;  ///< the control mesh, and the first levels of small ones
};

}  // namespace tetrakis
