#include "sqrt3_uvs.hpp"

#include "../../hier/base/parallel.hpp"
#include "../../refine/adaptive/sqrt3_points.hpp"
#include "../../refine/attributes/uv_mesh.hpp"

#include <algorithm>
#include <unordered_map>

namespace tetrakis::detail {

namespace {

constexpr std::uint32_t k_uv_block = 1024;       // leaves side by side that share what they find
constexpr std::uint32_t k_uv_leaves = 1u << 16;  // between two chances to cancel

bool is_linear(const ControlMesh& mesh) { return mesh.face_varying_rule() == FaceVaryingRule::linear_all; }

/// Values of vertices of the charts, in blocks of leaves side by side.
class ChartValues {
  public:
    ChartValues(const Sqrt3Lattice& lattice, bool linear) : points_(lattice), linear_(linear) {}

    Vec2d at(int level, std::uint64_t leaving) {
        const Sqrt3Vertex v = points_.lattice().origin(level, leaving);
        if (linear_) return linear(v);
        const auto [known, fresh] = known_.try_emplace(v);
        if (fresh) known->second = Vec2d(points_.limit(level, leaving).position);
        return known->second;
    }

  private:
    // All edges of the control mesh are kept: a face's triangles of every second level are a regular lattice in it.
    Vec2d linear(const Sqrt3Vertex& v) {
        Sqrt3Lattice& lattice = points_.lattice();
        if (v.kind == Sqrt3Vertex::Kind::control)
            return Vec2d(lattice.mesh().position(VertexId(static_cast<std::uint32_t>(v.key))));
        if (const auto known = known_.find(v); known != known_.end()) return known->second;
        const auto corner = [&](std::uint64_t h) { return linear(lattice.origin(v.birth - 1, h)); };
        Vec2d value(0);
        if (v.kind == Sqrt3Vertex::Kind::centre) {
            value = (corner(3 * v.key) + corner(3 * v.key + 1) + corner(3 * v.key + 2)) / 3.0;
        } else {
            const Vec2d a = corner(v.key), b = corner(Sqrt3Lattice::next(v.key));
            value = (v.kind == Sqrt3Vertex::Kind::first ? 2.0 * a + b : a + 2.0 * b) / 3.0;
        }
        return known_.emplace(v, value).first->second;
    }

    Sqrt3Points points_;
    bool linear_;
    std::unordered_map<Sqrt3Vertex, Vec2d> known_;
};

}  // namespace

std::function<bool(EdgeId)> sqrt3_seams(const ControlMesh& mesh, bool uvs) {
    const ControlMeshData& data = mesh.data();
    return [&mesh, &data, uvs = uvs && mesh.has_uvs()](EdgeId e) {
        const HalfedgeId h = mesh.edge_halfedge(e), t = mesh.twin(h);
        const auto differs = [](const std::vector<std::uint32_t>& of, auto a, auto b) {
            return !of.empty() && of[a.value] != of[b.value];
        };
        if (uvs &&
            (is_linear(mesh) || differs(data.face_uvs, h, mesh.next(t)) || differs(data.face_uvs, mesh.next(h), t)))
            return true;
        const FaceId here = mesh.face(h), there = mesh.face(t);
        return differs(data.face_material, here, there) || differs(data.face_group, here, there);
    };
}

Sqrt3Uvs::Sqrt3Uvs(const Sqrt3Lattice& lattice)
    : charts_(uv_mesh(lattice.mesh())),
      linear_(is_linear(lattice.mesh())),
      lattice_(charts_, [&](EdgeId e) { return lattice.is_kept(lattice.mesh().edge(charts_.edge_halfedge(e))); }) {}

std::vector<Vec2d> Sqrt3Uvs::corners(std::span<const Sqrt3Leaf> leaves, const RunContext& context) const {
    std::vector<Vec2d> result(3 * leaves.size());
    for (std::size_t begin = 0; begin < leaves.size(); begin += k_uv_leaves) {
        context.report("attributes", 0.5 * static_cast<double>(begin) / static_cast<double>(leaves.size()));
        const auto count = static_cast<std::uint32_t>(std::min<std::size_t>(k_uv_leaves, leaves.size() - begin));
        for_each_block(count, k_uv_block, [&](std::uint32_t from, std::uint32_t to) {
            ChartValues values(lattice_, linear_);
            for (std::size_t i = begin + from; i < begin + to; ++i)
                for (std::size_t k = 0; k < 3; ++k)
                    result[3 * i + k] = values.at(leaves[i].vertex_level[k], leaves[i].leaving[k]);
        });
    }
    return result;
}

}  // namespace tetrakis::detail
