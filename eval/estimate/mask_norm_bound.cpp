#include "mask_norm_bound.hpp"

#include "../../hier/base/parallel.hpp"
#include "../../refine/points/cell_frame.hpp"
#include "../../refine/rules/rule_refiner.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "../distance/limit_samples.hpp"
#include "../distance/surface_family.hpp"
#include "../surface/local_frame.hpp"
#include "../surface/site_limits.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

namespace tetrakis {

namespace {

constexpr std::uint32_t k_block = 256;
// Levels below a piece that are looked at. Around an extraordinary point the remainder halves from one to the next, so
// that this is where it is smaller than anything asked for.
constexpr int k_deepest = 16;
// Of a piece no more cells are looked at on one level: those count by what is known of them. Where hardly any error is
// attained, as on a flat sheet whose parameters run unevenly, no bound is ever tight.
constexpr std::uint32_t k_most_cells = 256;
// Beside semi-sharp edges nothing is known before they are smooth: cells as small as that are many along an edge.
constexpr float k_most_sharp_levels = 6;
// Errors that are as good as none, where nothing is aimed at: a share of the model's diagonal.
constexpr double k_no_error = 1e-7;
// Of levels that are made as a whole, some 10 MB: most cells of small meshes have norms there, whatever is around them.
constexpr int k_most_halfedges = 1 << 18;
constexpr double k_infinite = std::numeric_limits<double>::infinity();

}  // namespace

/// A piece in one of the cells that it reaches into: one of a mesh, or a known one, which needs no mesh.
template <class Family>
struct MaskNormBound<Family>::Walker {
    detail::CellFrame frame;
    std::uint32_t piece;
    PieceCorners at;   ///< the piece's corners, in sides of the cell
    int known = k_no;  ///< number of the known cell; `at` is then as seen from the corner that its norms are for
    double most = 0;   ///< bound on the error in the cell's part, once it is known

    static constexpr int k_no = -1;
};

/// Known cells of one level: those that have norms, with the points around them that matter.
template <class Family>
class MaskNormBound<Family>::KnownCells {
  public:
    /// Keeps the memory.
    void clear() {
        cells_.clear();
        points_.clear();
    }
    /// A new cell with room for its points. Returns its number.
    int add(const detail::CellNorms& norms) {
        cells_.push_back({&norms, points_.size()});
        points_.resize(points_.size() + norms.point.size());
        return static_cast<int>(cells_.size()) - 1;
    }
    std::span<Vec3d> points(int cell) {
        const Cell& c = cells_[static_cast<std::size_t>(cell)];
        return {points_.data() + c.begin, c.norms->point.size()};
    }
    std::array<Vec3d, 4> corners(int cell) {
        const std::span<const Vec3d> at = points(cell);
        std::array<Vec3d, 4> corner{};
        std::copy_n(at.begin(), std::min(corner.size(), at.size()), corner.begin());
        return corner;
    }
    double remainder(int cell) {
        Cell& c = cells_[static_cast<std::size_t>(cell)];
        if (c.remainder < 0) c.remainder = c.norms->remainder(points(cell));
        return c.remainder;
    }
    /// One of the four cells of the next level, which is made where `finer` does not have it yet.
    int child(int cell, int child, KnownCells& finer) {
        Cell& c = cells_[static_cast<std::size_t>(cell)];
        int& number = c.child[static_cast<std::size_t>(child)];
        if (number < 0) {
            const detail::CellNorms::Child& of = c.norms->children[static_cast<std::size_t>(child)];
            number = finer.add(*of.norms);
            of.rows.template apply<Vec3d>(points(cell), finer.points(number));
        }
        return number;
    }

  private:
    struct Cell {
        const detail::CellNorms* norms;
        std::size_t begin;  ///< of the points
        double remainder = -1;
        std::array<int, 4> child{-1, -1, -1, -1};
    };
    std::vector<Cell> cells_;
    std::vector<Vec3d> points_;
};

/// The mesh of one level, or a part of it.
template <class Family>
struct MaskNormBound<Family>::Level {
    RuleStep made;  ///< its mesh, and how the level above has become it
    std::vector<Vec3d> net;
    detail::NormedCells cells;

