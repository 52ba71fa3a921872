#include "dual_bound.hpp"

#include "../../hier/base/parallel.hpp"
#include "dual_close_bound.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

namespace tetrakis::detail {

namespace {

constexpr std::uint32_t k_faces = 32;
// Levels below the leaves around a point that are looked at first, where these are alike, and then if that does not
// decide: what is left at the point is an eighth as wide, and hardly adds to what the rest is off.
constexpr int k_first_look = 1, k_close_look = 3;
// Limit points and polynomials are sums of a few products.
constexpr double k_errors_of_sums = 256;

bool is_midedge(const SchemeInfo& scheme) { return scheme.name == "midedge" || scheme.name == "midedge-simplest"; }

/// The errors of all faces.
class FaceErrors {
  public:
    FaceErrors(const DualSurface& surface, const VertexForest& forest, const DualNet& net,
               std::span<const Vec3d> positions, double rounding)
        : surface_(surface),
          forest_(forest),
          net_(net),
          positions_(positions),
          rounding_(rounding),
          of_corner_(net.faces.corners.size()),
          of_face_(net.size(), 0.0),
          plane_(net.size(), 0) {}

    double error(std::uint32_t face) const { return of_face_[face]; }
    /// By what is known over each face alone.
    void look_at(std::span<const std::uint32_t> which) {
        for_each(which, [&](std::uint32_t f, const DualFacePieces& pieces, std::span<double> here) {
            bound_dual_face(surface_, pieces, f >= net_.face_count, here);
            for (double& e : here) e += e > 0 ? rounding_ : 0;
            plane_[f] = pieces.plane() ? 1 : 0;
        });
    }
    /// By their neighbours as well, after that.
    void look_around(std::span<const std::uint32_t> which, double give_up_at) {
        if (which.empty()) return;
        const DualLinks links(net_, plane_);
        const DualCloseBound bound(surface_, forest_, net_, links, positions_);
        for_each(which, [&](std::uint32_t f, const DualFacePieces& pieces, std::span<double> here) {
            if (f >= net_.face_count || !(of_face_[f] < std::numeric_limits<double>::infinity())) return;
            const double error = bound(f, pieces, give_up_at) + rounding_;
            for (double& e : here) e = std::min(e, error);
        });
    }
    DualBound::Errors gather(const DualTriangles& mesh) const {
        DualBound::Errors errors;
        errors.of_vertex.assign(mesh.vertex_count(), 0.0);
        for (std::size_t i = 0; i < of_corner_.size(); ++i) {
            double& most = errors.of_vertex[net_.faces.face_vertices[i]];
            most = std::max(most, of_corner_[i]);
        }
        errors.of_triangle.reserve(mesh.triangle_count());
        for (std::size_t f = 0; f < net_.size(); ++f) {
            errors.largest = std::max(errors.largest, of_face_[f]);
            const std::uint32_t size = net_.faces.face_offsets[f + 1] - net_.faces.face_offsets[f];
            if (f < net_.face_count) errors.of_triangle.insert(errors.of_triangle.end(), size - 2, of_face_[f]);
        }
        return errors;
    }

  private:
    template <class Look>
    void for_each(std::span<const std::uint32_t> which, Look&& look) {
        for_each_index(
            static_cast<std::uint32_t>(which.size()),
            [&](std::uint32_t i) {
                const std::uint32_t f = which[i], begin = net_.faces.face_offsets[f];
                const auto here =
                    std::span(of_corner_).subspan(begin, net_.faces.face_offsets[f + std::size_t{1}] - begin);
                look(f, DualFacePieces(surface_, forest_, net_, positions_, f), here);
                of_face_[f] = *std::max_element(here.begin(), here.end());
            },
            k_faces);
    }

