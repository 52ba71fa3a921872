#include "mesh_repair.hpp"

#include "../base/error.hpp"
#include "corner_tags.hpp"
#include "mesh_check.hpp"
#include "mesh_links.hpp"
#include "mesh_numbering.hpp"
#include "mesh_split.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <utility>

namespace tetrakis {

namespace {

using detail::count_of;
using detail::gather;
using detail::k_no_number;
using detail::NewFaces;
using detail::Numbering;

// Number of repairs of one kind, with the first element for the report, and its line if it is a tag.
struct Tally {
    std::uint64_t count = 0;
    std::uint32_t first = 0;
    std::uint64_t line = 0;

    void add(std::uint32_t element, std::uint64_t its_line = 0) {
        if (count++ == 0) first = element, line = its_line;
    }
};

class Repair {
  public:
    explicit Repair(ControlMeshData& data) : data_(data) {
        check_offsets();
        source_face_.resize(face_count());
        std::iota(source_face_.begin(), source_face_.end(), 0u);
    }

    std::vector<std::string> run() {
        drop_misfit_layers();
        mend_uvs();
        rebuild_faces();
        drop_duplicates();
        make_manifold();
        mend_tags();
        const auto angles = std::exchange(data_.corner_angles, {});
        drop_isolated();
        mend_angles(angles);
        return std::move(reports_);
    }

    std::vector<std::string> weld(double distance) {
        const std::vector<std::uint32_t> first = detail::welded(data_.positions, distance);
        std::vector<std::uint8_t> has_others(first.size(), 0);
        std::uint64_t gone = 0;
        for (std::uint32_t v = 0; v < first.size(); ++v)
            if (first[v] != v) {
                ++gone;
                has_others[first[v]] = 1;
            }
        const auto places = static_cast<std::uint64_t>(std::ranges::count(has_others, 1));
        if (gone == 0) return {};
        report("joined {} vertices at {} places", gone + places, places);
        drop_misfit_layers();
        renumber_vertices(Numbering(first));
        if (const auto creases = std::erase_if(data_.creases, [](const auto& tag) { return tag.a == tag.b; }))
            report("dropped {} crease tags of edges whose ends fell together", creases);
        join_uvs();
        drop_collapsed();
        return std::move(reports_);
    }

  private:
    template <class... Args>
    void report(fmt::format_string<Args...> text, Args&&... args) {
        reports_.push_back(fmt::format(text, std::forward<Args>(args)...));
    }

    /// Reports nothing if the tally is empty. The text takes the count and name(first element).
    template <class Name>
    void report_all(const Tally& tally, fmt::format_string<const std::uint64_t&, std::string> text, Name&& name) {
        if (tally.count != 0) report(text, tally.count, name(tally.first));
    }
    void report_tags(const Tally& tally, fmt::format_string<const std::uint64_t&, std::string> text) {
        report_all(tally, text, [&](std::uint32_t i) {
            const std::uint64_t number = std::uint64_t{i} + data_.first_number;
            return tally.line == 0 ? fmt::format("{}", number) : fmt::format("{} on line {}", number, tally.line);
        });
    }
    // The source's name for a face, by its present number.
    std::string original_face(std::uint32_t f) const {
        const std::uint64_t line = f < data_.face_lines.size() ? data_.face_lines[f] : 0;
        return line == 0 ? fmt::format("face {}", std::uint64_t{source_face_[f]} + data_.first_number)
                         : fmt::format("face {} (line {})", std::uint64_t{source_face_[f]} + data_.first_number, line);
    }

    std::uint32_t face_count() const { return count_of(data_.face_offsets.size() - 1); }

    void check_offsets() {
        auto& offsets = data_.face_offsets;
        if (offsets.empty() && data_.face_vertices.empty()) offsets.push_back(0);
        if (offsets.empty() || offsets.front() != 0 || offsets.back() != data_.face_vertices.size() ||
            !std::is_sorted(offsets.begin(), offsets.end()))
            throw Error(ErrorCode::invalid_input,
                        "face_offsets must ascend from 0 to the size of face_vertices; this cannot be repaired",
                        data_.source);
    }

