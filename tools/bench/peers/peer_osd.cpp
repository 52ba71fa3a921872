#include "peer_osd.hpp"

#include "../../../tests/kit/osd_refiner.hpp"

#include <opensubdiv/bfr/refinerSurfaceFactory.h>
#include <opensubdiv/bfr/surface.h>
#include <opensubdiv/bfr/tessellation.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace tetrakis::bench {

namespace {

namespace Bfr = OpenSubdiv::Bfr;
namespace Far = OpenSubdiv::Far;
using Factory = Bfr::RefinerSurfaceFactory<>;
using Point = std::array<float, 3>;

Vec3f vec(const Point& p) { return {p[0], p[1], p[2]}; }

Vec3f unit_or_zero(const Vec3f& v) {
    const float length = glm::length(v);
    return length > 0 ? v / length : Vec3f(0.0f);
}

/// The control mesh, with its Bfr surfaces and the edges of each face.
class BfrSurfaces {
  public:
    BfrSurfaces(const ControlMeshData& data, const PeerOptions& options)
        : refiner_(test::osd_refiner(data, options.scheme, false)), factory_(*refiner_, bfr_options(options.levels)) {
        for (const Vec3d& p : data.positions)
            for (int axis = 0; axis < 3; ++axis) control_.push_back(static_cast<float>(p[axis]));
    }

    const Far::TopologyLevel& level() const { return level_; }

    /// Prepares the face's surface for evaluation. Returns false for holes.
    bool set_face(int face) {
        if (!factory_.InitVertexSurface(face, &surface_)) return false;
        patch_points_.resize(3 * static_cast<std::size_t>(surface_.GetNumPatchPoints()));
        surface_.PreparePatchPoints(control_.data(), 3, patch_points_.data(), 3);
        return true;
    }
    Bfr::Parameterization parameterization() const { return surface_.GetParameterization(); }

    void point_and_normal(const float* uv, Point& p, Point& n) const {
        Point du, dv;
        surface_.Evaluate(uv, patch_points_.data(), 3, p.data(), du.data(), dv.data());
        const Vec3f normal = unit_or_zero(glm::cross(vec(du), vec(dv)));
        n = {normal.x, normal.y, normal.z};
    }
    /// Whether side i of the face has the direction of its edge.
    bool along_edge(int face, int i) const {
        return level_.GetFaceVertices(face)[i] == level_.GetEdgeVertices(level_.GetFaceEdges(face)[i])[0];
    }

