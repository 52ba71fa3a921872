#pragma once

#include "scheme_info.hpp"

#include <cstddef>
#include <iterator>
#include <span>
#include <string_view>

namespace tetrakis {

/// The schemes, as a range of `const SchemeInfo&` in the order of the table.
class SchemeTable {
  public:
    class Iterator {
      public:
        using iterator_category = std::forward_iterator_tag;
        using value_type = SchemeInfo;
        using difference_type = std::ptrdiff_t;
        using pointer = const SchemeInfo*;
        using reference = const SchemeInfo&;

        Iterator() = default;
        explicit Iterator(const SchemeInfo* const* at) : at_(at) {}
        reference operator*() const { return **at_; }
        pointer operator->() const { return *at_; }
        Iterator& operator++() { return ++at_, *this; }
        Iterator operator++(int) { return Iterator(at_++); }
        friend bool operator==(Iterator, Iterator) = default;

      private:
        const SchemeInfo* const* at_ = nullptr;
    };

    explicit SchemeTable(std::span<const SchemeInfo* const> schemes) : schemes_(schemes) {}
    Iterator begin() const { return Iterator(schemes_.data()); }
    Iterator end() const { return Iterator(schemes_.data() + schemes_.size()); }
    std::size_t size() const { return schemes_.size(); }

  private:
    std::span<const SchemeInfo* const> schemes_;
};

/// All of them; also before main().
SchemeTable scheme_table();
/// The scheme of that name; nullptr for an unknown one.
const SchemeInfo* find_scheme(std::string_view name);
/// The name in the table that has the text in it, or else is, itself or its start, the fewest edits away.
std::string_view nearest_scheme_name(std::string_view name);

std::string_view name(Refinement refinement);
std::string_view name(MeshFamily family);

/// The number of edges at a regular vertex, or of corners of a regular face in a dual scheme.
int regular_valence(const SchemeInfo& scheme, bool boundary);
/// Dual or primal, and how far its rules reach: only repeated averaging depends on its options.
FanLattice fan_lattice(const SchemeInfo& scheme, const RuleOptions& options);
/// The same around one point: a dual scheme's corner is a vertex, and so is a boundary of hexagons.
FanLattice fan_lattice(const SchemeInfo& scheme, const FanShape& shape, const RuleOptions& options);
int fan_rings(const SchemeInfo& scheme, const FanShape& shape, const RuleOptions& options);
/// Averaging steps of repeated averaging and of the biquartic scheme, which is three of them; others have none.
int averaging_steps(const SchemeInfo& scheme, const RuleOptions& options);
/// SchemeInfo::rule_rings with the chosen averaging steps.
int rule_rings(const SchemeInfo& scheme, const RuleOptions& options);
/// Whether each step uses up the outer ring of an open mesh (AveragingBoundary).
bool boundary_recedes(const SchemeInfo& scheme, const RuleOptions& options);
/// Whether tags inside a mesh have no effect: longer averages, unless they have Catmull-Clark's rules.
bool ignores_creases(const SchemeInfo& scheme, const RuleOptions& options);

}  // namespace tetrakis
