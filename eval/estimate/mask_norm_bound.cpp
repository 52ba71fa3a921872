#include "mask_norm_bound.hpp"

#include "../../hier/base/parallel.hpp"
#include "../../refine/rules/rule_refiner.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "../distance/surface_family.hpp"
#include "../surface/local_frame.hpp"
#include "../surface/site_limits.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <unordered_map>

namespace tetrakis {

namespace {

constexpr std::uint32_t k_block = 256;
// Maximum number of levels below a piece. Around an extraordinary point the remainder halves with each level, so after
// this many it is smaller than any accuracy required.
constexpr int k_deepest = 16;
// Maximum number of cells of a piece on one level; above it, the bounds found so far are used. If the true error is
// almost 0, as on a flat surface with uneven parameters, no bound is ever tight.
constexpr std::uint32_t k_most_cells = 256;
// Beside semi-sharp edges there are no norms until the edges are smooth; on deeper levels too many cells lie along one.
constexpr float k_most_sharp_levels = 6;
// Without an aim, errors below this share of the model's diagonal need not be tight.
constexpr double k_no_error = 1e-7;
// Size limit of levels that are made as a whole, some 10 MB. In these most cells of small meshes get norms.
constexpr int k_most_halfedges = 1 << 18;
constexpr double k_infinite = std::numeric_limits<double>::infinity();

/// The part of a flat triangle over one cell, in cell coordinates (sides of length 1). Its sides are labelled with the
/// edges of the triangle that they lie over.
using Part = detail::LabelledPolygon;

/// The error of a level's mesh over a part of one of its cells.
struct PartError {
    double at_corners;  ///< largest error at corners
    double most;
    bool whole;  ///< whether the part is the whole cell
};

/// @param corner  corners of the cell
PartError part_error(const Part& part, const std::array<Vec3d, 4>& corner, int cell_corners,
                     const detail::FaceDistance& triangle) {
    PartError error{0, 0, part.size() == static_cast<std::size_t>(cell_corners)};
    Vec2d low(1), high(0);
    for (std::size_t i = 0; i < part.size(); ++i) {
        const Vec2d& at = part.corner(i);
        const auto weight = detail::corner_weights(at, cell_corners);
        const Vec3d p = triangle.local(weight[0] * corner[0] + weight[1] * corner[1] + weight[2] * corner[2] +
                                       weight[3] * corner[3]);
        double here = triangle.to_face(p);
        for (const int edge : {part.edge(i), part.edge((i + part.size() - 1) % part.size())})
            if (edge >= 0) here = std::max(here, triangle.to_edge(p, static_cast<std::size_t>(edge)));
        error.at_corners = std::max(error.at_corners, here);
        error.whole = error.whole && at == glm::round(at);
        low = glm::min(low, at);
        high = glm::max(high, at);
    }
    // Errors are convex, and every point (x, y) of the part is a weighted mean of its corners. In a whole cell the
    // bilinear patch is the mean of its corners with the same weights. In a smaller part it differs from that mean by
    // the twist times the covariance of the corners' x and y: at most a quarter of the product of their ranges.
    error.most = error.at_corners;
    if (cell_corners == 4 && !error.whole)
        error.most +=
            0.25 * (high.x - low.x) * (high.y - low.y) * glm::length(corner[0] - corner[1] + corner[2] - corner[3]);
    return error;
}

}  // namespace

/// A cell of some level with the points that its norms use or, without norms, with its corners. Children of a cell with
/// norms are made without a mesh.
struct Cell {
    detail::CellFrame frame;         ///< in the level's mesh, if it has no norms
    const detail::CellNorms* norms;  ///< nullptr: none
    int turn = 0;                    ///< the corner that is the first one of its norms
    std::vector<Vec3d> points{};
    double rest = -1;  ///< norms->remainder(points); negative: not computed yet
    std::array<Cell*, 4> children{};

    /// @param n  number of corners of all cells
    std::array<Vec3d, 4> corners(int n) const {
        std::array<Vec3d, 4> corner{};
        for (int k = 0; k < n; ++k) corner[(k + turn) % n] = points[k];
        return corner;
    }
    double remainder() {
        if (rest < 0) rest = norms != nullptr ? norms->remainder(points) : k_infinite;
        return rest;
    }
};

/// The part of a piece in one cell.
template <class Family>
struct MaskNormBound<Family>::Walker {
    Cell* cell;
    std::uint32_t piece;
    Part part;        ///< of the piece, in cell coordinates
    double most = 0;  ///< bound on the error over `part`, once computed
};

/// Makes cells, level by level: from norms or, where a cell has none, from a mesh. At first these are whole levels,
/// then parts of levels.
template <class Family>
class MaskNormBound<Family>::Descent {
  public:
    explicit Descent(const MaskNormBound& bound)
        : bound_(bound), corners_(bound.norms_.corners()), here_(&bound.whole_.front()) {}

