#include "sqrt3_levels.hpp"

#include "../base/error.hpp"
#include "../base/memory.hpp"
#include "../base/parallel.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

namespace tetrakis {

namespace {

bool cuts_edges(int level) { return level % 2 != 0; }

/// Whether a step that cuts edges cuts the first side of a face, the only one that can be (Sqrt3Lattice).
bool is_cut(const Sqrt3Level& level, std::uint32_t f) { return level.twin[3 * f] == Sqrt3Level::none; }

}  // namespace

Sqrt3Levels::Sqrt3Levels(const Sqrt3Lattice& lattice, const Sqrt3Split& split, int rings, bool limits,
                         const RunContext& context)
    : lattice_(&lattice), split_levels_(split.size()) {
    const bool one_more = limits && cuts_edges(static_cast<int>(split.size()));
    levels.resize(split.size() + (one_more ? 2 : 1));
    start(lattice.mesh());
    for (std::size_t k = 0; k + 1 < levels.size(); ++k) {
        const bool cuts = cuts_edges(static_cast<int>(k));
        mark_split(k, k < split.size() ? std::span(split[k]) : std::span<const std::uint64_t>{});
        detail::RawPoolVector<std::uint8_t> faces = levels[k].split;
        if (limits && cuts) add_beside_cuts(levels[k], faces);
        raise(levels[k], static_cast<int>(k), with_rings(levels[k], std::move(faces), rings), levels[k + 1]);
        if (k + 2 < levels.size() || needs_last_twins(levels[k], rings, limits)) link(levels[k], cuts, levels[k + 1]);
        link_lines(levels[k], cuts, levels[k + 1]);
        context.report("levels", static_cast<double>(k + 1) / static_cast<double>(levels.size()));
        if (const std::uint64_t most = context.max_memory_bytes, bytes = memory_bytes(); most != 0 && bytes > most)
            throw Error(ErrorCode::memory_limit, "the first " + std::to_string(k + 2) + " of " +
                                                     std::to_string(levels.size()) + " levels of the mesh take " +
                                                     std::to_string(bytes) + " bytes, more than the limit of " +
                                                     std::to_string(most) + "; coarsen first, or raise the limit");
    }
    Sqrt3Level& last = levels.back();
    last.split.assign(last.face_count(), 0);
    last.child.assign(last.face_count(), Sqrt3Level::outside);
    last.apex.assign(last.face_count(), Sqrt3Level::outside);
}

std::uint64_t Sqrt3Levels::memory_bytes() const {
    const auto bytes_of = [](const auto& array) { return array.capacity() * sizeof(array[0]); };
    std::uint64_t bytes = bytes_of(vertices);
    for (const Sqrt3Level& level : levels)
        bytes += bytes_of(level.number) + bytes_of(level.twin) + bytes_of(level.lines) + bytes_of(level.vertex) +
                 bytes_of(level.apex) + bytes_of(level.child) + bytes_of(level.split);
    return bytes;
}

bool Sqrt3Levels::needs_last_twins(const Sqrt3Level& before_last, int rings, bool limits) const {
    if (!before_last.lines.empty()) return true;
    const auto& roots = levels[0].twin;
    const bool whole = complete && std::find(roots.begin(), roots.end(), Sqrt3Level::none) == roots.end();
    return rings > 0 && limits && !whole;
}

void Sqrt3Levels::start(const ControlMesh& mesh) {
    Sqrt3Level& level = levels[0];
    level.number.resize(mesh.face_count());
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) level.number[f] = f;
    level.twin.resize(mesh.halfedge_count());
    level.vertex.resize(mesh.halfedge_count());
    for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h) {
        const HalfedgeId twin = mesh.twin(HalfedgeId(h));
        level.twin[h] = twin.valid() ? twin.value : Sqrt3Level::none;
        level.vertex[h] = mesh.origin(HalfedgeId(h)).value;
        const EdgeId edge = mesh.edge(HalfedgeId(h));
        const float sharpness = mesh.sharpness(edge);
        const bool kept = lattice_->is_kept(edge);
        if (!twin.valid() || !(sharpness > 0 || kept)) continue;
        level.lines.push_back({h, twin.value, sharpness, kept});
        level.twin[h] = Sqrt3Level::none;
    }
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) vertices.push_back({v, 0, Sqrt3Vertex::Kind::control});
}

