#include "crease_chains.hpp"

namespace tetrakis {

namespace {

/// Edges of a mesh by the vertices at their ends.
struct SharpEdges {
    const RuleMesh& mesh;
    std::vector<std::vector<int>> at;  ///< per vertex its sharp edges, as half-edges of either direction

    explicit SharpEdges(const RuleMesh& m) : mesh(m), at(m.vertex_count()) {
        for (int e = 0; e < m.edge_count(); ++e) {
            const int h = m.edge_halfedge(e);
            if (!m.sharp(h)) continue;
            at[m.origin(h)].push_back(h);
            at[m.target(h)].push_back(h);
        }
    }
    bool goes_on(int v) const { return at[v].size() == 2 && !is_sharp(mesh.vertex_sharpness(v)); }
    int other_end(int h, int v) const { return mesh.origin(h) == v ? mesh.target(h) : mesh.origin(h); }
    int other_edge(int h, int v) const { return at[v][0] == h ? at[v][1] : at[v][0]; }
};

}  // namespace

std::vector<CreaseChain> crease_chains(const RuleMesh& mesh) {
    const SharpEdges edges(mesh);
    std::vector<char> used(mesh.edge_count(), 0);
    std::vector<CreaseChain> chains;
    // From a vertex along an edge until the chain ends or returns.
    const auto follow = [&](int v, int h) {
        CreaseChain chain;
        chain.vertices.push_back(v);
        for (;;) {
            used[mesh.edge(h)] = 1;
            v = edges.other_end(h, v);
            if (edges.goes_on(v) && used[mesh.edge(edges.other_edge(h, v))] != 0) {
                chain.closed = true;
                return chain;
            }
            chain.vertices.push_back(v);
            if (!edges.goes_on(v)) return chain;
            h = edges.other_edge(h, v);
        }
    };
    // First those with ends; what is left then are loops.
    for (int v = 0; v < mesh.vertex_count(); ++v)
        for (const int h : edges.at[v])
            if (!edges.goes_on(v) && used[mesh.edge(h)] == 0) chains.push_back(follow(v, h));
    for (int e = 0; e < mesh.edge_count(); ++e) {
        const int h = mesh.edge_halfedge(e);
        if (mesh.sharp(h) && used[e] == 0) chains.push_back(follow(mesh.origin(h), h));
    }
    return chains;
}

}  // namespace tetrakis