    /// A cell of the present level's mesh.
    Cell& add(const detail::CellFrame& frame, int level, std::deque<Cell>& cells) {
        int h = detail::face_corner(mesh(), frame, 0, corners_);
        const int face = mesh().face(h);
        auto at = here_->cells.find(face);
        if (at == here_->cells.end())
            at = here_->cells.emplace(face, bound_.norms_.of_cell(mesh(), h, level, parts_)).first;
        const detail::NormedCell& found = at->second;
        Cell& cell = cells.emplace_back(frame, found.norms);
        for (; h != found.first; h = mesh().next(h)) ++cell.turn;
        for (const int v : found.points) cell.points.push_back(here_->net[static_cast<std::size_t>(v)]);
        return cell;
    }
    /// Makes the next level's mesh around the cells without norms. Their frames remain those of the level above.
    void go_down(std::span<const Walker> walkers) {
        std::vector<Cell*> in_mesh;
        for (const Walker& w : walkers)
            if (w.cell->norms == nullptr) in_mesh.push_back(w.cell);
        if (in_mesh.empty()) return;
        above_ = &mesh();
        if (++depth_ < bound_.whole_.size()) {
            here_ = &bound_.whole_[depth_];
            return;
        }
        std::ranges::sort(in_mesh);
        in_mesh.erase(std::ranges::unique(in_mesh).begin(), in_mesh.end());
        // n rings of a level give 2 n rings of the next one, less the two that the rules' stencils take.
        const int rings = std::max(bound_.norms_.rings() + 1, 4);
        std::vector<int> seeds;
        for (const Cell* cell : in_mesh)
            for (const int v : mesh().corners(mesh().face(cell->frame.halfedge))) seeds.push_back(v);
        part_ = parts_.find(mesh(), seeds, rings);
        for (Cell* cell : in_mesh) cell->frame.halfedge = part_.halfedge(mesh(), cell->frame.halfedge);
        std::vector<Vec3d> net;
        for (const int v : part_.vertex) net.push_back(here_->net[static_cast<std::size_t>(v)]);
        own_ = bound_.level(depth_, part_.mesh, net);
        here_ = &own_;
        above_ = &part_.mesh;
    }
    /// A child of a cell; if it does not exist yet, it is made in `finer`.
    /// @param level  the child's
    Cell& child(Cell& cell, int number, int level, std::deque<Cell>& finer) {
        Cell*& child = cell.children[static_cast<std::size_t>(number)];
        if (child != nullptr) return *child;
        if (cell.norms != nullptr) {
            const int turned = number < corners_ ? (number + corners_ - cell.turn) % corners_ : number;
            const detail::CellNorms::Child& of = cell.norms->children[static_cast<std::size_t>(turned)];
            child = &finer.emplace_back(detail::CellFrame{}, of.norms, cell.turn);
            child->points.resize(of.norms->point.size());
            of.rows.template apply<Vec3d>(cell.points, child->points);
        } else if (corners_ == 4 && level == 0) {  // the corner cell of a half-edge
            child = &add({here_->made.child_halfedge[cell.frame.halfedge], 0}, level, finer);
        } else {
            child = &add(detail::child_cell(*above_, here_->made, cell.frame, number, corners_), level, finer);
        }
        return *child;
    }

  private:
    const RuleMesh& mesh() const { return here_->made.mesh; }

    const MaskNormBound& bound_;
    int corners_;
    const Level* here_;
    std::size_t depth_ = 0;            ///< steps from the control mesh
    const RuleMesh* above_ = nullptr;  ///< mesh that the last step refined
    detail::MeshPart part_;
    Level own_;
    detail::MeshPartFinder parts_;
};

bool has_mask_norms(const SchemeInfo& scheme, const RuleOptions& rules) {
    if (scheme.has_chosen_steps() && rules.averaging_steps <= 0) return false;
    return fan_lattice(scheme, rules) != FanLattice::dual && scheme.refinement != Refinement::sqrt3 &&
           !scheme.is_linear();
}

template <class Family>
bool MaskNormBound<Family>::has(const SchemeInfo& scheme, const RuleOptions& rules, const ControlMesh& mesh) {
    const auto lasts = [](float sharpness) { return is_semi_sharp(sharpness) && sharpness > k_most_sharp_levels; };
    for (std::uint32_t e = 0; e < mesh.edge_count(); ++e)
        if (lasts(mesh.sharpness(EdgeId(e)))) return false;
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
        if (lasts(mesh.sharpness(VertexId(v))) || mesh.valence(VertexId(v)) > detail::k_most_edges) return false;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f)
        if (mesh.face_size(FaceId(f)) > detail::k_most_edges) return false;
    return has_mask_norms(scheme, rules);
}

