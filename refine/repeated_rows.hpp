#pragma once

#include "tetrakis/hier/run_context.hpp"
#include "tetrakis/hier/vec.hpp"
#include "tetrakis/refine/root_layout.hpp"
#include "tetrakis/refine/rule_levels.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// Structured refinement by the rules of any scheme that cuts faces into lattices (face splits, 4-8, sqrt3 by two steps
/// at a time), and of dual schemes on meshes without creases.
///
/// The first levels go by rules. One step of theirs, from lattices large enough that what is special at a corner of a
/// root is not seen from its other corners, says everything about all later ones: rows of weights are the same
/// inside every root; along each side; around each corner, at the same places counted from there. So the later levels
/// only read those rows again, at other places, which are found by arithmetic.
///
/// The roots are the faces of the control mesh, or (quads, on a mesh with other faces) of its first refinement; points
/// are in the order of RootLayout. Of a dual scheme the roots are the quads of the first refinement by face splits, one
/// per half-edge, and one beyond each side on the boundary; points lie in the cells of their lattices: root by root,
/// row by row.
class RepeatedRows {
  public:
    /// What a result takes: points, faces (with where they begin and the control face of each) and their corners.
    struct Demand {
        std::uint64_t point_bytes = sizeof(Vec3d), face_bytes = 2 * sizeof(std::uint32_t),
                      corner_bytes = sizeof(std::uint32_t);
    };
    /// Null where there is nothing to gain or it cannot be done: too few levels; a scheme or mesh (boundaries that
    /// recede, something that turns from sharp to smooth on the way, roots glued to themselves) whose rows do not
    /// repeat.
    /// @param levels_by_rules  not advanced yet; taken, or else left with the levels that the attempt has needed
    /// @param levels           from the control mesh to the last
    /// @throws Error  as RuleRefiner
    static std::unique_ptr<RepeatedRows> make(const ControlMesh& mesh, const SchemeInfo& scheme, int levels,
                                              const RuleOptions& rules, std::unique_ptr<RuleLevels>& levels_by_rules,
                                              const Demand& demand, const RunContext& context);

    std::uint32_t point_count() const { return points_of({base_, segments_.back()}); }
    /// Faces of the last level, and the control face that each belongs to; corners of the same face of two refinements
    /// of meshes with the same faces are in the same places.
    struct Faces {
        std::vector<std::uint32_t> offsets, vertices, control;
    };
    Faces faces(const RunContext& context) const;

    /// Points of the last level. The same bytes for any number of threads.
    void refine(std::span<const Vec3d> control, std::span<Vec3d> points, const RunContext& context) const;

  private:
    static constexpr std::uint32_t none = MeshLevel::none;
    static constexpr std::uint32_t k_grain = 4;  ///< roots per task
    struct Place {
        std::uint32_t x, y;
    };
    /// A term of a row near a corner: point (a, b) of the lattice of the root `turn` half-edges counter-clockwise
    /// around the corner, from there; or, near a side, of its own root (0) or the one beyond (1).
    struct Term {
        std::int16_t turn, a, b;
        double weight;
        auto operator<=>(const Term&) const = default;
    };
    using Row = std::vector<Term>;
    using Pattern = std::vector<Row>;
    /// A term inside a root: the point (dx, dy) from where the new one lies.
    struct Offset {
        int dx, dy;
        double weight;
    };

    explicit RepeatedRows(std::uint32_t factor) : factor_(factor) {}

    bool set_base(const RuleMesh& mesh, const RuleLevels& levels);
    bool has_simple_roots() const;
    std::optional<std::vector<int>> lattice(const RootLayout& at, const RuleMesh& mesh,
                                            std::span<const int> corner_halfedge) const;
    std::optional<std::vector<int>> cells(const RootLayout& at, const RuleMesh& mesh,
                                          std::span<const int> last_halfedge) const;
    Faces cell_faces() const;
    // Points of a level: of lattices or in their cells.
    std::uint32_t points_of(const RootLayout& at) const {
        return in_cells_ ? static_cast<std::uint32_t>(at.cell_count()) : at.vertex_count();
    }
    std::uint32_t last_place(std::uint32_t segments) const { return in_cells_ ? segments - 1 : segments; }
    std::uint32_t number_at(const RootLayout& at, std::uint32_t f, const Place& p) const {
        const std::uint32_t n = at.segments();
        return in_cells_ ? (f * n + p.y) * n + p.x : at.at(f, p.x, p.y);
    }
    /// A step of the rules, with the numbers that its points have in the layouts and the other way round.
    struct Lesson {
        const RootLayout &coarse, &fine;
        std::span<const int> coarse_number, fine_vertex;
        const StencilTable& rows;
        std::uint32_t number(int coarse_vertex) const {
            return static_cast<std::uint32_t>(coarse_number[coarse_vertex]);
        }
    };
    bool learn(const Lesson& lesson);
    bool learn_inside(const Lesson& lesson);
    template <class TermAt>
    bool row_of(const Lesson& lesson, std::uint32_t h, const Place& place, const TermAt& term_at, Row& out) const;
    bool corner_rows(const Lesson& lesson, std::uint32_t h, Pattern& out) const;
    bool side_rows(const Lesson& lesson, std::uint32_t h, Pattern& out) const;

