#pragma once

#include "block_runner.hpp"
#include "short_list.hpp"

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace tetrakis {

/// A linear combination of points, while it is put together.
struct StencilRow {
    ShortList<std::pair<int, double>, 32> terms;

    StencilRow() = default;
    StencilRow(std::initializer_list<std::pair<int, double>> t) : terms(t) {}
    void add(int point, double weight) { terms.emplace_back(point, weight); }
    void add(const StencilRow& row, double weight) {
        for (const auto& [point, w] : row.terms) add(point, weight * w);
    }
    /// Puts points in increasing order, each once: its weights are summed in the order in which they were added, and it
    /// is left out where that gives 0.
    void gather() {
        // Most rows are short: sums of a few rows that are already in order.
        constexpr std::size_t k_short = 64;
        auto& t = terms;
        const auto less = [](const auto& a, const auto& b) { return a.first < b.first; };
        if (t.size() > k_short) {
            const auto [low, high] = std::minmax_element(t.begin(), t.end(), less);
            const int first = low->first, count = high->first - first + 1;
            if (t.size() > static_cast<std::size_t>(count)) return sum_all(first, count);
            std::stable_sort(t.begin(), t.end(), less);
        }
        auto *const begin = t.begin(), *end = begin;
        for (const auto* from = begin; from != t.end(); ++from) {
            const auto term = *from;
            auto* at = end;
            while (at != begin && less(term, at[-1])) --at;
            if (at != begin && at[-1].first == term.first) {
                at[-1].second += term.second;
                continue;
            }
            std::move_backward(at, end, end + 1);
            ++end;
            *at = term;
        }
        end = std::remove_if(begin, end, [](const auto& term) { return term.second == 0; });
        t.shorten(static_cast<std::size_t>(end - begin));
    }

  private:
    /// gather() for more terms than there are point numbers from the first to the last. Rows at vertices of many edges
    /// have the whole ring several times; sorting them would take most of the time.
    void sum_all(int first, int count) {
        std::vector<double> sums(static_cast<std::size_t>(count), 0.0);
        for (const auto& [point, weight] : terms) sums[static_cast<std::size_t>(point - first)] += weight;
        terms.clear();
        for (int i = 0; i < count; ++i)
            if (sums[static_cast<std::size_t>(i)] != 0) add(first + i, sums[static_cast<std::size_t>(i)]);
    }
};

/// Rows of a sparse matrix: new points from old ones. Points within a row are in increasing order, each once.
class StencilTable {
  public:
    int row_count() const { return static_cast<int>(begin_.size()) - 1; }
    std::span<const int> points(int row) const { return {points_.data() + begin_[row], size(row)}; }
    std::span<const double> weights(int row) const { return {weights_.data() + begin_[row], size(row)}; }
    /// The whole table in compressed rows (CSR): row r is from begins()[r] to begins()[r + 1] in the other two.
    std::span<const std::size_t> begins() const { return begin_; }
    std::span<const int> points() const { return points_; }
    std::span<const double> weights() const { return weights_; }

    /// Appends a row, gathered.
    void push(StencilRow row) {
        row.gather();
        for (const auto& [point, weight] : row.terms) {
            points_.push_back(point);
            weights_.push_back(weight);
        }
        begin_.push_back(points_.size());
    }
    /// Appends row(i) for i in [0, count).
    template <class Row>
    void push_rows(const BlockRunner* runner, int count, Row&& row) {
        constexpr int k_rows = detail::k_rows_per_block;
        if (runner == nullptr || count <= k_rows || !runner->is_parallel()) {
            begin_.reserve(begin_.size() + static_cast<std::size_t>(count));
            const std::size_t before = points_.size();
            for (int i = 0; i < count; ++i) {
                push(row(i));
                if (i != k_rows) continue;
                // Assumes that the other rows are about as long as these.
                const std::size_t each = (points_.size() - before) * 9 / 8;
                const std::size_t all = before + each * static_cast<std::size_t>(count) / k_rows;
                points_.reserve(all);
                weights_.reserve(all);
            }
            return;
        }
        std::vector<StencilTable> parts((count + k_rows - 1) / k_rows);
        runner->run(static_cast<int>(parts.size()), [&](int b) {
            for (int i = b * k_rows; i < std::min(count, (b + 1) * k_rows); ++i) parts[b].push(row(i));
        });
        std::size_t terms = points_.size(), rows = begin_.size();
        for (const StencilTable& part : parts) {
            terms += part.points_.size();
            rows += part.begin_.size() - 1;
        }
        begin_.reserve(rows);
        points_.reserve(terms);
        weights_.reserve(terms);
        for (StencilTable& part : parts) {
            const std::size_t before = points_.size();
            for (std::size_t i = 1; i < part.begin_.size(); ++i) begin_.push_back(before + part.begin_[i]);
            points_.insert(points_.end(), part.points_.begin(), part.points_.end());
            weights_.insert(weights_.end(), part.weights_.begin(), part.weights_.end());
            part = StencilTable();
        }
    }
    StencilRow row(int r) const {
        StencilRow result;
        for (std::size_t i = begin_[r]; i < begin_[r + 1]; ++i) result.add(points_[i], weights_[i]);
        return result;
    }
    /// Adds a row times a weight to another.
    void add_row(int r, double weight, StencilRow& to) const {
        for (std::size_t i = begin_[r]; i < begin_[r + 1]; ++i) to.add(points_[i], weight * weights_[i]);
    }
    /// Both steps in one table: `this` goes from coarse to middle points, `fine` from middle to fine points.
    StencilTable then(const StencilTable& fine, const BlockRunner* runner = nullptr) const {
        StencilTable result;
        result.push_rows(runner, fine.row_count(), [&](int r) {
            StencilRow sum;
            for (std::size_t i = fine.begin_[r]; i < fine.begin_[r + 1]; ++i)
                add_row(fine.points_[i], fine.weights_[i], sum);
            return sum;
        });
        return result;
    }
    /// out[r] = sum of weight times `in`; T has + and multiplication by double on the left. A row without terms gives
    /// T().
    template <class T>
    void apply(std::span<const T> in, std::span<T> out) const {
        for (int r = 0; r < row_count(); ++r) {
            T sum{};
            for (std::size_t i = begin_[r]; i < begin_[r + 1]; ++i) sum = sum + weights_[i] * in[points_[i]];
            out[r] = sum;
        }
    }

    friend bool operator==(const StencilTable&, const StencilTable&) = default;

  private:
    std::size_t size(int row) const { return begin_[row + 1] - begin_[row]; }

    std::vector<std::size_t> begin_{0};
    std::vector<int> points_;
    std::vector<double> weights_;
};

}  // namespace tetrakis