    template <class T>
    void drop_misfit(std::vector<T>& layer, std::size_t wanted, const char* what) {
        if (layer.empty() || layer.size() == wanted) return;
        report("dropped {}: {} numbers where {} are needed", what, layer.size(), wanted);
        layer.clear();
    }

    void drop_misfit_layers() {
        const std::size_t corners = data_.face_vertices.size(), faces = face_count();
        drop_misfit(data_.face_uvs, corners, "the texture coordinates");
        drop_misfit(data_.face_normals, corners, "the normals");
        drop_misfit(data_.face_material, faces, "the materials");
        drop_misfit(data_.face_group, faces, "the groups");
        drop_misfit(data_.face_lines, faces, "the faces' line numbers");
        drop_misfit(data_.vertex_lines, data_.positions.size(), "the vertices' line numbers");
        drop_misfit(data_.uv_lines, data_.uvs.size(), "the texture coordinates' line numbers");
        drop_misfit(data_.hole_lines, data_.holes.size(), "the holes' line numbers");
        const auto beyond = [](const std::vector<std::uint32_t>& numbers, std::size_t limit) {
            return std::ranges::any_of(numbers, [limit](std::uint32_t n) { return n >= limit; });
        };
        if (beyond(data_.face_normals, data_.normals.size())) {
            report("dropped the normals: some faces use normals that are not there");
            data_.face_normals.clear();
            data_.normals.clear();
        }
        const auto drop_nameless = [&](std::vector<std::uint32_t>& numbers, std::size_t count, const char* what) {
            if (!beyond(numbers, count)) return;
            report("dropped the {0}: some faces use {0} that have no name", what);
            numbers.clear();
        };
        drop_nameless(data_.face_material, data_.materials.size(), "materials");
        drop_nameless(data_.face_group, data_.groups.size(), "groups");
    }

    void mend_uvs() {
        const auto bad = std::ranges::count_if(data_.uvs, std::not_fn(is_sound_uv));
        if (bad != 0) report("set {} texture coordinates that are not finite or absurd to (0, 0)", bad);
        std::ranges::replace_if(data_.uvs, std::not_fn(is_sound_uv), Vec2d(0.0));
        const std::uint32_t known = count_of(data_.uvs.size());
        const auto is_beyond = [known](std::uint32_t i) { return i >= known; };
        const auto beyond = std::ranges::count_if(data_.face_uvs, is_beyond);
        if (beyond == 0) return;
        std::ranges::replace_if(data_.face_uvs, is_beyond, known);
        data_.uvs.emplace_back(0.0, 0.0);
        if (!data_.uv_lines.empty()) data_.uv_lines.push_back(0);
        report("gave {} face corners the texture coordinate (0, 0) for one that is not there", beyond);
    }

    void adopt(const NewFaces& faces) {
        const std::vector<std::uint64_t> lines = data_.hole_lines;
        Tally dropped;
        for (const std::uint32_t i : detail::replace_faces(data_, faces)) dropped.add(i, lines.empty() ? 0 : lines[i]);
        report_tags(dropped, "dropped {} hole tags of faces that are not there (the first is tag {})");
        gather(source_face_, faces.sources);
    }