template <class Family>
MaskNormBound<Family>::MaskNormBound(const Hierarchy& points, const SchemeInfo& scheme, const RuleOptions& rules,
                                     double aim, double tight)
    : mesh_(points.mesh()),
      points_(points),
      scheme_(scheme),
      rules_(rules),
      decides_(aim > 0),
      tight_(tight),
      norms_(scheme, rules) {
    rules_.runner = nullptr;  // no nested parallelism: a thread must not start another block inside one
    rounding_ = detail::surface_rounding(mesh_, averaging_steps(scheme, rules));
    aim_ = std::max(aim > 0 ? aim - rounding_ : k_no_error * mesh_.bounding_box().diagonal(), 0.0);
    Level control;
    control.made.mesh = rule_mesh(mesh_, rules);
    control.net.assign(mesh_.positions().begin(), mesh_.positions().end());
    first_step_ = first_rule_step(scheme, control.made.mesh);
    whole_.push_back(std::move(control));
    while (4 * whole_.back().made.mesh.halfedge_count() <= k_most_halfedges)
        whole_.push_back(level(whole_.size(), whole_.back().made.mesh, whole_.back().net));
}

template <class Family>
auto MaskNormBound<Family>::level(std::size_t depth, const RuleMesh& mesh, std::span<const Vec3d> net) const -> Level {
    // Quads: the first step makes the cells.
    Level level{(norms_.corners() == 4 && depth == 1 ? first_step_ : scheme_.step)(mesh, rules_)};
    level.net.resize(static_cast<std::size_t>(level.made.stencils.row_count()));
    level.made.stencils.template apply<Vec3d>(net, level.net);
    level.made.stencils = {};
    return level;
}

template <class Family>
void MaskNormBound<Family>::bound_pieces(std::span<const Piece> pieces, std::span<const std::uint32_t> of,
                                         std::optional<double> known, std::span<double> errors) const {
    const Wanted wanted = known ? Wanted{std::max(aim_, *known - rounding_), false} : Wanted{aim_, decides_};
    std::vector<double> found(pieces.size());
    const auto count = static_cast<std::uint32_t>(pieces.size());
    for_each_index((count + k_block - 1) / k_block,
                   [&](std::uint32_t b) {
                       const std::size_t begin = std::size_t{b} * k_block,
                                         size = std::min<std::size_t>(k_block, pieces.size() - begin);
                       bound_block(pieces.subspan(begin, size), wanted, std::span(found).subspan(begin, size));
                   },
                   1);
    for (std::size_t i = 0; i < pieces.size(); ++i) errors[of[i]] = std::max(errors[of[i]], found[i]);
}

template <class Family>
void MaskNormBound<Family>::bound_block(std::span<const Piece> pieces, Wanted wanted, std::span<double> errors) const {
    const int n = norms_.corners(), first_level = n == 4 ? -1 : 0;  // quads: from the control mesh to its corner cells
    Descent descent(*this);
    std::deque<Cell> cells, finer;  // of this level, and of the next one
    std::unordered_map<std::uint32_t, Cell*> roots;
    std::vector<Walker> walkers, next;
    for (std::uint32_t i = 0; i < pieces.size(); ++i) {
        const std::uint32_t h = pieces[i].cell.value;
        Cell*& root = roots[h];
        if (root == nullptr) root = &descent.add({static_cast<int>(h), 0}, first_level, cells);
        walkers.emplace_back(root, i, pieces[i].part);
    }
    std::fill(errors.begin(), errors.end(), rounding_);
    std::vector<double> least(pieces.size(), 0.0);  // lower bounds on the errors
    std::vector<std::uint8_t> decided(pieces.size(), 0);
    std::vector<std::uint32_t> open(pieces.size());  // number of undecided cells
    for (int level = first_level; !walkers.empty(); ++level) {
        next.clear();
        for (const Walker& w : walkers) {
            const Piece& piece = pieces[w.piece];
            if (level < piece.level) {
                next.push_back(w);
                continue;
            }
            if (decided[w.piece] != 0) continue;
            const double rest = w.cell->remainder();
            const PartError off = part_error(w.part, w.cell->corners(n), n, piece.triangle);
            // Vertices of an interpolating scheme are limit points.
            const double apart = scheme_.interpolating && off.whole ? 0 : rest;
            least[w.piece] = std::max(least[w.piece], off.at_corners - apart);
            const double most = off.most + rest, sure = least[w.piece];
            const bool exceeds = sure > wanted.floor;
            const double floor = exceeds && !wanted.decide ? tight_ * sure : wanted.floor;
            if (most <= floor || level >= piece.level + k_deepest)
                errors[w.piece] = std::max(errors[w.piece], most + rounding_);
            else if (wanted.decide && exceeds)
                decided[w.piece] = 1;
            else
                next.emplace_back(w).most = most;
        }
        std::fill(open.begin(), open.end(), 0u);
        for (const Walker& w : next) ++open[w.piece];
        std::erase_if(next, [&](const Walker& w) {
            if (decided[w.piece] != 0) return true;
            if (open[w.piece] <= k_most_cells) return false;
            errors[w.piece] = std::max(errors[w.piece], w.most + rounding_);
            return true;
        });
        descent.go_down(next);
        walkers.clear();
        finer.clear();
        for (const Walker& w : next)
            for (int number = 0; number < (level < 0 ? 1 : 4); ++number)
                if (const Part part = level < 0 ? w.part : in_quarter(w.part, number, n); !part.empty())
                    walkers.emplace_back(&descent.child(*w.cell, number, level + 1, finer), w.piece, part);
        std::swap(cells, finer);
    }
    for (std::size_t i = 0; i < pieces.size(); ++i)
        if (decided[i] != 0) errors[i] = least[i] + rounding_;
}