    // Lattices seen from half-edge h: a along it, b away from it; n is the last place.
    std::uint32_t side_count() const { return static_cast<std::uint32_t>(base_.face_size); }
    Place turned(std::uint32_t n, std::uint32_t side, std::uint32_t a, std::uint32_t b) const;
    Place seen_from(std::uint32_t n, std::uint32_t side, const Place& p) const;
    std::uint32_t number(const RootLayout& at, std::uint32_t h, std::uint32_t a, std::uint32_t b) const;
    std::optional<Place> place_in(const RootLayout& at, std::uint32_t f, std::uint32_t number) const;
    std::optional<Term> at_corner(const RootLayout& at, std::uint32_t h, std::uint32_t number) const;
    std::optional<Term> at_side(const RootLayout& at, std::uint32_t h, std::uint32_t number) const;
    /// What is left beyond a from the other end of the line b away from the side.
    std::uint32_t rest(std::uint32_t n, std::uint32_t a, std::uint32_t b) const {
        return base_.face_size == 4 ? n - a : n - a - b;
    }

    struct Work;
    void step(const RootLayout& coarse, const RootLayout& fine, const Vec3d* in, Vec3d* out) const;
    void inside(const RootLayout& coarse, const RootLayout& fine, std::uint32_t f, Vec3d* out, const Work& work) const;
    void side(const RootLayout& coarse, const RootLayout& fine, std::uint32_t h, const Vec3d* in, Vec3d* out,
              Work& work) const;
    void corner(const RootLayout& coarse, const RootLayout& fine, std::uint32_t h, const Vec3d* in, Vec3d* out) const;

    std::unique_ptr<RuleLevels> levels_;
    std::uint32_t factor_;
    bool in_cells_ = false;
    std::uint32_t own_roots_ = 0;  ///< in cells: the others lie beyond the boundary
    MeshLevel base_;
    std::vector<std::uint32_t> base_face_;  ///< control face of each root
    std::vector<std::uint32_t> segments_;   ///< of the last level by rules, and of those after it
    std::vector<int> vertices_;             ///< the rules' number of each point of that level
    std::ptrdiff_t template_segments_ = 0;  ///< of the level whose step all later ones repeat

    std::uint32_t depth_ = 0;                  ///< points that far from all sides go by the rows inside
    std::uint32_t reach_ = 0;                  ///< from a corner along a side: points nearer than that are its
    std::vector<std::vector<Offset>> inside_;  ///< by the place modulo the factor: y, then x
    std::vector<Place> corner_places_;
    std::vector<Pattern> corner_patterns_, side_patterns_;
    std::vector<std::uint32_t> corner_pattern_, side_pattern_;  ///< of each half-edge
};

inline RepeatedRows::Place RepeatedRows::turned(std::uint32_t n, std::uint32_t side, std::uint32_t a,
                                                std::uint32_t b) const {
    if (base_.face_size == 4) {
        const Place places[4] = {{a, b}, {n - b, a}, {n - a, n - b}, {b, n - a}};
        return places[side];
    }
    const Place places[3] = {{a, b}, {n - a - b, a}, {b, n - a - b}};
    return places[side];
}

inline RepeatedRows::Place RepeatedRows::seen_from(std::uint32_t n, std::uint32_t side, const Place& p) const {
    if (base_.face_size == 4) {
        const Place places[4] = {p, {p.y, n - p.x}, {n - p.x, n - p.y}, {n - p.y, p.x}};
        return places[side];
    }
    const Place places[3] = {p, {p.y, n - p.x - p.y}, {n - p.x - p.y, p.x}};
    return places[side];
}

inline std::uint32_t RepeatedRows::number(const RootLayout& at, std::uint32_t h, std::uint32_t a,
                                          std::uint32_t b) const {
    return number_at(at, h / side_count(), turned(last_place(at.segments()), h % side_count(), a, b));
}

}  // namespace tetrakis::detail
