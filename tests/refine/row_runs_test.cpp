#include "../kit/random_mesh.hpp"

#include "../../refine/uniform/row_runs.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

using namespace tetrakis;

namespace {

/// A row at random, over numbers of its own: as few of them as it reads, so that one more is out of bounds.
struct RandomRun {
    std::vector<double> numbers;
    std::vector<detail::GridTerm> terms;
    std::size_t at = 0;  ///< the first result's place in `numbers`
    std::uint32_t count, stride;

    RandomRun(test::Random& random, std::uint32_t count_, std::uint32_t stride_) : count(count_), stride(stride_) {
        // Offsets of whole points mostly, as the grids' are, to both sides; any number will do.
        std::ptrdiff_t least = 0, most = 0;
        const std::uint32_t term_count = random.below(26);
        for (std::uint32_t t = 0; t < term_count; ++t) {
            std::ptrdiff_t offset = static_cast<std::ptrdiff_t>(random.below(121)) - 60;
            if (random.chance(0.9)) offset *= 3;
            terms.push_back({offset, random.uniform(-1, 1)});
            least = std::min(least, offset);
            most = std::max(most, offset);
        }
        at = static_cast<std::size_t>(-least);
        numbers.resize(at + static_cast<std::size_t>(most) + std::size_t{3} * count);
        // Of all sizes, so that the order of sums shows.
        for (double& n : numbers) n = std::ldexp(random.uniform(-1, 1), static_cast<int>(random.below(40)) - 20);
    }

    std::size_t written() const { return count == 0 ? 0 : std::size_t{3} * (std::size_t{stride} * (count - 1) + 1); }

    /// What a kernel writes; places that it leaves alone stay as they are.
    std::vector<double> run(detail::RowRun kernel, double untouched) const {
        std::vector<double> result(written(), untouched);
        kernel(numbers.data() + at, terms.data(), terms.size(), count, stride, result.data());
        return result;
    }
    /// Term by term, in their order.
    std::vector<double> expected(double untouched) const {
        std::vector<double> result(written(), untouched);
        for (std::size_t i = 0; i < count; ++i)
            for (std::size_t k = 0; k < 3; ++k) {
                double sum = 0;
                for (const detail::GridTerm& term : terms)
                    sum += term.weight *
                           numbers[at + static_cast<std::size_t>(term.offset + static_cast<std::ptrdiff_t>(3 * i + k))];
                result[3 * i * stride + k] = sum;
            }
        return result;
    }
};

bool same_numbers(const std::vector<double>& a, const std::vector<double>& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0);
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("[inv10] runs of rows give the same bytes whatever they are compiled for, the sums term by term") {
    std::vector<detail::RowRun> kernels;
    for (const detail::KernelSet set : {detail::KernelSet::baseline, detail::KernelSet::avx2})
        if (detail::has_kernels(set)) kernels.push_back(detail::row_run(set));
    if (kernels.size() < 2) MESSAGE("no AVX2 here: only one to compare with the sums");
    constexpr double untouched = 12345;
    for (const std::uint64_t seed : test::seeds(3)) {
        CAPTURE(seed);
        test::Random random(seed);
        for (std::uint32_t count = 0; count <= 70; ++count)
            for (const std::uint32_t stride : {1u, 2u, 4u}) {
                CAPTURE(count);
                CAPTURE(stride);
                const RandomRun row(random, count, stride);
                const std::vector<double> expected = row.expected(untouched);
                for (const detail::RowRun kernel : kernels) CHECK(same_numbers(row.run(kernel, untouched), expected));
            }
    }
}

TEST_SUITE_END();
