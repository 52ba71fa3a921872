#include "shading_normals.hpp"

#include "../../hier/base/disjoint_sets.hpp"
#include "../../hier/base/parallel.hpp"

#include <oneapi/tbb/parallel_sort.h>
#include <glm/trigonometric.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

namespace tetrakis::detail {

namespace {

constexpr std::uint32_t k_none = 0xFFFF'FFFFu;

/// If the normals of all sides are within this angle of the vertex normal, it alone is used: no difference is visible.
constexpr double k_one_plane_degrees = 1;

std::uint32_t vertex_of(const TriangleMesh& mesh, std::uint64_t corner) {
    return mesh.triangles[corner / 3][corner % 3];
}

double corner_angle(const TriangleMesh& mesh, std::uint64_t corner) {
    const auto& triangle = mesh.triangles[corner / 3];
    const std::uint64_t k = corner % 3;
    const Vec3d p = mesh.positions[triangle[k]];
    const Vec3d a = mesh.positions[triangle[(k + 1) % 3]] - p, b = mesh.positions[triangle[(k + 2) % 3]] - p;
    return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

/// Whether the angle between a unit normal and a triangle's normal `area`, of any length, has at least this cosine. A
/// triangle without area agrees with every normal.
bool agrees(const Vec3d& normal, const Vec3d& area, double least_cosine) {
    return glm::dot(normal, area) >= least_cosine * glm::length(area);
}

Vec3d area_vector(const TriangleMesh& mesh, std::size_t t) {
    const auto& [a, b, c] = mesh.triangles[t];
    return glm::cross(mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]);
}

/// The triangles around a vertex, one for each corner at it.
struct VertexFaces {
    std::vector<Vec3d> normals;  ///< unit normals
    std::vector<double> angles;  ///< at the vertex

    VertexFaces(const TriangleMesh& mesh, std::span<const std::uint64_t> corners)
        : normals(corners.size()), angles(corners.size()) {
        for (std::size_t i = 0; i < corners.size(); ++i) {
            normals[i] = face_normal(mesh, corners[i] / 3);
            angles[i] = corner_angle(mesh, corners[i]);
        }
    }
    /// The normal of corner i. The triangles of its group that are within the crease angle of triangle i count. If all
    /// of them agree with `normal`, the result is `normal`; else their mean, weighted by their angles at the vertex. So
    /// of triangles that look like one face, all keep `normal` or none does.
    /// @param group  per corner: its group
    Vec3d agreed(const Vec3d& normal, std::size_t i, std::span<const std::uint32_t> group, double least_cosine) const {
        Vec3d sum(0);
        bool agreed = agrees(normal, normals[i], least_cosine);
        for (std::size_t j = 0; j < normals.size(); ++j) {
            if (group[j] != group[i] || glm::dot(normals[j], normals[i]) < least_cosine) continue;
            sum += angles[j] * normals[j];
            agreed = agreed && agrees(normal, normals[j], least_cosine);
        }
        if (agreed) return normal;
        const double length = glm::length(sum);
        return length > 0 ? sum / length : normals[i];
    }
};

class NormalSplitter {
  public:
    NormalSplitter(TriangleMesh& mesh, std::span<const std::uint32_t> triangle_face, const ControlMesh* control,
                   double crease_degrees)
        : mesh_(mesh), face_(triangle_face), least_cosine_(std::cos(glm::radians(crease_degrees))) {
        for (std::uint32_t h = 0; control != nullptr && h < control->halfedge_count(); ++h) {
            const HalfedgeId t = control->twin(HalfedgeId(h));
            if (!t.valid() || control->sharpness(control->edge(t)) != k_sharpness_infinity) continue;
            const FaceId face = control->face(HalfedgeId(h)), other = control->face(t);
            if (face != other && !control->is_hole(face) && !control->is_hole(other))
                divided_.emplace_back(face.value, other.value);
        }
        std::ranges::sort(divided_);
    }

