#include "mesh_links.hpp"

#include "../base/ids.hpp"
#include "../base/parallel.hpp"

#include <oneapi/tbb/parallel_invoke.h>

#include <algorithm>
#include <atomic>

namespace tetrakis::detail {

namespace {

// Faces per block of the first pass: enough to hide the histogram, few enough to feed many threads.
constexpr std::uint32_t k_face_block = 16384;
// Most buckets of the first pass: the write heads of one block stay in the second-level cache.
constexpr std::uint32_t k_max_buckets = 1024;
// Below this many edges at a vertex insertion sort wins over std::sort.
constexpr std::uint32_t k_small_group = 24;

// By the larger vertex, then by half-edge, as which they come.
void sort_group(EdgeUse* first, EdgeUse* last) {
    if (last - first > k_small_group) {
        std::sort(first, last, [](const EdgeUse& a, const EdgeUse& b) {
            return a.high != b.high ? a.high < b.high : a.halfedge < b.halfedge;
        });
        return;
    }
    if (first == last) return;
    for (EdgeUse* i = first + 1; i < last; ++i) {
        const EdgeUse use = *i;
        EdgeUse* j = i;
        for (; j > first && use.high < j[-1].high; --j) *j = j[-1];
        *j = use;
    }
}

// Sorts buckets one after the other in the same memory.
class BucketSorter {
  public:
    /// @param bucket  its smaller vertices all lie in [base, base + width)
    void run(std::span<EdgeUse> bucket, std::uint32_t base, std::uint32_t width) {
        if (width == 1) return sort_group(bucket.data(), bucket.data() + bucket.size());
        start_.assign(std::size_t{width} + 1, 0);
        for (const EdgeUse& use : bucket) ++start_[use.low - base + 1];
        for (std::uint32_t i = 0; i < width; ++i) start_[i + 1] += start_[i];
        uses_.assign(bucket.begin(), bucket.end());
        for (const EdgeUse& use : uses_) bucket[start_[use.low - base]++] = use;
        // Each start is now the end of its group.
        for (std::uint32_t i = 0, begin = 0; i < width; begin = start_[i++])
            sort_group(bucket.data() + begin, bucket.data() + start_[i]);
    }

