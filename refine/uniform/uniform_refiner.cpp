#include "uniform_refiner.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/parallel.hpp"
#include "../rules/check_length.hpp"
#include "../rules/corner_angles.hpp"
#include "grid_limit.hpp"
#include "grid_refinement.hpp"
#include "uniform_cost.hpp"

#include <algorithm>
#include <string>

namespace tetrakis {

using detail::check_length;

template <class T>
struct UniformRefiner<T>::State {
    State(const ControlMesh& control, SchemeKind scheme, int levels, const UniformOptions& uniform_options)
        : mesh(control),
          options(uniform_options),
          topology(control, scheme, levels,
                   uniform_options.linear ? detail::PointRule::linear : detail::PointRule::scheme,
                   uniform_options.factored ? detail::RootPlace::corners : detail::RootPlace::faces),
          points(topology, uniform_options.factored && !uniform_options.linear ? detail::LevelSteps::half
                                                                               : detail::LevelSteps::whole) {
        if (options.linear) options.limit = options.normals = false;
    }

    /// The last level's control points, in `out` or in a buffer of ours.
    const T* net(std::span<const Vec3<T>> control, T* out) { return points.run(control, out, options.context); }

    const ControlMesh& mesh;
    UniformOptions options;
    detail::GridTopology topology;
    detail::GridPoints<T> points;
    detail::HugeBuffer<T> positions, normals;  // limits
    detail::HugeBuffer<std::uint32_t> faces;
    bool has_faces = false;
};

template <class T>
UniformRefiner<T>::UniformRefiner(const ControlMesh& mesh, SchemeKind scheme, int levels,
                                  const UniformOptions& options) {
    if (!options.linear) detail::refuse_corner_angles(mesh);
    if (options.factored && scheme != SchemeKind::catmull_clark)
        throw Error(ErrorCode::invalid_input, "Loop has no factored form; leave it out, or take Catmull-Clark",
                    mesh.data().source);
    const detail::UniformCost cost = detail::uniform_cost(
        mesh, {scheme, levels, static_cast<int>(sizeof(T)), options.limit, options.normals, false});
    if (levels == 0 && scheme == SchemeKind::catmull_clark && !detail::all_quads(mesh))
        throw Error(ErrorCode::invalid_input, "faces that are no quads need at least one level", mesh.data().source);
    detail::check_memory(mesh, levels, cost, options.context);
    with_threads(options.context, [&] { state_ = std::make_unique<State>(mesh, scheme, levels, options); });
}

template <class T>
UniformRefiner<T>::~UniformRefiner() = default;
template <class T>
UniformRefiner<T>::UniformRefiner(UniformRefiner&&) noexcept = default;
template <class T>
UniformRefiner<T>& UniformRefiner<T>::operator=(UniformRefiner&&) noexcept = default;

template <class T>
std::uint32_t UniformRefiner<T>::vertex_count() const {
    return state_->topology.last().vertex_count();
}

template <class T>
std::uint32_t UniformRefiner<T>::face_count() const {
    return static_cast<std::uint32_t>(state_->topology.last().cell_count());
}

template <class T>
int UniformRefiner<T>::face_size() const {
    return state_->topology.last().quads() ? 4 : 3;
}

template <class T>
std::uint32_t UniformRefiner<T>::control_face(std::uint32_t face) const {
    const std::uint32_t root = state_->topology.last().face_of_cell(face);
    return state_->topology.base_level == 0 ? root : state_->mesh.face(HalfedgeId(root)).value;
}

template <class T>
void UniformRefiner<T>::refine(std::span<const Vec3<T>> control, std::span<Vec3<T>> positions,
                               std::span<Vec3<T>> normals) {
    State& s = *state_;
    check_length("control positions", control.size(), s.mesh.vertex_count());
    check_length("positions to write", positions.size(), vertex_count());
    if (!normals.empty()) check_length("normals to write", normals.size(), s.options.linear ? 0 : vertex_count());
    with_threads(s.options.context, [&] {
        T* out = positions.empty() ? nullptr : &positions.data()->x;
        if (!s.options.limit && normals.empty()) {
            s.net(control, out);
            return;
        }
        const T* net = s.net(control, nullptr);
        detail::grid_limits(s.topology, net, s.options.limit ? out : nullptr,
                            normals.empty() ? nullptr : &normals.data()->x, s.options.context);
        if (!s.options.limit) std::copy_n(net, 3 * positions.size(), out);
    });
}

template <class T>
UniformLevel<T> UniformRefiner<T>::refine(std::span<const Vec3<T>> control) {
    State& s = *state_;
    check_length("control positions", control.size(), s.mesh.vertex_count());
    const std::size_t count = vertex_count(),
                      corners = std::size_t{face_count()} * static_cast<std::size_t>(face_size());
    if (!s.has_faces) {
        faces({s.faces.reserve(corners), corners});
        s.has_faces = true;
    }
    const T* positions = nullptr;
    T* normals = s.options.normals ? s.normals.reserve(3 * count) : nullptr;
    with_threads(s.options.context, [&] {
        positions = s.net(control, nullptr);
        if (!s.options.limit && normals == nullptr) return;
        T* limits = s.options.limit ? s.positions.reserve(3 * count) : nullptr;
        detail::grid_limits(s.topology, positions, limits, normals, s.options.context);
        if (limits != nullptr) positions = limits;
    });
    const auto points = [&](const T* scalars) {
        return std::span(reinterpret_cast<const Vec3<T>*>(scalars), scalars == nullptr ? 0 : count);
    };
    return {points(positions), points(normals), {s.faces.data(), corners}};
}

template <class T>
void UniformRefiner<T>::faces(std::span<std::uint32_t> corners) const {
    check_length("face corners to write", corners.size(),
                 static_cast<std::size_t>(face_count()) * static_cast<std::size_t>(face_size()));
    with_threads(state_->options.context,
                 [&] { detail::write_faces(state_->topology.last(), corners, state_->options.context); });
}

template class UniformRefiner<float>;
template class UniformRefiner<double>;

}  // namespace tetrakis