// Both come by their numbers.
void Sqrt3Levels::mark_split(std::size_t index, std::span<const std::uint64_t> numbers) {
    Sqrt3Level& level = levels[index];
    level.split.resize(level.face_count());
    bool all = index == 0 || levels[index - 1].all_split;
    std::size_t next = 0;
    for (std::uint32_t f = 0; f < level.face_count(); ++f) {
        while (next < numbers.size() && numbers[next] < level.number[f]) ++next;
        const bool split = next < numbers.size() && numbers[next] == level.number[f];
        level.split[f] = split ? 1 : 0;
        all = all && split;
    }
    level.all_split = all;
}

// The point of a face opposite the side that will be cut has come with the step before.
void Sqrt3Levels::add_beside_cuts(const Sqrt3Level& level, detail::RawPoolVector<std::uint8_t>& faces) const {
    detail::PoolVector<std::uint8_t> beside;
    for (std::uint32_t f = 0; f < level.face_count(); ++f)
        if (is_cut(level, f)) {
            beside.resize(vertices.size(), 0);
            beside[level.vertex[3 * f + 2]] = 1;
        }
    if (beside.empty()) return;
    for (std::uint32_t h = 0; h < level.vertex.size(); ++h)
        if (Sqrt3Level::there(level.vertex[h]) && beside[level.vertex[h]] != 0) faces[h / 3] = 1;
}

detail::RawPoolVector<std::uint8_t> Sqrt3Levels::with_rings(const Sqrt3Level& level,
                                                            detail::RawPoolVector<std::uint8_t> faces,
                                                            int rings) const {
    if (rings == 0 || std::find(faces.begin(), faces.end(), 0) == faces.end()) return faces;
    detail::PoolVector<std::uint8_t> seen(vertices.size(), 0);
    for (int ring = 0; ring < rings; ++ring) {
        for (std::uint32_t f = 0; f < faces.size(); ++f)
            for (std::uint32_t h = 3 * f; faces[f] != 0 && h < 3 * f + 3; ++h)
                if (Sqrt3Level::there(level.vertex[h])) seen[level.vertex[h]] = 1;
        bool grown = false;
        for (std::uint32_t f = 0; f < faces.size(); ++f)
            for (std::uint32_t h = 3 * f; faces[f] == 0 && h < 3 * f + 3; ++h)
                if (Sqrt3Level::there(level.vertex[h]) && seen[level.vertex[h]] != 0) faces[f] = grown = true;
        if (!grown) break;
    }
    return faces;
}