  private:
    std::unique_ptr<Far::TopologyRefiner> refiner_;
    Far::TopologyLevel level_ = refiner_->GetLevel(0);
    Factory factory_;
    std::vector<float> control_;
    Bfr::Surface<float> surface_;
    std::vector<float> patch_points_;
};

/// Rates of all edges, and one or two inner rates for each face (two for quads of Catmull-Clark).
struct Rates {
    std::vector<int> edge;
    std::vector<std::array<int, 2>> inner;
};

PeerMesh tessellate_rates(BfrSurfaces& surfaces, const Rates& rates) {
    const Far::TopologyLevel& level = surfaces.level();
    PeerMesh mesh;
    // Order of points: vertices, points on edges, points inside faces (face by face).
    std::vector<int> edge_offset(static_cast<std::size_t>(level.GetNumEdges()));
    int count = level.GetNumVertices();
    for (int e = 0; e < level.GetNumEdges(); ++e) {
        edge_offset[e] = count;
        count += rates.edge[e] - 1;
    }
    mesh.positions.resize(count);
    mesh.normals.resize(count);
    std::vector<char> vertex_done(level.GetNumVertices(), 0), edge_done(level.GetNumEdges(), 0);
    std::vector<int> boundary, facets;
    std::vector<float> coordinates;
    const auto facet_options = Bfr::Tessellation::Options().SetFacetSize(3);
    const auto evaluate = [&](const float* uv, int index) {
        surfaces.point_and_normal(uv, mesh.positions[index], mesh.normals[index]);
    };

    for (int f = 0; f < level.GetNumFaces(); ++f) {
        if (!surfaces.set_face(f)) continue;
        const auto vertices = level.GetFaceVertices(f), edges = level.GetFaceEdges(f);
        const int n = vertices.size();
        const auto parameterization = surfaces.parameterization();
        std::vector<int> face_rates;
        face_rates.reserve(n + 2);
        for (int i = 0; i < n; ++i) face_rates.push_back(rates.edge[edges[i]]);
        face_rates.push_back(rates.inner[f][0]);
        if (parameterization.GetType() == Bfr::Parameterization::QUAD) face_rates.push_back(rates.inner[f][1]);
        const Bfr::Tessellation tessellation(parameterization, static_cast<int>(face_rates.size()), face_rates.data(),
                                             facet_options);

        coordinates.resize(2 * static_cast<std::size_t>(tessellation.GetNumCoords()));
        tessellation.GetCoords(coordinates.data());
        boundary.clear();
        for (int i = 0; i < n; ++i) {
            const auto next = [&] { return &coordinates[2 * boundary.size()]; };
            if (!vertex_done[vertices[i]]) evaluate(next(), vertices[i]);
            vertex_done[vertices[i]] = 1;
            boundary.push_back(vertices[i]);
            const int inside = rates.edge[edges[i]] - 1, first = edge_offset[edges[i]];
            const bool forward = surfaces.along_edge(f, i), evaluated = edge_done[edges[i]];
            for (int j = 0; j < inside; ++j) {
                const int index = forward ? first + j : first + inside - 1 - j;
                if (!evaluated) evaluate(next(), index);
                boundary.push_back(index);
            }
            edge_done[edges[i]] = 1;
        }
        const int inner_offset = static_cast<int>(mesh.positions.size());
        const int inner_count = tessellation.GetNumInteriorCoords();
        mesh.positions.resize(inner_offset + inner_count);
        mesh.normals.resize(inner_offset + inner_count);
        for (int i = 0; i < inner_count; ++i) evaluate(&coordinates[2 * (boundary.size() + i)], inner_offset + i);

        facets.resize(3 * static_cast<std::size_t>(tessellation.GetNumFacets()));
        tessellation.GetFacets(facets.data());
        const auto in_mesh = [&](int corner) {
            const int inside = corner - static_cast<int>(boundary.size());
            return inside < 0 ? boundary[corner] : inner_offset + inside;
        };
        for (std::size_t t = 0; t < facets.size(); t += 3)
            mesh.triangles.push_back({in_mesh(facets[t]), in_mesh(facets[t + 1]), in_mesh(facets[t + 2])});
    }
    return mesh;
}

using PointAndNormal = std::pair<Vec3f, Vec3f>;

/// Normal component of a second difference.
float bend_at(const PointAndNormal& a, const PointAndNormal& b, const PointAndNormal& c) {
    return std::abs(glm::dot(a.first - 2.0f * b.first + c.first, b.second));
}

/// Limit points and normals on a 5 x 5 grid over a face or, for an n-gon, over the quarter at one corner.
struct Grid {
    std::array<std::array<PointAndNormal, 5>, 5> at;
    bool triangle = false;
    /// Largest second differences along u, v and, for triangles, the third direction.
    std::array<float, 2> bend() const {
        std::array<float, 2> largest{};
        for (int j = 0; j < 5; ++j) {
            const int length = triangle ? 5 - j : 5;
            for (int i = 1; i + 1 < length; ++i) {
                largest[0] = std::max(largest[0], bend_at(at[j][i - 1], at[j][i], at[j][i + 1]));
                largest[1] = std::max(largest[1], bend_at(at[i - 1][j], at[i][j], at[i + 1][j]));
            }
        }
        if (triangle) {
            for (int s = 2; s < 5; ++s)
                for (int i = 1; i < s; ++i)
                    largest[0] =
                        std::max(largest[0], bend_at(at[s - i + 1][i - 1], at[s - i][i], at[s - i - 1][i + 1]));
            largest[0] = largest[1] = std::max(largest[0], largest[1]);
        }
        return largest;
    }
};

Rates estimated_rates(BfrSurfaces& surfaces, double tolerance, double k) {
    const Far::TopologyLevel& level = surfaces.level();
    std::vector<float> edge_bend(level.GetNumEdges(), 0.0f);
    std::vector<std::array<float, 2>> inner_bend(level.GetNumFaces());
    const auto sample = [&](const float* uv) {
        Point p, n;
        surfaces.point_and_normal(uv, p, n);
        return std::pair{vec(p), vec(n)};
    };
    for (int f = 0; f < level.GetNumFaces(); ++f) {
        if (!surfaces.set_face(f)) continue;
        const auto edges = level.GetFaceEdges(f);
        const auto parameterization = surfaces.parameterization();
        const bool triangle = parameterization.GetType() == Bfr::Parameterization::TRI;
        for (int i = 0; i < edges.size(); ++i) {
            std::array<PointAndNormal, 5> line;
            for (int j = 0; j < 5; ++j) {
                float uv[2];
                parameterization.GetEdgeCoord(i, 0.25f * static_cast<float>(j), uv);
                line[j] = sample(uv);
            }
            float& bend = edge_bend[edges[i]];
            for (int j = 1; j < 4; ++j) bend = std::max(bend, bend_at(line[j - 1], line[j], line[j + 1]));
        }
        const bool split = parameterization.HasSubFaces();
        for (int sub = 0; sub < (split ? edges.size() : 1); ++sub) {
            Grid grid;
            grid.triangle = triangle;
            for (int j = 0; j < 5; ++j)
                for (int i = 0; i < (triangle ? 5 - j : 5); ++i) {
                    const float local[2] = {0.25f * static_cast<float>(i), 0.25f * static_cast<float>(j)};
                    float uv[2] = {local[0], local[1]};
                    if (split) parameterization.ConvertNormalizedSubFaceToCoord(sub, local, uv);
                    grid.at[j][i] = sample(uv);
                }
            auto bend = grid.bend();
            // An n-gon's inner rate is for whole edges, but its quarters have half the length: twice the rate, so four
            // times d.
            if (split) bend[0] = bend[1] = 4 * std::max(bend[0], bend[1]);
            for (int d = 0; d < 2; ++d) inner_bend[f][d] = std::max(inner_bend[f][d], bend[d]);
        }
    }
    const auto rate = [&](float bend) {
        return std::max(1, static_cast<int>(std::ceil(k * std::sqrt(2 * bend / tolerance))));
    };
    Rates rates;
    for (const float bend : edge_bend) rates.edge.push_back(rate(bend));
    for (const auto& bend : inner_bend) rates.inner.push_back({rate(bend[0]), rate(bend[1])});
    return rates;
}

}  // namespace

PeerMesh bfr_uniform(const ControlMeshData& data, const PeerOptions& options, int rate) {
    BfrSurfaces surfaces(data, options);
    Rates rates;
    rates.edge.assign(surfaces.level().GetNumEdges(), rate);
    rates.inner.assign(surfaces.level().GetNumFaces(), {rate, rate});
    return tessellate_rates(surfaces, rates);
}

PeerMesh bfr_adaptive(const ControlMeshData& data, const PeerOptions& options, double tolerance, double k) {
    BfrSurfaces surfaces(data, options);
    return tessellate_rates(surfaces, estimated_rates(surfaces, tolerance, k));
}

}  // namespace tetrakis::bench