  private:
    std::vector<std::uint32_t> start_;
    std::vector<EdgeUse> uses_;
};

}  // namespace

std::vector<EdgeUse> sorted_edge_uses(std::span<const std::uint32_t> face_offsets,
                                      std::span<const std::uint32_t> face_vertices, std::uint32_t vertex_count) {
    const auto face_count = static_cast<std::uint32_t>(face_offsets.empty() ? 0 : face_offsets.size() - 1);
    if (face_count == 0 || vertex_count == 0) return {};
    int shift = 0;
    while ((vertex_count - 1) >> shift >= k_max_buckets) ++shift;
    const std::uint32_t bucket_count = ((vertex_count - 1) >> shift) + 1;
    const std::uint32_t block_count = (face_count - 1) / k_face_block + 1;

    const auto visit_block = [&](std::uint32_t block, auto&& visit) {
        const std::uint32_t last_face = std::min(face_count, (block + 1) * k_face_block);
        for (std::uint32_t f = block * k_face_block; f < last_face; ++f) {
            const std::uint32_t first = face_offsets[f], end = face_offsets[f + 1];
            const std::uint32_t around = face_vertices[first];
            std::uint32_t a = around;
            for (std::uint32_t h = first; h + 1 < end; ++h) {
                const std::uint32_t b = face_vertices[h + 1];
                visit(std::min(a, b), std::max(a, b), h);
                a = b;
            }
            visit(std::min(a, around), std::max(a, around), end - 1);
        }
    };

    std::vector<std::size_t> head(std::size_t{block_count} * bucket_count, 0);
    for_each_index(
        block_count,
        [&](std::uint32_t block) {
            std::size_t* count = head.data() + std::size_t{block} * bucket_count;
            visit_block(block, [&](std::uint32_t low, std::uint32_t, std::uint32_t) { ++count[low >> shift]; });
        },
        1);
    std::vector<std::size_t> bucket_start(std::size_t{bucket_count} + 1);
    std::size_t sum = 0;
    for (std::uint32_t bucket = 0; bucket < bucket_count; ++bucket) {
        bucket_start[bucket] = sum;
        for (std::uint32_t block = 0; block < block_count; ++block) {
            std::size_t& slot = head[std::size_t{block} * bucket_count + bucket];
            const std::size_t count = slot;
            slot = sum;
            sum += count;
        }
    }
    bucket_start[bucket_count] = sum;

    std::vector<EdgeUse> uses(sum);
    for_each_index(
        block_count,
        [&](std::uint32_t block) {
            std::size_t* slot = head.data() + std::size_t{block} * bucket_count;
            visit_block(block, [&](std::uint32_t low, std::uint32_t high, std::uint32_t h) {
                uses[slot[low >> shift]++] = {low, high, h};
            });
        },
        1);
    const std::uint32_t grain =
        std::max<std::uint32_t>(1, bucket_count * k_default_grain / std::max(sum, std::size_t{1}));
    for_each_block(bucket_count, grain, [&](std::uint32_t begin, std::uint32_t end) {
        BucketSorter sorter;
        for (std::uint32_t bucket = begin; bucket < end; ++bucket) {
            const std::uint32_t base = bucket << shift;
            sorter.run(std::span(uses).subspan(bucket_start[bucket], bucket_start[bucket + 1] - bucket_start[bucket]),
                       base, std::min(std::uint32_t{1} << shift, vertex_count - base));
        }
    });
    return uses;
}

const EdgeUse* find_edge(std::span<const EdgeUse> sorted_uses, std::uint32_t a, std::uint32_t b) {
    const std::uint32_t low = std::min(a, b), high = std::max(a, b);
    const auto it = std::lower_bound(sorted_uses.begin(), sorted_uses.end(), EdgeUse{low, high, 0},
                                     [](const EdgeUse& x, const EdgeUse& y) {
                                         if (x.low != y.low) return x.low < y.low;
                                         return x.high != y.high ? x.high < y.high : x.halfedge < y.halfedge;
                                     });
    return it != sorted_uses.end() && it->low == low && it->high == high ? &*it : nullptr;
}

namespace {

constexpr std::uint32_t k_no_face = HalfedgeId::none;
// Half-edges above which two loops over them are worth a second thread.
constexpr std::uint32_t k_parallel_starts = 16384;

// Twins of the edges whose first use is in [begin, end). Whether all of them are manifold.
bool link_uses(const ControlMeshData& data, std::span<const EdgeUse> uses, std::uint32_t begin, std::uint32_t end,
               std::span<std::uint32_t> twin) {
    const auto count = static_cast<std::uint32_t>(uses.size());
    while (begin != 0 && begin < end && uses[begin].same_edge(uses[begin - 1])) ++begin;
    bool manifold = true;
    for (std::uint32_t i = begin, next; i < end; i = next) {
        const EdgeUse& use = uses[i];
        next = i + 1;
        while (next < count && use.same_edge(uses[next])) ++next;
        if (next == i + 2) {
            const std::uint32_t other = uses[i + 1].halfedge;
            twin[use.halfedge] = other;
            twin[other] = use.halfedge;
            manifold &= data.face_vertices[use.halfedge] != data.face_vertices[other];
        } else {
            for (std::uint32_t j = i; j != next; ++j) twin[uses[j].halfedge] = k_no_face;
            manifold &= next == i + 1;
        }
    }
    return manifold;
}

}  // namespace

MeshLinks link_mesh(const ControlMeshData& data, std::span<const EdgeUse> sorted_uses) {
    const auto face_count = static_cast<std::uint32_t>(data.face_offsets.size() - 1);
    const auto use_count = static_cast<std::uint32_t>(sorted_uses.size());
    MeshLinks links;
    links.face.resize(use_count);
    links.twin.resize(use_count);
    for_each_index(face_count, [&](std::uint32_t f) {
        for (std::uint32_t h = data.face_offsets[f]; h < data.face_offsets[f + 1]; ++h) links.face[h] = f;
    });
    std::atomic<bool> manifold = true;
    for_each_block(use_count, k_default_grain, [&](std::uint32_t begin, std::uint32_t end) {
        if (!link_uses(data, sorted_uses, begin, end, links.twin)) manifold.store(false, std::memory_order_relaxed);
    });
    links.manifold_edges = manifold.load(std::memory_order_relaxed);
    links.vertex_halfedge.assign(data.positions.size(), k_no_face);
    links.vertex_face_count.assign(data.positions.size(), 0);
    const auto count_faces = [&] {
        for (std::uint32_t v : data.face_vertices) ++links.vertex_face_count[v];
    };
    const auto find_starts = [&] {
        for (std::uint32_t h = 0; h < use_count; ++h) {
            std::uint32_t& start = links.vertex_halfedge[data.face_vertices[h]];
            start = start == k_no_face || links.twin[h] == k_no_face ? h : start;
        }
    };
    if (use_count > k_parallel_starts) {
        oneapi::tbb::parallel_invoke(count_faces, find_starts);
    } else {
        count_faces();
        find_starts();
    }
    return links;
}

std::uint32_t fan_size(const ControlMeshData& data, const MeshLinks& links, std::uint32_t vertex) {
    const std::uint32_t start = links.vertex_halfedge[vertex];
    if (start == k_no_face) return 0;
    std::uint32_t size = 0, h = start;
    do {
        ++size;
        const std::uint32_t f = links.face[h];
        h = links.twin[h == data.face_offsets[f] ? data.face_offsets[f + 1] - 1 : h - 1];
    } while (h != start && h != k_no_face);
    return size;
}

}  // namespace tetrakis::detail