void Sqrt3Levels::raise(Sqrt3Level& level, int index, std::span<const std::uint8_t> faces, Sqrt3Level& finer) {
    const std::uint32_t count = level.face_count();
    detail::reserve_large(level.child, count);
    detail::resize_large(level.apex, count);
    level.child.assign(count, Sqrt3Level::outside);
    std::uint32_t raised = 0;
    for (std::uint32_t f = 0; f < count; ++f) {
        if (faces[f] == 0) {
            complete = false;
            continue;
        }
        level.child[f] = raised;
        raised += 3;
    }
    detail::resize_large(finer.number, raised);
    detail::resize_large(finer.vertex, 3 * std::size_t{raised});
    const std::size_t points = vertices.size() + (cuts_edges(index) ? 2 : 1) * std::size_t{count};
    if (points > vertices.capacity()) detail::reserve_large(vertices, std::max(points, 2 * vertices.capacity()));
    const auto birth = static_cast<std::uint8_t>(index + 1);
    const bool cuts = cuts_edges(index);
    const auto add = [&](std::uint64_t key, Sqrt3Vertex::Kind kind) {
        vertices.push_back({key, birth, kind});
        return static_cast<std::uint32_t>(vertices.size() - 1);
    };
    std::vector<std::pair<std::uint32_t, std::uint32_t>> later;  // whose points the faces beyond name
    for (std::uint32_t f = 0; f < count; ++f) {
        const std::uint64_t number = level.number[f];
        if (cuts && is_cut(level, f)) {
            const Sqrt3Line* line = level.line(3 * f);
            if (line != nullptr && Sqrt3Level::there(line->beyond) &&
                !lattice_->owns_cut(index, number, level.number[line->beyond / 3])) {
                later.emplace_back(f, line->beyond / 3);
                continue;
            }
            level.apex[f] = add(3 * number, Sqrt3Vertex::Kind::first);
            add(3 * number, Sqrt3Vertex::Kind::second);
        } else {
            level.apex[f] = add(number, Sqrt3Vertex::Kind::centre);
        }
    }
    for (const auto& [f, beyond] : later) level.apex[f] = level.apex[beyond] + 1;
    const auto apex = [&](std::uint32_t h) {
        if (!Sqrt3Level::there(h)) return Sqrt3Level::outside;
        const std::uint32_t f = h / 3;
        return cuts && h % 3 == 1 && is_cut(level, f) ? beside(level.apex[f]) : level.apex[f];
    };
    for_each_index(count, [&](std::uint32_t f) {
        if (faces[f] == 0) return;
        for (std::uint32_t j = 0; j < 3; ++j) finer.number[level.child[f] + j] = 3 * level.number[f] + j;
        std::uint32_t* to = &finer.vertex[3 * std::size_t{level.child[f]}];
        const bool cut = cuts && is_cut(level, f);
        for (std::uint32_t h = 3 * f; h < 3 * f + 3; ++h, to += 3) {
            if (cut && h == 3 * f) {
                to[0] = level.apex[f];
                to[1] = beside(level.apex[f]);
                to[2] = level.vertex[Sqrt3Level::prev(h)];
                continue;
            }
            const std::uint32_t twin = level.twin[h];
            to[0] = level.vertex[h];
            to[1] = !cuts && twin == Sqrt3Level::none ? level.vertex[Sqrt3Level::next(h)] : apex(twin);
            to[2] = cut ? apex(h) : level.apex[f];
        }
    });
}

Sqrt3Leaf Sqrt3Levels::leaf(int level, std::uint32_t face, bool half, FaceId control_face) const {
    const Sqrt3Level& at = levels[static_cast<std::size_t>(level)];
    Sqrt3Leaf leaf;
    leaf.level = static_cast<std::uint8_t>(level);
    leaf.half = half;
    leaf.control_face = control_face;
    leaf.vertex_level.fill(leaf.level);
    if (!half) {
        leaf.face = at.number[face];
        for (std::uint32_t k = 0; k < 3; ++k) {
            leaf.leaving[k] = 3 * leaf.face + k;
            leaf.vertex[k] = vertices[at.vertex[3 * face + k]];
        }
        return leaf;
    }
    leaf.face = 3 * at.number[face / 3] + face % 3;
    leaf.leaving = {leaf.face, Sqrt3Lattice::next(leaf.face), 3 * leaf.face + 2};
    leaf.vertex = {vertices[at.vertex[face]], vertices[at.vertex[Sqrt3Level::next(face)]], vertices[apex(level, face)]};
    ++leaf.vertex_level[2];
    return leaf;
}

