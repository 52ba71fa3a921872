#include "quadtree_pattern.hpp"

#include <mpi.h>
#include <p4est_bits.h>
#include <p4est_extended.h>
#include <p4est_ghost.h>
#include <p4est_mesh.h>

namespace tetrakis::bench {

namespace {

static_assert(std::int64_t{P4EST_ROOT_LEN} % k_cube_edge == 0);
constexpr std::int64_t k_units = P4EST_ROOT_LEN / k_cube_edge;  // of p4est, in one of ours

struct Asked {
    CubePattern pattern;
    std::vector<SquareFrame> frames;
    std::vector<FramePattern> wanted;  // per tree
};

// Each tree is a face of the cube; its corners are in the order of the Z-curve.
std::vector<SquareFrame> tree_frames(const p4est_connectivity_t& cube) {
    std::vector<SquareFrame> frames;
    for (p4est_topidx_t t = 0; t < cube.num_trees; ++t) {
        const auto corner = [&](int k) {
            const double* p = cube.vertices + 3 * cube.tree_to_vertex[4 * t + k];
            return CubePoint{static_cast<std::int64_t>(p[0]), static_cast<std::int64_t>(p[1]),
                             static_cast<std::int64_t>(p[2])};
        };
        frames.push_back(face_frame(corner(0), corner(1), corner(2)));
    }
    return frames;
}

int wants(p4est_t* forest, p4est_topidx_t tree, p4est_quadrant_t* q) {
    const Asked& asked = *static_cast<const Asked*>(forest->user_pointer);
    return q->level < asked.pattern.level &&
           asked.wanted[static_cast<std::size_t>(tree)].wants(q->x / k_units, q->y / k_units, k_cube_edge >> q->level);
}

double now() { return MPI_Wtime(); }

}  // namespace

P4est::P4est(int* argc, char*** argv) {
    MPI_Init(argc, argv);
    MPI_Comm_size(MPI_COMM_WORLD, &ranks_);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    sc_init(MPI_COMM_WORLD, 0, 0, nullptr, SC_LP_ERROR);
    p4est_init(nullptr, SC_LP_ERROR);
}

P4est::~P4est() {
    sc_finalize();
    MPI_Finalize();
}

QuadtreeRun P4est::run(const CubePattern& pattern, bool neighbours, std::vector<CubeSquare>* leaves) const {
    p4est_connectivity_t* cube = p4est_connectivity_new_cubed();
    Asked asked{pattern, tree_frames(*cube), {}};
    for (const SquareFrame& frame : asked.frames) asked.wanted.push_back(pattern.in(frame));
    MPI_Barrier(MPI_COMM_WORLD);
    const double start = now();
    p4est_t* forest = p4est_new_ext(MPI_COMM_WORLD, cube, 0, 0, 1, 0, nullptr, &asked);
    p4est_refine(forest, 1, wants, nullptr);
    const double refined = now();
    // With several ranks each has to balance about as much; without, nothing moves.
    if (ranks_ > 1) p4est_partition(forest, 0, nullptr);
    p4est_balance(forest, P4EST_CONNECT_FACE, nullptr);
    const double balanced = now();
    p4est_ghost_t* ghost = neighbours ? p4est_ghost_new(forest, P4EST_CONNECT_FACE) : nullptr;
    p4est_mesh_t* mesh = neighbours ? p4est_mesh_new(forest, ghost, P4EST_CONNECT_FACE) : nullptr;
    double seconds[3] = {refined - start, balanced - refined, now() - balanced}, slowest[3];
    MPI_Allreduce(seconds, slowest, 3, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
    if (leaves != nullptr)
        for (p4est_topidx_t t = forest->first_local_tree; t <= forest->last_local_tree; ++t) {
            p4est_tree_t* tree = p4est_tree_array_index(forest->trees, t);
            for (std::size_t i = 0; i < tree->quadrants.elem_count; ++i) {
                const p4est_quadrant_t* q = p4est_quadrant_array_index(&tree->quadrants, i);
                const std::int64_t half = k_cube_edge >> q->level >> 1;
                leaves->push_back(
                    {asked.frames[static_cast<std::size_t>(t)].at(q->x / k_units + half, q->y / k_units + half),
                     q->level});
            }
        }
    const QuadtreeRun run{slowest[0], slowest[1], slowest[2], forest->global_num_quadrants};
    if (neighbours) {
        p4est_mesh_destroy(mesh);
        p4est_ghost_destroy(ghost);
    }
    p4est_destroy(forest);
    p4est_connectivity_destroy(cube);
    return run;
}

}  // namespace tetrakis::bench