    // Drops faces with bad vertices; cuts faces that visit a vertex twice into loops.
    void rebuild_faces() {
        const auto is_sound = [&](std::uint32_t v) {
            return v < data_.positions.size() && detail::is_sound_position(data_.positions[v]);
        };
        NewFaces faces;
        faces.corners.reserve(data_.face_vertices.size());
        Tally unsound, small, cut;
        std::vector<std::uint32_t> place(data_.positions.size(), k_no_number);  // per vertex: its position on the path
        std::vector<std::uint32_t> path;
        for (std::uint32_t f = 0; f < face_count(); ++f) {
            const std::uint32_t first = data_.face_offsets[f], end = data_.face_offsets[f + 1];
            if (!std::all_of(data_.face_vertices.begin() + first, data_.face_vertices.begin() + end, is_sound)) {
                unsound.add(f);
                continue;
            }
            std::uint32_t loops = 0;
            const auto emit = [&](std::size_t from) {
                if (path.size() - from < 3) return;
                faces.corners.insert(faces.corners.end(), path.begin() + static_cast<std::ptrdiff_t>(from), path.end());
                faces.end_face(f);
                ++loops;
            };
            path.clear();
            bool repeats = false;
            for (std::uint32_t h = first; h < end; ++h) {
                const std::uint32_t at = place[data_.face_vertices[h]];
                if (at != k_no_number) {  // the path since then is a loop through this vertex
                    repeats = true;
                    emit(at);
                    for (std::size_t i = at; i < path.size(); ++i) place[data_.face_vertices[path[i]]] = k_no_number;
                    path.resize(at);
                }
                place[data_.face_vertices[h]] = count_of(path.size());
                path.push_back(h);
            }
            emit(0);
            for (const std::uint32_t h : path) place[data_.face_vertices[h]] = k_no_number;
            if (loops == 0)
                small.add(f);
            else if (repeats)
                cut.add(f);
        }
        const auto name_of_face = [&](std::uint32_t f) { return original_face(f); };
        report_all(unsound, "dropped {} faces with a vertex that is not there or not finite (the first is {})",
                   name_of_face);
        report_all(small, "dropped {} faces with fewer than three distinct vertices (the first is {})", name_of_face);
        report_all(cut, "took repeated vertices out of {} faces (the first is {})", name_of_face);
        const bool holes_beyond = std::ranges::any_of(data_.holes, [&](std::uint32_t f) { return f >= face_count(); });
        if (unsound.count + small.count + cut.count != 0 || holes_beyond) adopt(faces);
    }

    void drop_duplicates() {
        const auto duplicates = detail::duplicate_faces(data_);
        if (duplicates.empty()) return;
        NewFaces faces;
        for (std::uint32_t f = 0; f < face_count(); ++f) {
            if (std::ranges::binary_search(duplicates, f, {}, &detail::DuplicateFace::face)) continue;
            for (std::uint32_t h = data_.face_offsets[f]; h < data_.face_offsets[f + 1]; ++h)
                faces.corners.push_back(h);
            faces.end_face(f);
        }
        report("dropped {} duplicate faces (the first is {})", duplicates.size(),
               original_face(duplicates.front().face));
        adopt(faces);
    }

    void make_manifold() {
        detail::ManifoldSplit split = detail::split_to_manifold(data_);
        origin_ = std::move(split.origin);
        if (split.non_manifold_edges != 0)
            report("split {} edges of more than two faces into boundaries (the first is between {} and {})",
                   split.non_manifold_edges, detail::vertex_name(data_, split.first_edge[0]),
                   detail::vertex_name(data_, split.first_edge[1]));
        if (split.flipped_faces != 0) report("flipped {} faces to orient all alike", split.flipped_faces);
        if (split.cut_faces != 0) report("cut surfaces that have no orientation open along {} faces", split.cut_faces);
        if (split.split_vertices != 0)
            report("split {} vertices whose faces were not one fan (the first is {})", split.split_vertices,
                   detail::vertex_name(data_, split.first_vertex));
    }

    /// Copies tags of old edges or vertices to all their copies.
    /// @param copies  copies of each old edge or vertex
    /// @param of      of(tag): the old edge or vertex of the tag
    /// @param put     put(tag, copy) makes the tag name the copy
    template <class Tag, class Key, class Of, class Put>
    static Tally copy_tags(std::vector<Tag>& tags, const std::multimap<Key, Key>& copies, Of&& of, Put&& put) {
        std::vector<Tag> result;
        Tally dropped;
        for (std::uint32_t i = 0; i < tags.size(); ++i) {
            auto [copy, end] = copies.equal_range(of(tags[i]));
            if (!(tags[i].sharpness >= 0.0f)) copy = end;
            if (copy == end) dropped.add(i, tags[i].line);
            for (; copy != end; ++copy) {
                result.push_back(tags[i]);
                put(result.back(), copy->second);
            }
        }
        tags = std::move(result);
        return dropped;
    }

