#include "edge_uses.hpp"

#include "../base/parallel.hpp"

#include <algorithm>

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

}  // namespace tetrakis::detail
