#include "triangle_forest.hpp"

#include <algorithm>
#include <string>

namespace tetrakis {

namespace {

std::string about(std::uint32_t slot, const std::string& what) {
    return "triangle " + std::to_string(slot) + ": " + what;
}

}  // namespace

std::optional<std::string> TriangleForest::check_record(std::uint32_t record) const {
    const Record& r = records_[record];
    const std::uint32_t slot = r.parent;
    if (slot >= child_.size() || child_[slot] != record)
        return "record " + std::to_string(record) + " is not that of its parent " + std::to_string(slot);
    const Frame f = frame(slot);
    if (r.face != f.face || r.at != f.at || r.level != f.level || r.is_reversed != f.is_reversed)
        return about(slot, "its record has another place");
    if (r.level >= k_max_level) return about(slot, "is split below the deepest level");
    const auto c = corners(slot);
    if (!std::equal(c.begin(), c.end(), r.point.begin())) return about(slot, "its record has other corners");
    for (std::uint32_t e = 0; e < 3; ++e) {
        const Neighbour next = neighbour(slot, e);
        const std::string edge = "edge " + std::to_string(e);
        if (next.slot == k_coarser) return about(slot, edge + " has a neighbour two levels coarser than its children");
        const std::uint32_t expected = next.slot == k_boundary ? k_boundary
                                       : is_split(next.slot)   ? 4 * child_[next.slot] + next.edge
                                                               : k_coarser;
        if (r.link[e] != expected) return about(slot, edge + " has a wrong link");
        const std::uint32_t point = r.point[3 + e];
        if (!is_point(PointId(point))) return about(slot, edge + " has no midpoint");
        if (sites_[point] != canonical_.canonical(midpoint_site(f, e)))
            return about(slot, "the midpoint of " + edge + " has another site");
        if (expected >= k_boundary) continue;
        const Record& other = records_[expected / 4];
        if (other.link[next.edge] != 4 * record + e) return about(slot, edge + " has a one-way link");
        if (other.point[3 + next.edge] != point) return about(slot, edge + " has two midpoints");
    }
    return std::nullopt;
}

// Every point in use is a corner of the control mesh or the midpoint of exactly one edge.
std::optional<std::string> TriangleForest::check_points() const {
    std::vector<std::uint8_t> is_used(sites_.size(), 0);
    for (std::uint32_t f = 0; f < root_count_; ++f)
        if (child_[f] != k_dead)
            for (const std::uint32_t p : corners(f)) is_used[p] = 1;
    for (std::uint32_t record = 0; record < records_.size(); ++record) {
        const Record& r = records_[record];
        if (child_[first_child(record)] == k_dead) continue;
        for (std::uint32_t e = 0; e < 3; ++e) {
            if (r.link[e] < k_boundary && r.link[e] / 4 < record) continue;
            if (is_used[r.point[3 + e]]) return "point " + std::to_string(r.point[3 + e]) + " stands for two places";
            is_used[r.point[3 + e]] = 1;
        }
    }
    for (std::uint32_t p = 0; p < sites_.size(); ++p)
        if ((is_used[p] != 0) != is_point(PointId(p)))
            return "point " + std::to_string(p) + (is_used[p] ? " is in use but freed" : " is not in use");
    for (const std::uint32_t p : free_points_)
        if (is_point(PointId(p))) return "point " + std::to_string(p) + " is free and in use";
    const auto used = std::count(is_used.begin(), is_used.end(), std::uint8_t{1});
    if (used != point_count_) return "the number of points is wrong";
    const auto reserved = std::count_if(sites_.begin(), sites_.begin() + mesh_->vertex_count(),
                                        [](const Site& s) { return !s.root.valid(); });
    if (static_cast<std::size_t>(used + reserved) + free_points_.size() != sites_.size()) return "a point is lost";
    return std::nullopt;
}

std::optional<std::string> TriangleForest::check() const {
    if (child_.size() != root_count_ + 4 * records_.size() || marks_.size() != child_.size())
        return "the arrays of slots have wrong sizes";
    for (std::uint32_t h = 0; h < root_link_.size(); ++h) {
        const HalfedgeId twin = mesh_->twin(HalfedgeId(h));
        const bool open = !twin.valid() || mesh_->is_hole(mesh_->face(twin)) || child_[h / 3] == k_dead;
        if (root_link_[h] != (open ? k_boundary : 4 * (twin.value / 3) + twin.value % 3))
            return about(h / 3, "edge " + std::to_string(h % 3) + " of the root has a wrong link");
        if ((child_[h / 3] == k_dead) != mesh_->is_hole(FaceId(h / 3)))
            return about(h / 3, "is a root that is no hole, but dead, or the reverse");
    }
    if (const auto mark = std::find(marks_.begin(), marks_.end(), std::uint8_t{1}); mark != marks_.end())
        return about(static_cast<std::uint32_t>(mark - marks_.begin()), "kept a mark of the last call");
    std::vector<std::uint32_t> open;
    std::size_t leaves = 0, records = 0;
    for (std::uint32_t f = 0; f < root_count_; ++f)
        if (child_[f] != k_dead) open.push_back(f);
    while (!open.empty()) {
        const std::uint32_t slot = open.back();
        open.pop_back();
        if (!is_split(slot)) {
            if (child_[slot] == k_dead) return about(slot, "is dead, but its parent is split");
            ++leaves;
            continue;
        }
        if (child_[slot] >= records_.size()) return about(slot, "has no record");
        if (auto fault = check_record(child_[slot])) return fault;
        ++records;
        for (std::uint32_t k = 0; k < 4; ++k) open.push_back(first_child(child_[slot]) + k);
    }
    if (leaves != leaf_count_) return "the number of leaves is wrong";
    if (records + free_records_.size() != records_.size()) return "a record is lost";
    for (const std::uint32_t record : free_records_) {
        if (record >= records_.size()) return "record " + std::to_string(record) + " is free, but does not exist";
        for (std::uint32_t k = 0; k < 4; ++k)
            if (child_[first_child(record) + k] != k_dead)
                return "record " + std::to_string(record) + " is free and in use";
    }
    return check_points();
}

}  // namespace tetrakis