template <class Family>
void MaskNormBound<Family>::bound(std::span<const CellTriangle> triangles, std::optional<double> known,
                                  std::span<double> errors) const {
    const auto count = static_cast<std::uint32_t>(triangles.size());
    std::vector<Site> sites(3 * triangles.size());
    for_each_index(count, [&](std::uint32_t t) {
        for (std::size_t k = 0; k < 3; ++k)
            sites[3 * std::size_t{t} + k] = Family::canonical_site(mesh_, Family::corner_site(mesh_, triangles[t], k));
    });
    std::vector<Vec3d> points(sites.size());
    detail::limit_positions_once(points_, sites, points);
    std::vector<Piece> pieces;
    std::vector<std::uint32_t> of;
    for (std::uint32_t t = 0; t < count; ++t) {
        const CellTriangle& triangle = triangles[t];
        const Vec3d* const p = &points[3 * std::size_t{t}];
        const detail::FaceDistance face(std::array{p[0], p[1], p[2]});
        const double unit = std::ldexp(1.0, -triangle.level);
        std::array<Vec2d, 3> at;
        for (std::size_t k = 0; k < 3; ++k) at[k] = unit * Vec2d(triangle.corner[k].x, triangle.corner[k].y);
        detail::for_each_corner_cell(Part({at, {0, 1, 2}}), [&](const Part& part, bool is_next) {
            pieces.push_back({is_next ? mesh_.next(triangle.root) : triangle.root, triangle.level, part, face});
        });
        of.resize(pieces.size(), t);
    }
    std::fill(errors.begin(), errors.end(), 0.0);
    bound_pieces(pieces, of, known, errors);
}

template <class Family>
void MaskNormBound<Family>::bound_fans(const FanChoice& fans, std::span<const FaceId> faces,
                                       std::span<const Vec3d> corners, std::optional<double> known,
                                       std::span<double> errors) const {
    // Each corner cell is cut in two halves, from the corner to the centre. Each half is bounded against a triangle in
    // the fan: its corners are the corner, the middle of an edge, and the middle of the fan, which is on the diagonal.
    std::vector<Piece> pieces;
    std::vector<std::uint32_t> of;
    for (std::uint32_t i = 0; i < faces.size(); ++i) {
        errors[i] = mesh_.face_size(faces[i]) <= 4 ? 0 : k_infinite;
        if (errors[i] > 0) continue;
        const std::uint32_t size = mesh_.face_size(faces[i]), h0 = mesh_.face_halfedge(faces[i]).value;
        const auto at = [&](std::uint32_t c) { return corners[mesh_.origin(HalfedgeId(h0 + c % size)).value]; };
        Vec3d centre = (at(0) + at(1) + at(2)) / 3.0;
        if (size == 4) {
            // The corner that is not in the first triangle lies opposite the diagonal.
            const auto& one = fans.of(faces[i])[0];
            const std::uint32_t out_of_it = 6u - one[0] - one[1] - one[2];
            centre = 0.5 * (at(out_of_it + 1) + at(out_of_it + 3));
        }
        for (std::uint32_t c = 0; c < size; ++c) {
            const Vec3d ahead = 0.5 * (at(c) + at(c + 1)), behind = 0.5 * (at(c) + at(c + size - 1));
            const auto add = [&](const Vec2d& a, const Vec2d& b, const Vec3d& p, const Vec3d& q) {
                pieces.push_back(
                    {HalfedgeId(h0 + c), 0, Part({{Vec2d(0), a, b}, {0, 1, 2}}), detail::FaceDistance({at(c), p, q})});
            };
            add({1, 0}, {1, 1}, ahead, centre);
            add({1, 1}, {0, 1}, centre, behind);
        }
        of.resize(pieces.size(), i);
    }
    bound_pieces(pieces, of, known, errors);
}

template class MaskNormBound<QuadFamily>;
template class MaskNormBound<LoopFamily>;

}  // namespace tetrakis