    void run(const SideNormals& side) {
        const std::vector<std::uint8_t> chosen = vertices_to_look_at();
        for (std::uint64_t c = 0; c < 3 * std::uint64_t{mesh_.triangles.size()}; ++c)
            if (chosen[vertex_of(mesh_, c)] != 0) corners_.push_back(c);
        const auto place = [&](std::uint64_t c) { return std::pair(vertex_of(mesh_, c), c); };
        oneapi::tbb::parallel_sort(corners_, [&](std::uint64_t c, std::uint64_t d) { return place(c) < place(d); });
        for (std::uint64_t i = 0; i < corners_.size(); ++i)
            if (i == 0 || vertex_of(mesh_, corners_[i]) != vertex_of(mesh_, corners_[i - 1])) first_.push_back(i);
        const auto count = static_cast<std::uint32_t>(first_.size());
        first_.push_back(corners_.size());
        group_.resize(corners_.size());
        std::vector<std::uint32_t> groups(count);
        for_each_index(count, [&](std::uint32_t i) { groups[i] = find_groups(of(i, corners_), of(i, group_)); });
        // `side` is called with the first corner of each group.
        std::vector<std::uint64_t> asked;
        std::vector<std::uint64_t> first_asked(count + 1, 0);
        for (std::uint32_t i = 0; i < count; ++i) {
            for (std::uint64_t c = first_[i]; groups[i] > 1 && c < first_[i + 1]; ++c)
                if (group_[c] == asked.size() - first_asked[i]) asked.push_back(corners_[c]);
            first_asked[i + 1] = asked.size();
        }
        std::vector<Vec3d> sides(asked.size(), Vec3d(0));
        if (side) side(asked, sides);
        normals_.resize(corners_.size());
        for_each_index(count, [&](std::uint32_t i) {
            choose_normals(of(i, corners_), of(i, group_), groups[i], std::span(sides).subspan(first_asked[i]), chosen,
                           of(i, normals_));
        });
        number_normals();
    }

  private:
    /// The values at chosen vertex i.
    template <class Value>
    std::span<Value> of(std::uint32_t i, std::vector<Value>& values) const {
        return std::span(values).subspan(first_[i], first_[i + 1] - first_[i]);
    }

    bool is_beside_sharp(std::uint32_t face) const {
        const auto from = std::ranges::lower_bound(divided_, std::pair(face, 0u));
        return from != divided_.end() && from->first == face;
    }

    /// Per vertex: 1 if its normal does not agree with all its triangles, or if it may be on a crease.
    std::vector<std::uint8_t> vertices_to_look_at() const {
        const auto count = static_cast<std::uint32_t>(mesh_.triangles.size());
        std::vector<std::uint8_t> chosen(mesh_.positions.size(), 0);
        for (std::uint32_t t = 0; t < count; ++t) {
            const Vec3d area = area_vector(mesh_, t);
            for (const std::uint32_t v : mesh_.triangles[t])
                if (!agrees(mesh_.normals[v], area, least_cosine_)) chosen[v] = 1;
        }
        if (divided_.empty()) return chosen;
        std::vector<std::uint32_t> seen(mesh_.positions.size(), k_none);  // a control face around each vertex
        for (std::uint32_t t = 0; t < count; ++t)
            if (is_beside_sharp(face_[t]))
                for (const std::uint32_t v : mesh_.triangles[t]) {
                    if (seen[v] != k_none && seen[v] != face_[t]) chosen[v] = 1;
                    seen[v] = face_[t];
                }
        return chosen;
    }

    std::uint32_t end(std::uint64_t corner, std::uint64_t turn) const {
        return mesh_.triangles[corner / 3][(corner % 3 + turn) % 3];
    }

    /// Numbers the groups of a vertex's corners by their first corners: sharp edges divide the groups. Returns the
    /// number of groups.
    std::uint32_t find_groups(std::span<const std::uint64_t> corners, std::span<std::uint32_t> group) const {
        const auto count = static_cast<std::uint32_t>(corners.size());
        if (divided_.empty()) {
            std::fill_n(group.begin(), count, 0u);
            return 1;
        }
        DisjointSets sets(count);
        for (std::uint32_t i = 0; i < count; ++i)
            for (std::uint32_t j = 0; j < count; ++j)
                if (end(corners[i], 2) == end(corners[j], 1) &&
                    !std::ranges::binary_search(divided_, std::pair(face_[corners[i] / 3], face_[corners[j] / 3])))
                    sets.unite(i, j);
        std::uint32_t groups = 0;
        for (std::uint32_t i = 0; i < count; ++i) group[i] = sets.find(i) == i ? groups++ : group[sets.find(i)];
        return groups;
    }

    /// Estimates a corner's normal from smooth vertices at the other ends of its two edges: on a circular arc the
    /// normals at both ends of a chord are mirror images.
    Vec3d from_neighbours(std::uint64_t corner, std::span<const std::uint8_t> chosen) const {
        const Vec3d area = area_vector(mesh_, corner / 3);
        Vec3d sum(0);
        for (const std::uint64_t turn : {1u, 2u}) {
            const std::uint32_t w = end(corner, turn);
            if (chosen[w] != 0) continue;
            const Vec3d chord = unit_or_zero(mesh_.positions[w] - mesh_.positions[vertex_of(mesh_, corner)]);
            const Vec3d mirrored = mesh_.normals[w] - 2 * glm::dot(mesh_.normals[w], chord) * chord;
            if (agrees(mirrored, area, least_cosine_)) sum += mirrored;
        }
        const double length = glm::length(sum);
        return length > 0 ? sum / length : face_normal(mesh_, corner / 3);
    }