    /// @param depth  steps from the control mesh; quads: the first one makes the cells
    Level(const detail::CellNormTable& norms, std::size_t depth, RuleStep step, std::vector<Vec3d> points)
        : made(std::move(step)),
          net(std::move(points)),
          cells(norms, made.mesh, static_cast<int>(depth) - (norms.corners() == 4 ? 1 : 0)) {}
    Level(const detail::CellNormTable& norms, std::size_t depth, RuleStep step, std::span<const Vec3d> above)
        : Level(norms, depth, std::move(step), std::vector<Vec3d>()) {
        net.resize(static_cast<std::size_t>(made.stencils.row_count()));
        made.stencils.template apply<Vec3d>(above, net);
        made.stencils = {};
    }
    Level(const Level&) = delete;
};

/// The meshes that lead walkers down until they are in known cells: whole levels, where there are any, then parts.
template <class Family>
class MaskNormBound<Family>::MeshDescent {
  public:
    MeshDescent(const MaskNormBound& bound, detail::MeshPartFinder& parts)
        : bound_(bound), here_(bound.whole_.front().get()), parts_(parts) {}

    /// Moves walkers from the mesh to known cells, where there are norms.
    void leave(std::span<Walker> walkers, KnownCells& known) {
        std::unordered_map<int, int> number;  // among the known cells, by face
        for (Walker& w : walkers) {
            if (!in_mesh(w)) continue;
            int h = first_corner(w);
            const detail::NormedCells::Cell& cell = here_->cells.at(h, parts_);
            if (cell.norms == nullptr) continue;
            const auto [of, is_new] = number.try_emplace(mesh().face(h), Walker::k_no);
            if (is_new) {
                of->second = known.add(*cell.norms);
                std::ranges::transform(cell.points, known.points(of->second).begin(),
                                       [&](int v) { return here_->net[static_cast<std::size_t>(v)]; });
            }
            w.known = of->second;
            for (; h != cell.first; h = mesh().next(h))
                for (CellPlace& p : w.at) p = from_next_corner(p, bound_.norms_.corners());
        }
    }
    std::array<Vec3d, 4> corners(const Walker& w) const {
        std::array<Vec3d, 4> corner{};
        int h = first_corner(w);
        for (int k = 0; k < bound_.norms_.corners(); ++k, h = mesh().next(h)) corner[k] = here_->net[mesh().origin(h)];
        return corner;
    }
    /// Makes the next level around the walkers that are in the mesh; their frames are those of the level above still.
    void go_down(std::span<Walker> walkers) {
        if (std::ranges::none_of(walkers, in_mesh)) return;
        above_ = &mesh();
        if (++depth_ < bound_.whole_.size()) {
            here_ = bound_.whole_[depth_].get();
            return;
        }
        // A level's rings give twice as many on the next one, less the two that rules reach.
        const int rings = std::max(bound_.norms_.rings() + 1, 4);
        std::vector<int> seeds;
        for (const Walker& w : walkers)
            if (in_mesh(w))
                for (const int v : mesh().corners(mesh().face(w.frame.halfedge))) seeds.push_back(v);
        part_ = parts_.find(mesh(), seeds, rings);
        for (Walker& w : walkers)
            if (in_mesh(w)) w.frame.halfedge = part_.halfedge(mesh(), w.frame.halfedge);
        std::vector<Vec3d> net;
        for (const int v : part_.vertex) net.push_back(here_->net[static_cast<std::size_t>(v)]);
        own_ = std::make_unique<Level>(bound_.norms_, depth_, bound_.step(depth_)(part_.mesh, bound_.rules_),
                                       std::span<const Vec3d>(net));
        here_ = own_.get();
        above_ = &part_.mesh;
    }
    /// The corner cell of a half-edge, after the first step of quads.
    detail::CellFrame child(const Walker& w) const { return {here_->made.child_halfedge[w.frame.halfedge], 0}; }
    detail::CellFrame child(const Walker& w, int child) const {
        return bound_.norms_.corners() == 3 ? detail::triangle_child(*above_, here_->made, w.frame, child)
                                            : detail::quad_child(*above_, here_->made, w.frame, child);
    }

  private:
    static bool in_mesh(const Walker& w) { return w.known == Walker::k_no; }
    const RuleMesh& mesh() const { return here_->made.mesh; }
    int first_corner(const Walker& w) const { return detail::face_corner(mesh(), w.frame, 0, bound_.norms_.corners()); }