    // Tags name the vertices from before the split: each copy of an edge or vertex gets them.
    void mend_tags() {
        using Edge = std::array<std::uint32_t, 2>;  // the lower vertex first
        const auto edge = [](std::uint32_t a, std::uint32_t b) { return Edge{std::min(a, b), std::max(a, b)}; };
        std::multimap<Edge, Edge> edges;
        if (!data_.creases.empty()) {
            Edge last{};
            for (const detail::EdgeUse& use : detail::sorted_edge_uses(data_))
                if (const Edge now{use.low, use.high}; std::exchange(last, now) != now)
                    edges.emplace(edge(origin_[use.low], origin_[use.high]), now);
        }
        const Tally no_crease = copy_tags(
            data_.creases, edges, [&](const auto& tag) { return edge(tag.a, tag.b); },
            [](auto& tag, const Edge& now) { tag.a = now[0], tag.b = now[1]; });

        std::multimap<std::uint32_t, std::uint32_t> vertices;
        if (!data_.corners.empty()) {
            std::vector<std::uint8_t> used(data_.positions.size(), 0);
            for (const std::uint32_t v : data_.face_vertices) used[v] = 1;
            for (std::uint32_t v = 0; v < origin_.size(); ++v)
                if (used[v]) vertices.emplace(origin_[v], v);
        }
        const Tally no_corner = copy_tags(
            data_.corners, vertices, [](const auto& tag) { return tag.vertex; },
            [](auto& tag, std::uint32_t now) { tag.vertex = now; });
        report_tags(no_crease, "dropped {} crease tags that name no edge or have no sharpness (the first is tag {})");
        report_tags(no_corner,
                    "dropped {} corner tags that name no vertex of a face or have no sharpness (the first is tag {})");
    }

    // Angle tags name the original faces and vertices: each remaining corner of both gets them.
    void mend_angles(const std::vector<ControlMeshData::AngleTag>& before) {
        if (before.empty()) return;
        std::vector<ControlMeshData::AngleTag> now, kept;
        std::vector<std::uint32_t> source;
        Tally lost, other;
        for (std::uint32_t i = 0; i < before.size(); ++i) {
            const auto& tag = before[i];
            const std::size_t size = now.size();
            const auto [first, last] = std::equal_range(source_face_.begin(), source_face_.end(), tag.face);
            for (auto f = first; f != last && detail::is_sector_angle(tag.angle); ++f) {
                const auto face = count_of(static_cast<std::size_t>(f - source_face_.begin()));
                for (std::uint32_t h = data_.face_offsets[face]; h < data_.face_offsets[face + 1]; ++h)
                    if (const std::uint32_t v = data_.face_vertices[h]; origin_[v] == tag.vertex)
                        now.push_back({v, face, tag.angle, tag.line});
            }
            if (now.size() == size) lost.add(i, tag.line);
            source.resize(now.size(), i);
        }
        data_.corner_angles = now;
        std::vector<MeshFault> faults = find_faults(data_);  // all other faults are repaired by now
        std::erase_if(faults, [](const MeshFault& fault) { return fault.kind != MeshFaultKind::corner_angle_tag; });
        for (std::uint32_t i = 0; i < now.size(); ++i)
            if (std::ranges::binary_search(faults, i, {}, &MeshFault::element))
                other.add(source[i], now[i].line);
            else
                kept.push_back(now[i]);
        data_.corner_angles = std::move(kept);
        report_tags(lost,
                    "dropped {} corner angle tags that name no corner of a face that is left, or no angle (the first "
                    "is tag {})");
        report_tags(other, "dropped {} corner angle tags of sectors with another angle (the first is tag {})");
    }

