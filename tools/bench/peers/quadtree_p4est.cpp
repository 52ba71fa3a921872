#include "quadtree_peers.hpp"

#include <mpi.h>
#include <p4est_bits.h>
#include <p4est_extended.h>
#include <p4est_ghost.h>
#include <p4est_mesh.h>

namespace tetrakis::bench {

namespace {

int is_coarser(p4est_t* forest, p4est_topidx_t, p4est_quadrant_t* q) {
    return q->level < *static_cast<const int*>(forest->user_pointer);
}

/// MPI session, from the first use to the end of the program.
struct Session {
    Session() {
        MPI_Init(nullptr, nullptr);
        sc_init(MPI_COMM_WORLD, 0, 0, nullptr, SC_LP_ERROR);
        p4est_init(nullptr, SC_LP_ERROR);
    }
    ~Session() {
        sc_finalize();
        MPI_Finalize();
    }
};

void start_session() { static const Session session; }

}  // namespace

QuadtreeRun run_p4est(int level, bool neighbours) {
    start_session();
    p4est_connectivity_t* cube = p4est_connectivity_new_cubed();
    const double start = MPI_Wtime();
    p4est_t* forest = p4est_new_ext(MPI_COMM_WORLD, cube, 0, 0, 1, 0, nullptr, &level);
    p4est_refine(forest, 1, is_coarser, nullptr);
    p4est_balance(forest, P4EST_CONNECT_FACE, nullptr);
    p4est_ghost_t* ghost = neighbours ? p4est_ghost_new(forest, P4EST_CONNECT_FACE) : nullptr;
    p4est_mesh_t* mesh = neighbours ? p4est_mesh_new(forest, ghost, P4EST_CONNECT_FACE) : nullptr;
    const QuadtreeRun run{MPI_Wtime() - start, forest->global_num_quadrants};
    if (neighbours) {
        p4est_mesh_destroy(mesh);
        p4est_ghost_destroy(ghost);
    }
    p4est_destroy(forest);
    p4est_connectivity_destroy(cube);
    return run;
}

namespace {

class MovingTargetP4est final : public MovingTargetPeer {
  public:
    MovingTargetP4est()
        : square_(p4est_connectivity_new_unitsquare()),
          forest_(p4est_new_ext(MPI_COMM_WORLD, square_, 0, 0, 1, 0, nullptr, this)) {}
    ~MovingTargetP4est() override {
        p4est_destroy(forest_);
        p4est_connectivity_destroy(square_);
    }
    std::int64_t move(const TargetPoint& target) override {
        target_ = target;
        families_ = 0;
        const int recursive = forest_->global_num_quadrants == 1;
        p4est_coarsen(forest_, 0, merges, nullptr);
        p4est_refine(forest_, recursive, splits, nullptr);
        const std::int64_t wanted = forest_->global_num_quadrants;
        p4est_balance(forest_, P4EST_CONNECT_FACE, nullptr);
        p4est_partition(forest_, 0, nullptr);
        return families_ + (forest_->global_num_quadrants - wanted) / 3;
    }
    std::int64_t leaf_count() const override { return forest_->global_num_quadrants; }
    bool is_balanced() const override { return p4est_is_balanced(forest_, P4EST_CONNECT_FACE) != 0; }

  private:
    /// Whether the quadrant's side is larger than k_size times the distance of its centre from the target.
    bool wants(const p4est_quadrant_t& q) const {
        constexpr double k_size = 0.0059;  // gives a million squares
        if (q.level >= k_finest_level) return false;
        const double side = P4EST_QUADRANT_LEN(q.level), x = q.x + side / 2 - P4EST_ROOT_LEN * target_.x,
                     y = q.y + side / 2 - P4EST_ROOT_LEN * target_.y;
        return side * side > k_size * k_size * (x * x + y * y);
    }
    bool count(bool change) {
        families_ += change;
        return change;
    }
    static int splits(p4est_t* forest, p4est_topidx_t, p4est_quadrant_t* q) {
        auto& self = *static_cast<MovingTargetP4est*>(forest->user_pointer);
        return self.count(self.wants(*q));
    }
    static int merges(p4est_t* forest, p4est_topidx_t, p4est_quadrant_t* family[]) {
        auto& self = *static_cast<MovingTargetP4est*>(forest->user_pointer);
        p4est_quadrant_t parent;
        p4est_quadrant_parent(family[0], &parent);
        return self.count(!self.wants(parent));
    }

    p4est_connectivity_t* square_;
    p4est_t* forest_;
    TargetPoint target_;
    std::int64_t families_ = 0;
};

}  // namespace

std::unique_ptr<MovingTargetPeer> make_p4est_target() {
    start_session();
    return std::make_unique<MovingTargetP4est>();
}

}  // namespace tetrakis::bench