    const MaskNormBound& bound_;
    const Level* here_;
    std::size_t depth_ = 0;            ///< steps from the control mesh
    const RuleMesh* above_ = nullptr;  ///< what the last step was made of
    detail::MeshPart part_;
    std::unique_ptr<const Level> own_;
    detail::MeshPartFinder& parts_;
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
    rules_.runner = nullptr;  // a thread must not take up another block amid one
    rounding_ = detail::surface_rounding(mesh_, averaging_steps(scheme, rules));
    aim_ = std::max(aim > 0 ? aim - rounding_ : k_no_error * mesh_.bounding_box().diagonal(), 0.0);
    RuleStep control;
    control.mesh = rule_mesh(mesh_, rules);
    first_step_ = first_rule_step(scheme, control.mesh);
    const std::span<const Vec3d> net = mesh_.positions();
    whole_.push_back(std::make_unique<Level>(norms_, 0, std::move(control), std::vector(net.begin(), net.end())));
    while (4 * whole_.back()->made.mesh.halfedge_count() <= k_most_halfedges) {
        const Level& above = *whole_.back();
        whole_.push_back(std::make_unique<Level>(norms_, whole_.size(), step(whole_.size())(above.made.mesh, rules_),
                                                 std::span<const Vec3d>(above.net)));
    }
}

template <class Family>
MaskNormBound<Family>::~MaskNormBound() = default;

template <class Family>
auto MaskNormBound<Family>::step(std::size_t depth) const -> Step {
    return norms_.corners() == 4 && depth == 1 ? first_step_ : scheme_.step;
}

template <class Family>
void MaskNormBound<Family>::add_pieces(const CellTriangle& t, const SlidTriangle& triangle,
                                       std::vector<Piece>& pieces) const {
    const double unit = std::ldexp(1.0, -t.level);
    Piece piece{t.root, t.level, {}, triangle};
    double right = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        piece.at[k] = {t.corner[k].x * unit, t.corner[k].y * unit};
        right = std::max(right, piece.at[k][0]);
    }
    pieces.push_back(piece);
    if (norms_.corners() == 3 || right <= 1) return;
    // The other half lies in the next corner's cell.
    piece.cell = mesh_.next(t.root);
    for (CellPlace& p : piece.at) p = {p[1], 2 - p[0]};
    pieces.push_back(piece);
}

template <class Family>
auto MaskNormBound<Family>::wanted(std::optional<double> known) const -> Wanted {
    return known ? Wanted{std::max(aim_, *known - rounding_), false} : Wanted{aim_, decides_};
}