    /// @param sides    limit normal of each group, if there are several groups; zero: not known
    /// @param normals  receives the normals of the corners
    void choose_normals(std::span<const std::uint64_t> corners, std::span<const std::uint32_t> group,
                        std::uint32_t groups, std::span<const Vec3d> sides, std::span<const std::uint8_t> chosen,
                        std::span<Vec3d> normals) const {
        const Vec3d own = mesh_.normals[vertex_of(mesh_, corners[0])];
        const VertexFaces faces(mesh_, corners);
        std::vector<Vec3d> of_group(groups, own);
        if (groups > 1) {
            std::copy_n(sides.begin(), groups, of_group.begin());
            for (std::size_t i = 0; i < corners.size(); ++i)
                if (sides[group[i]] == Vec3d(0))
                    of_group[group[i]] += faces.angles[i] * from_neighbours(corners[i], chosen);
            for (Vec3d& normal : of_group) normal = unit_or_zero(normal);
            const double one_plane = std::cos(glm::radians(k_one_plane_degrees));
            if (std::all_of(of_group.begin(), of_group.end(),
                            [&](const Vec3d& normal) { return glm::dot(normal, own) >= one_plane; }))
                std::fill(of_group.begin(), of_group.end(), own);
        }
        for (std::size_t i = 0; i < corners.size(); ++i)
            normals[i] = faces.agreed(of_group[group[i]], i, group, least_cosine_);
    }

    /// Stores the normals: the first corner's replaces the vertex normal; other ones are appended to mesh_.normals.
    void number_normals() {
        const std::size_t vertex_count = mesh_.normals.size();
        std::vector<std::array<std::uint32_t, 3>> numbers = mesh_.triangles;
        for (std::size_t i = 0; i + 1 < first_.size(); ++i) {
            const std::uint32_t v = vertex_of(mesh_, corners_[first_[i]]);
            const auto first_extra = static_cast<std::ptrdiff_t>(mesh_.normals.size());
            mesh_.normals[v] = normals_[first_[i]];
            for (std::uint64_t c = first_[i]; c < first_[i + 1]; ++c) {
                std::size_t number = v;
                if (normals_[c] != mesh_.normals[v])
                    number = static_cast<std::size_t>(
                        std::find(mesh_.normals.begin() + first_extra, mesh_.normals.end(), normals_[c]) -
                        mesh_.normals.begin());
                if (number == mesh_.normals.size()) mesh_.normals.push_back(normals_[c]);
                numbers[corners_[c] / 3][corners_[c] % 3] = static_cast<std::uint32_t>(number);
            }
        }
        if (mesh_.normals.size() > vertex_count) mesh_.triangle_normals = std::move(numbers);
    }

    TriangleMesh& mesh_;
    std::span<const std::uint32_t> face_;
    double least_cosine_;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> divided_;  ///< control faces with a sharp edge between, sorted
    std::vector<std::uint64_t> corners_;                            ///< at chosen vertices, vertex by vertex
    std::vector<std::uint64_t> first_;  ///< per chosen vertex: the place of its first corner in corners_
    std::vector<std::uint32_t> group_;  ///< per corner in corners_: its group at the vertex
    std::vector<Vec3d> normals_;        ///< per corner in corners_
};

}  // namespace

void geometric_normals(TriangleMesh& mesh) {
    mesh.normals.assign(mesh.positions.size(), Vec3d(0));
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const Vec3d area = area_vector(mesh, t);
        for (const std::uint32_t v : mesh.triangles[t]) mesh.normals[v] += area;
    }
    for (Vec3d& n : mesh.normals) n = unit_or_zero(n);
}

Vec3d face_normal(const TriangleMesh& mesh, std::size_t t) {
    const auto& [a, b, c] = mesh.triangles[t];
    // Scaled first, so that squares of tiny or huge sides stay in range.
    const Vec3d ab = mesh.positions[b] - mesh.positions[a], ac = mesh.positions[c] - mesh.positions[a];
    const double l = glm::length(ab), m = glm::length(ac);
    if (!(l > 0) || !(m > 0)) return Vec3d(0);
    return unit_or_zero(glm::cross(ab / l, ac / m));
}

void split_normals(TriangleMesh& mesh, std::span<const std::uint32_t> triangle_face, const ControlMesh* control,
                   double crease_degrees, const SideNormals& side) {
    NormalSplitter(mesh, triangle_face, control, crease_degrees).run(side);
}

std::vector<std::array<Vec3f, 3>> corner_normals(TriangleMesh mesh, double crease_degrees) {
    if (mesh.triangle_normals.empty()) {
        mesh.normals.resize(mesh.positions.size(), Vec3d(0));
        split_normals(mesh, {}, nullptr, crease_degrees);
    }
    const auto& corners = mesh.triangle_normals.empty() ? mesh.triangles : mesh.triangle_normals;
    std::vector<std::array<Vec3f, 3>> result(corners.size());
    for (std::size_t t = 0; t < result.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) result[t][k] = Vec3f(mesh.normals[corners[t][k]]);
    return result;
}

}  // namespace tetrakis::detail
