#include "mesh_split.hpp"

#include "../base/disjoint_sets.hpp"
#include "../base/ids.hpp"
#include "mesh_links.hpp"

#include <algorithm>
#include <numeric>
#include <set>

namespace tetrakis::detail {

namespace {

constexpr std::uint32_t k_none = HalfedgeId::none;

class Splitter {
  public:
    explicit Splitter(ControlMeshData& data) : data_(data) {
        const std::vector<EdgeUse> uses = sorted_edge_uses(data);
        for (std::size_t i = 0, end = 0; i < uses.size(); i = end) {
            for (end = i + 1; end < uses.size() && uses[end].same_edge(uses[i]);) ++end;
            if (end - i > 2 && result_.non_manifold_edges++ == 0) result_.first_edge = {uses[i].low, uses[i].high};
        }
        cut_.assign(data.face_vertices.size(), 0);
        result_.origin.resize(data.positions.size());
        std::iota(result_.origin.begin(), result_.origin.end(), 0u);
    }

    // Each round that changes something cuts at least one more edge or makes at least one more vertex. No corner can be
    // cut off twice, so the rounds end.
    ManifoldSplit run() {
        for (;;) {
            pair_edges();
            const bool vertices_split = split_vertices();
            if (vertices_split) pair_edges();
            const bool faces_cut = orient();
            if (!vertices_split && !faces_cut) break;
        }
        const std::set<std::uint32_t> split(result_.origin.begin() + vertices_before_, result_.origin.end());
        result_.split_vertices = split.size();
        if (!split.empty()) result_.first_vertex = *split.begin();
        return std::move(result_);
    }

  private:
    std::uint32_t next(std::uint32_t h) const { return next_corner(data_, links_.face[h], h); }
    std::uint32_t prev(std::uint32_t h) const { return prev_corner(data_, links_.face[h], h); }

    void pair_edges() {
        links_ = link_mesh(data_, sorted_edge_uses(data_));
        std::vector<std::uint32_t>& twin = links_.twin;
        for (std::uint32_t h = 0; h < twin.size(); ++h)
            if (cut_[h] && twin[h] != k_none) twin[h] = twin[twin[h]] = k_none;
    }

    // Gives every fan of corners its own vertex; the fan with the lowest corner keeps the old number.
    bool split_vertices() {
        const auto corners = static_cast<std::uint32_t>(data_.face_vertices.size());
        DisjointSets fans(corners);
        for (std::uint32_t h = 0; h < corners; ++h) {
            const std::uint32_t t = links_.twin[h];
            if (t == k_none || t < h) continue;
            const bool opposite = data_.face_vertices[h] != data_.face_vertices[t];
            fans.unite(h, opposite ? next(t) : t);
            fans.unite(next(h), opposite ? t : next(t));
        }
        std::vector<std::uint8_t> taken(data_.positions.size(), 0);
        std::vector<std::uint32_t> vertex(corners);
        bool changed = false;
        for (std::uint32_t h = 0; h < corners; ++h) {
            const std::uint32_t r = fans.find(h), v = data_.face_vertices[h];
            if (r != h) {  // roots are the lowest corners of their fans, so they have numbers already
                vertex[h] = vertex[r];
                continue;
            }
            vertex[h] = v;
            if (!taken[v]) {
                taken[v] = 1;
                continue;
            }
            vertex[h] = static_cast<std::uint32_t>(data_.positions.size());
            data_.positions.push_back(data_.positions[v]);
            if (!data_.vertex_lines.empty()) data_.vertex_lines.push_back(data_.vertex_lines[v]);
            result_.origin.push_back(result_.origin[v]);
            changed = true;
        }
        data_.face_vertices = std::move(vertex);
        return changed;
    }

    // Whether two faces have the same orientation: they use their edge in opposite directions.
    bool agree(std::uint32_t h) const { return data_.face_vertices[h] != data_.face_vertices[links_.twin[h]]; }

    bool orient() {
        const auto faces = static_cast<std::uint32_t>(data_.face_offsets.size() - 1);
        constexpr std::uint8_t unseen = 0, kept = 1, flipped = 2;
        std::vector<std::uint8_t> state(faces, unseen);
        std::vector<std::uint32_t> piece, to_flip;
        bool changed = false;
        for (std::uint32_t seed = 0; seed < faces; ++seed) {
            if (state[seed] != unseen) continue;
            piece.assign(1, seed);
            state[seed] = kept;
            std::size_t flip_count = 0;
            for (std::size_t i = 0; i < piece.size(); ++i) {
                const std::uint32_t f = piece[i];
                for (std::uint32_t h = data_.face_offsets[f]; h < data_.face_offsets[f + 1]; ++h) {
                    if (links_.twin[h] == k_none) continue;
                    const std::uint32_t g = links_.face[links_.twin[h]];
                    const std::uint8_t wanted = agree(h) ? state[f] : (state[f] == kept ? flipped : kept);
                    if (state[g] == unseen) {
                        state[g] = wanted;
                        flip_count += wanted == flipped;
                        piece.push_back(g);
                    } else if (state[g] != wanted && !cut_[h] && !cut_[links_.twin[h]]) {
                        // The corners at both ends of h leave their fans, so that no other face can share the edge.
                        cut_[h] = cut_[next(h)] = cut_[prev(h)] = 1;
                        ++result_.cut_faces;
                        changed = true;
                    }
                }
            }
            const std::uint8_t flip = flip_count * 2 > piece.size() ? kept : flipped;
            for (const std::uint32_t f : piece)
                if (state[f] == flip) to_flip.push_back(f);
        }
        if (changed) return true;  // the cuts must be made first
        for (const std::uint32_t f : to_flip) flip_face(f);
        result_.flipped_faces += to_flip.size();
        return false;
    }

    void flip_face(std::uint32_t f) {
        const auto flip = [&](std::vector<std::uint32_t>& layer) {
            if (!layer.empty())
                std::reverse(layer.begin() + data_.face_offsets[f] + 1, layer.begin() + data_.face_offsets[f + 1]);
        };
        flip(data_.face_vertices);
        flip(data_.face_uvs);
        flip(data_.face_normals);
    }

    ControlMeshData& data_;
    MeshLinks links_;
    std::vector<std::uint8_t> cut_;  ///< half-edges that connect nothing
    std::ptrdiff_t vertices_before_ = std::ssize(data_.positions);
    ManifoldSplit result_;
};

}  // namespace

ManifoldSplit split_to_manifold(ControlMeshData& data) { return Splitter(data).run(); }

}  // namespace tetrakis::detail
