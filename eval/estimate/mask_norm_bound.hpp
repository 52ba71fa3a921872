#pragma once

#include "../../refine/adaptive/hierarchy.hpp"
#include "../bounds/labelled_polygon.hpp"
#include "../triangles/face_distance.hpp"
#include "cell_norms.hpp"
#include "surface_bound.hpp"

#include <oneapi/tbb/concurrent_unordered_map.h>

#include <vector>

namespace tetrakis {

/// Whether a scheme has the bounds below: schemes on triangles or quads by face split, also averaging in an even number
/// of steps, at least two.
bool has_mask_norms(const SchemeInfo& scheme, const RuleOptions& rules = {});

/// Certified errors over limit surfaces that are no polynomials, of schemes on triangles and quads. The error of a
/// triangle is defined as in CellBounder. It is computed on the mesh of a finer level, at the corners of those parts of
/// cells that lie over the triangle. Mask norms (CellNormTable) bound the distance from that mesh to the limit, which
/// is added, as errors change no faster than points move. Levels are made around a triangle until the bound is tight
/// enough. The rules make them in a part of the mesh until a cell has norms; then the rows of these norms are enough.
/// The rounding of positions is included.
template <class Family>
class MaskNormBound final : public SurfaceBound {
  public:
    /// Whether there is a bound over this mesh. Semi-sharp tags change the rules from level to level, so norms exist
    /// only on levels where they have become smooth. So no tag may last for more than six levels. No vertex may have
    /// more than 64 edges, and no face more than 64 corners: their weights would take too long to compute.
    static bool has(const SchemeInfo& scheme, const RuleOptions& rules, const ControlMesh& mesh);

    /// @param points  gives the limit points; must outlive the bound
    /// @param rules   must outlive the bound
    /// @param aim     errors above it are lower bounds; 0: no aim, all errors are tight upper bounds
    /// @param tight   a bound counts as tight if it is within this factor of an error that exists
    MaskNormBound(const Hierarchy& points, const SchemeInfo& scheme, const RuleOptions& rules, double aim,
                  double tight = 1.05);

    void bound(std::span<const CellTriangle> triangles, std::optional<double> known,
               std::span<double> errors) const override;
    void bound_fans(const FanChoice& fans, std::span<const FaceId> faces, std::span<const Vec3d> corners,
                    std::optional<double> known, std::span<double> errors) const override;

  private:
    /// The part of a flat triangle that lies over one root's cell.
    struct Piece {
        HalfedgeId cell;
        int level = 0;                   ///< level whose cells are as large as the triangle
        detail::LabelledPolygon part{};  ///< in the cell, whose sides have length 1
        detail::FaceDistance triangle{};
    };
    /// The mesh of a level, or a part of it.
    struct Level {
        RuleStep made;  ///< the step that made the level: its mesh, and where it comes from
        std::vector<Vec3d> net{};
        /// Norms by face, added on first use.
        mutable oneapi::tbb::concurrent_unordered_map<int, detail::NormedCell> cells{};
    };
    struct Walker;
    class Descent;
    /// Required accuracy of an error.
    struct Wanted {
        double floor;  ///< bounds up to this need not be tight
        bool decide;   ///< errors above `floor` may be lower bounds; else they are tight upper bounds
    };

    /// Makes level `depth` (number of steps from the control mesh) from the mesh and net of the level above.
    Level level(std::size_t depth, const RuleMesh& mesh, std::span<const Vec3d> net) const;
    /// @param of      per piece: number of its triangle or face
    /// @param errors  receives the largest error of the pieces of each triangle or face
    void bound_pieces(std::span<const Piece> pieces, std::span<const std::uint32_t> of, std::optional<double> known,
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
    std::vector<Level> whole_;  ///< the control mesh; if it is small, also its first levels
};

}  // namespace tetrakis