template <class Family>
void MaskNormBound<Family>::bound_pieces(std::span<const Piece> pieces, std::span<const std::uint32_t> of,
                                         Wanted wanted, std::span<double> errors) const {
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
    const int n = norms_.corners();
    std::vector<Walker> walkers, next;
    for (std::uint32_t i = 0; i < pieces.size(); ++i)
        if (!covered(pieces[i].at, n).none)
            walkers.push_back({{static_cast<int>(pieces[i].cell.value), 0}, i, pieces[i].at});
    std::fill(errors.begin(), errors.end(), rounding_);
    std::vector<double> least(pieces.size(), 0.0);  // an error that there is
    std::vector<std::uint8_t> decided(pieces.size(), 0);
    std::vector<std::uint32_t> open(pieces.size());  // cells
    detail::MeshPartFinder parts;
    MeshDescent mesh(*this, parts);
    KnownCells known, finer;
    // Quads: one more step, from the control mesh to its corner cells.
    for (int level = n == 4 ? -1 : 0; !walkers.empty(); ++level) {
        if (level >= 0) mesh.leave(walkers, known);
        next.clear();
        for (const Walker& w : walkers) {
            const Piece& piece = pieces[w.piece];
            if (level < piece.level) {
                next.push_back(w);
                continue;
            }
            if (decided[w.piece] != 0) continue;
            const bool is_known = w.known != Walker::k_no;
            const double rest = is_known ? known.remainder(w.known) : k_infinite;
            const std::array<Vec3d, 4> corner = is_known ? known.corners(w.known) : mesh.corners(w);
            const Deviation off = deviation(covered(w.at, n), corner, n, piece.triangle);
            // Points of an interpolating scheme are limit points.
            const double apart = scheme_.interpolating && off.whole ? 0 : rest;
            least[w.piece] = std::max(least[w.piece], off.at_points - apart);
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
        mesh.go_down(next);
        walkers.clear();
        finer.clear();
        for (const Walker& w : next) {
            if (level < 0) {
                walkers.push_back({mesh.child(w), w.piece, w.at});
                continue;
            }
            for (int child = 0; child < 4; ++child) {
                PieceCorners at;
                for (std::size_t k = 0; k < 3; ++k) at[k] = in_child(w.at[k], child, n);
                if (covered(at, n).none) continue;
                if (w.known == Walker::k_no)
                    walkers.push_back({mesh.child(w, child), w.piece, at});
                else
                    walkers.push_back({{}, w.piece, at, known.child(w.known, child, finer)});
            }
        }
        std::swap(known, finer);
    }
    for (std::size_t i = 0; i < pieces.size(); ++i)
        if (decided[i] != 0) errors[i] = least[i] + rounding_;
}

template <class Family>
void MaskNormBound<Family>::bound(std::span<const CellTriangle> triangles, std::optional<double> known,
                                  std::span<double> errors) const {
    const auto count = static_cast<std::uint32_t>(triangles.size());
    // The corners and the middles of the sides.
    constexpr std::size_t k_points = 6;
    std::vector<Site> sites(k_points * triangles.size());
    for_each_index(count, [&](std::uint32_t t) {
        detail::put_lattice_sites<Family>(mesh_, triangles[t], 1, &sites[k_points * t]);
    });
    std::vector<Vec3d> points(sites.size());
    detail::limit_positions_once(points_, sites, points);
    std::vector<Piece> pieces;
    std::vector<std::uint32_t> of;
    for (std::uint32_t t = 0; t < count; ++t) {
        const Vec3d* const p = points.data() + k_points * t;
        add_pieces(triangles[t], SlidTriangle({p[3], p[5], p[0]}, {p[4], p[2], p[1]}), pieces);
        of.resize(pieces.size(), t);
    }
    std::fill(errors.begin(), errors.end(), 0.0);
    bound_pieces(pieces, of, wanted(known), errors);
}

template <class Family>
bool MaskNormBound<Family>::has_fan_bound(FaceId face) const {
    return mesh_.face_size(face) <= 4;
}

template <class Family>
void MaskNormBound<Family>::bound_fans(const FanChoice& fans, std::span<const FaceId> faces,
                                       std::span<const Vec3d> corners, std::optional<double> known,
                                       std::span<double> errors) const {
    // Each half of a corner's cell, cut from the corner to the centre, over a triangle that lies in the fan: from the
    // corner to the middle of an edge and to the middle of the fan, which is on the diagonal.
    std::vector<Piece> pieces;
    std::vector<std::uint32_t> of;
    for (std::uint32_t i = 0; i < faces.size(); ++i) {
        errors[i] = has_fan_bound(faces[i]) ? 0 : k_infinite;
        if (errors[i] > 0) continue;
        const std::uint32_t size = mesh_.face_size(faces[i]), h0 = mesh_.face_halfedge(faces[i]).value;
        const auto at = [&](std::uint32_t c) { return corners[mesh_.origin(HalfedgeId(h0 + c % size)).value]; };
        Vec3d centre = (at(0) + at(1) + at(2)) / 3.0;
        if (size == 4) {
            // The corner that is in one triangle alone lies beside the diagonal.
            const auto& one = fans.of(faces[i])[0];
            const std::uint32_t out_of_it = 6u - one[0] - one[1] - one[2];
            centre = 0.5 * (at(out_of_it + 1) + at(out_of_it + 3));
        }
        for (std::uint32_t c = 0; c < size; ++c) {
            const Vec3d ahead = 0.5 * (at(c) + at(c + 1)), behind = 0.5 * (at(c) + at(c + size - 1));
            pieces.push_back({HalfedgeId(h0 + c), 0, {{{0, 0}, {1, 0}, {1, 1}}}, SlidTriangle({at(c), ahead, centre})});
            pieces.push_back(
                {HalfedgeId(h0 + c), 0, {{{0, 0}, {1, 1}, {0, 1}}}, SlidTriangle({at(c), centre, behind})});
        }
        of.resize(pieces.size(), i);
    }
    bound_pieces(pieces, of, wanted(known), errors);
}

template class MaskNormBound<QuadFamily>;
template class MaskNormBound<LoopFamily>;

}  // namespace tetrakis