// As Sqrt3Lattice finds twins, for all half-edges at once.
void Sqrt3Levels::link(const Sqrt3Level& level, bool cuts, Sqrt3Level& finer) const {
    constexpr std::uint32_t none = Sqrt3Level::none, outside = Sqrt3Level::outside;
    const auto next = [](std::uint32_t h) { return Sqrt3Level::next(h); };
    const auto prev = [](std::uint32_t h) { return Sqrt3Level::prev(h); };
    // Side j of the next level's face over h.
    const auto side = [&](std::uint32_t h, std::uint32_t j) {
        if (!Sqrt3Level::there(h)) return outside;
        const std::uint32_t f = level.child_over(h);
        return f == outside ? outside : 3 * f + j;
    };
    // Where all edges are flipped and all faces beyond them are raised.
    const auto link_plainly = [&](std::uint32_t f, std::uint32_t* to) {
        std::array<std::uint32_t, 3> over, over_next;  // faces of the next level, over the half-edges beyond and after
        for (std::uint32_t j = 0; j < 3; ++j) {
            const std::uint32_t t = level.twin[3 * f + j];
            if (!Sqrt3Level::there(t)) return false;
            const std::uint32_t beyond = t / 3, first = level.child[beyond], side_beyond = t - 3 * beyond;
            if (first == outside || (cuts && is_cut(level, beyond))) return false;
            over[j] = first + side_beyond;
            over_next[j] = first + (side_beyond == 2 ? 0 : side_beyond + 1);
        }
        for (std::uint32_t j = 0; j < 3; ++j) {
            to[3 * j] = 3 * over_next[j] + 2;
            to[3 * j + 1] = 3 * over[j] + 1;
            to[3 * j + 2] = 3 * over[j == 0 ? 2 : j - 1];
        }
        return true;
    };
    detail::resize_large(finer.twin, 3 * std::size_t{finer.face_count()});
    for_each_index(level.face_count(), [&](std::uint32_t f) {
        if (level.child[f] == outside) return;
        std::uint32_t* to = &finer.twin[3 * std::size_t{level.child[f]}];
        if (link_plainly(f, to)) return;
        const bool cut = cuts && is_cut(level, f);
        for (std::uint32_t h = 3 * f; h < 3 * f + 3; ++h, to += 3) {
            const std::uint32_t t = level.twin[h], behind = level.twin[prev(h)];
            if (!cuts) {
                to[0] = t == none ? none : t == outside ? outside : side(next(t), 2);
                to[1] = t == none ? side(next(h), 2) : side(t, 1);
                to[2] = behind == none ? side(prev(h), 1) : side(behind, 0);
                continue;
            }
            if (cut && h == 3 * f) {
                to[0] = none;
                to[1] = side(level.twin[next(h)], 0);
                to[2] = side(prev(h), 2);
                continue;
            }
            to[1] = side(t, 1);
            if (t == outside) {
                to[0] = outside;
            } else {
                const bool beyond = is_cut(level, t / 3);
                to[0] = !beyond ? side(next(t), 2) : next(t) == t / 3 * 3 ? none : side(t / 3 * 3, 1);
            }
            to[2] = !cut ? side(behind, 0) : prev(h) == 3 * f ? none : side(3 * f, 2);
        }
    });
}

// As Sqrt3Lattice finds what is beyond a line.
void Sqrt3Levels::link_lines(const Sqrt3Level& level, bool cuts, Sqrt3Level& finer) const {
    constexpr std::uint32_t outside = Sqrt3Level::outside;
    const auto side = [&](std::uint32_t h, std::uint32_t j) {
        if (!Sqrt3Level::there(h)) return outside;
        const std::uint32_t f = level.child_over(h);
        return f == outside ? outside : 3 * f + j;
    };
    for (const auto& [h, beyond, before, kept] : level.lines) {
        const float sharpness = cuts ? std::max(before - 1, 0.0f) : before;
        const auto put = [&, is_kept = kept](std::uint32_t at, std::uint32_t other) {
            if (at == outside) return;
            if (sharpness > 0 || is_kept)
                finer.lines.push_back({at, other, sharpness, is_kept});
            else
                finer.twin[at] = other;  // a crease that has become smooth
        };
        put(side(h, 0), side(beyond, 0));
        if (!cuts) continue;
        const bool there = Sqrt3Level::there(beyond);
        const auto across = [&](std::uint32_t of) { return level.twin[Sqrt3Level::prev(of)]; };
        put(side(across(h), 0), there ? side(Sqrt3Level::next(beyond), 2) : outside);
        put(side(Sqrt3Level::next(h), 2), there ? side(across(beyond), 0) : outside);
    }
    std::sort(finer.lines.begin(), finer.lines.end(),
              [](const Sqrt3Line& a, const Sqrt3Line& b) { return a.halfedge < b.halfedge; });
}

}  // namespace tetrakis