    const DualSurface& surface_;
    const VertexForest& forest_;
    const DualNet& net_;
    std::span<const Vec3d> positions_;
    double rounding_;
    std::vector<double> of_corner_, of_face_;
    std::vector<std::uint8_t> plane_;
};

}  // namespace

bool DualBound::has(const SchemeInfo& scheme) {
    return scheme.name == "doo-sabin" || scheme.name == "doo-sabin-cc" || is_midedge(scheme);
}

DualBound::DualBound(const PartialLevels& points, const SchemeInfo& scheme, const VertexRoots& roots, const Box3d& box)
    : surface_(points, roots, is_midedge(scheme) ? DualPieces::four : DualPieces::biquadratic),
      rounding_(k_errors_of_sums * std::numeric_limits<double>::epsilon() *
                std::max(glm::length(box.lower), glm::length(box.upper))) {}

void DualBound::find_points(const VertexForest& forest, const DualFaces& faces, std::span<const std::uint8_t> wanted,
                            int deeper, const std::function<void(double)>& report) {
    const DualCorners& corners = surface_.corners();
    struct Levels {
        int least = k_max_level, most = -1;
    };
    std::vector<Levels> levels(corners.points().size());
    const auto look = [&](LeafId leaf) {
        const VertexCell cell = forest.cell(leaf);
        if (corners.corner_of(cell) < 0) return;
        for (int c = 0; c < 4; ++c) {
            if (cell.level > 0 && c != corners.corner_of(cell)) continue;
            const std::uint32_t point = corners.point(cell.root, c);
            if (point == DualCorners::none) continue;
            levels[point].least = std::min<int>(levels[point].least, cell.level);
            levels[point].most = std::max<int>(levels[point].most, cell.level);
        }
    };
    for (const LeafId leaf : faces.leaves) look(leaf);
    for (const DualFaces::OtherSide& side : faces.other_sides) look(side.leaf);
    std::vector<DualSurface::Need> needs;
    for (std::uint32_t p = 0; p < levels.size(); ++p)
        if (wanted[p] != 0 && levels[p].most >= 0 && levels[p].most <= DualSurface::k_deepest_leaf)
            needs.push_back({p, levels[p].least + 1,
                             std::min(levels[p].most + deeper, DualSurface::k_deepest_leaf + k_first_look)});
    surface_.find(needs, report);
}

bool DualBound::add_points(const VertexForest& forest, const DualNet& net, std::uint32_t face,
                           std::vector<std::uint8_t>& wanted) const {
    bool any = false;
    for (std::uint32_t i = net.faces.face_offsets[face]; i < net.faces.face_offsets[face + std::size_t{1}]; ++i) {
        const VertexCell cell = forest.cell(net.faces.corners[i].leaf);
        const int corner = surface_.corners().corner_of(cell);
        if (corner < 0) continue;
        any = true;
        for (int c = 0; c < 4; ++c)
            if (const std::uint32_t p = surface_.corners().point(cell.root, c);
                p != DualCorners::none && (cell.level == 0 || c == corner))
                wanted[p] = 1;
    }
    return any;
}

DualBound::Errors DualBound::errors(const VertexForest& forest, const DualTriangles& mesh,
                                    std::span<const Vec3d> positions, const Wanted& wanted,
                                    const std::function<void(double)>& report) {
    const DualNet net = dual_net(forest, surface_.corners());
    std::vector<LeafId> leaves = net.faces.leaves;
    for (const DualFaces::OtherSide& side : net.faces.other_sides) leaves.push_back(side.leaf);
    surface_.find(forest, leaves, [&](double done) { report(0.5 * done); });
    std::vector<std::uint8_t> points(surface_.corners().points().size(), 1);
    find_points(forest, net.faces, points, k_first_look, [&](double done) { report(0.5 + 0.1 * done); });

    FaceErrors faces(surface_, forest, net, positions, rounding_);
    std::vector<std::uint32_t> open(net.size());
    std::iota(open.begin(), open.end(), 0u);
    faces.look_at(open);
    report(0.7);
    std::erase_if(open, [&](std::uint32_t f) { return faces.error(f) <= wanted.decide_at; });
    std::fill(points.begin(), points.end(), std::uint8_t{0});
    std::vector<std::uint32_t> beside_points;
    for (const std::uint32_t f : open)
        if (add_points(forest, net, f, points)) beside_points.push_back(f);
    find_points(forest, net.faces, points, k_close_look, [&](double done) { report(0.7 + 0.1 * done); });
    faces.look_at(beside_points);
    report(0.8);
    std::erase_if(open, [&](std::uint32_t f) { return faces.error(f) <= wanted.decide_at; });
    faces.look_around(open, wanted.tight ? std::numeric_limits<double>::infinity() : wanted.decide_at);
    return faces.gather(mesh);
}

}  // namespace tetrakis::detail
