#include "face_cutter.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

namespace tetrakis::detail {

namespace {

// Largest number of corners times reflex corners of a face for which ears are tested for reflex corners inside. Larger
// faces (concave, ten thousand corners) are cut without this test.
constexpr std::uint64_t k_reflex_budget = 100'000'000;

/// Rounds to 12 bits: diagonals that differ only by rounding are equal then, so equal faces are cut alike.
double rounded(double x) {
    constexpr double k_steps = 4096;
    int exponent = 0;
    const double fraction = std::frexp(x, &exponent);
    return std::ldexp(std::round(k_steps * fraction) / k_steps, exponent);
}

}  // namespace

bool MeshFaceCutter::joined(VertexId a, VertexId b) {
    if (known_.contains(key(a, b))) return true;
    if (mesh_.face_valence(b) < mesh_.face_valence(a)) std::swap(a, b);  // the shorter walk around a vertex
    const HalfedgeId first = mesh_.vertex_halfedge(a);
    HalfedgeId h = first;
    do {
        if (mesh_.target(h) == b || mesh_.origin(mesh_.prev(h)) == b) {
            known_.insert(key(a, b));
            return true;
        }
        h = mesh_.ccw_outgoing(h);
    } while (h.valid() && h != first);
    return false;
}

void FaceCutter::begin(std::span<const Vec3d> points) {
    points_ = points;
    left_ = static_cast<std::uint32_t>(points.size());
    prev_.resize(left_);
    next_.resize(left_);
    round_.assign(left_, 0);
    normal_ = Vec3d(0.0);
    for (std::uint32_t i = 0; i < left_; ++i) {
        prev_[i] = i == 0 ? left_ - 1 : i - 1;
        next_[i] = i + 1 == left_ ? 0 : i + 1;
        normal_ += glm::cross(points[i] - points[0], points[next_[i]] - points[0]);
    }
    start_ = 0;
    reflex_.clear();
    for (std::uint32_t i = 0; i < left_; ++i)
        if (facing(prev_[i], i, next_[i]) < 0) reflex_.push_back(i);
    test_reflex_ = std::uint64_t{left_} * reflex_.size() <= k_reflex_budget;
    offer_all();
}

void FaceCutter::remove(std::uint32_t place) {
    const std::uint32_t before = prev_[place], after = next_[place];
    next_[before] = after;
    prev_[after] = before;
    ++round_[place];
    start_ = before;
    prev_[place] = next_[place] = place;  // marks it as removed
    --left_;
    if (left_ == 4) {
        offer_all();  // from now on, ears that leave a backward triangle are bad
    } else {
        offer(before);
        offer(after);
    }
}

void FaceCutter::offer_all() {
    ears_.clear();
    std::uint32_t place = start_;
    do {
        offer(place);
        place = next_[place];
    } while (place != start_);
}

void FaceCutter::offer(std::uint32_t tip) {
    const std::uint32_t a = prev_[tip], b = next_[tip];
    bool bad = facing(a, tip, b) <= 0;
    if (left_ == 4) bad = bad || facing(a, b, next_[b]) <= 0;
    if (test_reflex_ && !bad) bad = holds_reflex_corner(a, tip, b);
    const Vec3d diagonal = points_[b] - points_[a];
    ears_.push_back({bad, rounded(glm::dot(diagonal, diagonal)), tip, ++round_[tip]});
    std::push_heap(ears_.begin(), ears_.end(), std::greater<>());
}

bool FaceCutter::holds_reflex_corner(std::uint32_t a, std::uint32_t tip, std::uint32_t b) const {
    return std::ranges::any_of(reflex_, [&](std::uint32_t r) {
        const bool gone = next_[r] == r;
        return !gone && r != a && r != tip && r != b && facing(a, tip, r) >= 0 && facing(tip, b, r) >= 0 &&
               facing(b, a, r) >= 0;
    });
}

double FaceCutter::facing(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    return glm::dot(normal_, glm::cross(points_[b] - points_[a], points_[c] - points_[a]));
}

std::span<const std::uint32_t> FaceCutter::rest() {
    rest_.clear();
    std::uint32_t place = start_;
    do {
        rest_.push_back(place);
        place = next_[place];
    } while (place != start_);
    return rest_;
}

}  // namespace tetrakis::detail