    void drop_isolated() {
        std::vector<std::uint32_t> first(data_.positions.size(), k_no_number);
        for (const std::uint32_t v : data_.face_vertices) first[v] = v;
        Tally dropped;
        for (std::uint32_t v = 0; v < first.size(); ++v)
            if (first[v] == k_no_number) dropped.add(v);
        if (dropped.count == 0) return;
        report_all(dropped, "dropped {} vertices that belong to no face (the first is {})",
                   [&](std::uint32_t v) { return detail::vertex_name(data_, v); });
        renumber_vertices(Numbering(first));
    }

    void renumber_vertices(const Numbering& now) {
        gather(data_.positions, now.kept);
        gather(data_.vertex_lines, now.kept);
        gather(origin_, now.kept);
        for (std::uint32_t& v : data_.face_vertices) now.follow(v);
        for (auto& tag : data_.creases) now.follow(tag.a), now.follow(tag.b);
        for (auto& tag : data_.corners) now.follow(tag.vertex);
        for (auto& tag : data_.corner_angles) now.follow(tag.vertex);
    }

    /// Merges equal texture coordinates.
    void join_uvs() {
        std::vector<Vec3d> values;
        std::vector<std::uint32_t> sound;
        for (std::uint32_t i = 0; i < data_.uvs.size(); ++i) {
            values.emplace_back(data_.uvs[i], 0.0);
            if (is_sound_uv(data_.uvs[i])) sound.push_back(i);
        }
        const Numbering now(detail::first_at_position(values, std::move(sound)));
        for (std::uint32_t& i : data_.face_uvs) now.follow(i);
        gather(data_.uvs, now.kept);
        gather(data_.uv_lines, now.kept);
    }

    /// Removes corners that repeat the previous one, and faces that have fewer than three corners then.
    void drop_collapsed() {
        NewFaces faces;
        Tally small, cut;
        for (std::uint32_t f = 0; f < face_count(); ++f) {
            const std::uint32_t begin = data_.face_offsets[f], end = data_.face_offsets[f + 1];
            const std::size_t size = faces.corners.size();
            for (std::uint32_t h = begin; h < end; ++h)
                if (data_.face_vertices[h] != data_.face_vertices[h == begin ? end - 1 : h - 1])
                    faces.corners.push_back(h);
            if (faces.corners.size() - size < 3) {
                faces.corners.resize(size);
                small.add(f);
                continue;
            }
            if (faces.corners.size() - size < end - begin) cut.add(f);
            faces.end_face(f);
        }
        const auto name_of_face = [&](std::uint32_t f) { return original_face(f); };
        report_all(small, "dropped {} faces with fewer than three corners left (the first is {})", name_of_face);
        report_all(cut, "took corners that fell together out of {} faces (the first is {})", name_of_face);
        if (small.count + cut.count == 0) return;
        adopt(faces);
        const auto angles = std::erase_if(data_.corner_angles, [&](auto& tag) {
            const auto at = std::lower_bound(source_face_.begin(), source_face_.end(), tag.face);
            if (at == source_face_.end() || *at != tag.face) return true;
            tag.face = count_of(static_cast<std::size_t>(at - source_face_.begin()));
            return false;
        });
        if (angles != 0) report("dropped {} corner angle tags of faces that are not there", angles);
    }

    ControlMeshData& data_;
    std::vector<std::uint32_t> source_face_;  ///< per face: its number in the source
    std::vector<std::uint32_t> origin_;       ///< per vertex: its number before the split
    std::vector<std::string> reports_;
};

}  // namespace

std::vector<std::string> repair(ControlMeshData& data) { return Repair(data).run(); }

std::vector<std::string> weld(ControlMeshData& data, double distance) {
    if (!(distance >= 0 && std::isfinite(distance)))
        throw Error(ErrorCode::invalid_input, "the distance to weld within must be 0 or more", data.source);
    return Repair(data).weld(distance);
}

}  // namespace tetrakis
