#pragma once

#include "tetrakis/hier/vec.hpp"
#include "tetrakis/refine/root_net.hpp"
#include "tetrakis/schemes/stencil_table.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// Rows of weights that repeat themselves from level to level: the same inside every root of a net; along each side;
/// around each corner, at the same places counted from there. Learned on one level, they are read again on finer ones,
/// at places found by arithmetic.
class RowPatterns {
  public:
    enum class Kind {
        points,  ///< a row per point: the point
        normals  ///< pairs of rows, tangents t1 and t2 of each surface that meets there: the mean of their unit normals
    };
    /// @param net     must live as long
    /// @param factor  segments of the level of the results to one of the level of the points; 1: the same level
    RowPatterns(const RootNet& net, std::uint32_t factor, Kind kind) : net_(net), factor_(factor), kind_(kind) {}

    /// Places in a layout of the rules' vertices.
    struct Places {
        std::vector<int> first;  ///< of each vertex
        std::vector<int> next;   ///< of each place the vertex's next one, or -1

        explicit Places(std::span<const int> vertices);
        bool several(int vertex) const { return next[first[vertex]] >= 0; }
    };
    /// What the rules say of a level.
    struct Lesson {
        RootLayout coarse, fine;           ///< of the points; of the results
        const Places& places;              ///< of the points
        std::span<const int> fine_vertex;  ///< at the results' places
        const StencilTable& rows;          ///< points: one for each fine vertex; normals: of tangents t1
        // Normals only: the tangents of fine vertex v are rows [begin[v], begin[v + 1]).
        const StencilTable* second_rows = nullptr;  ///< of tangents t2
        std::span<const int> begin{};
    };
    /// False where the rows do not repeat, or lattices are too small to see whether they do.
    bool learn(const Lesson& lesson);

    /// Results at a level's places from the points of the one above, or of the same one: unit normals are zero where
    /// there are no rows; at places of the same point (RootNet::point_numbers) each is of its own side of a crease. The
    /// same bytes for any number of threads.
    void apply(const RootLayout& coarse, const RootLayout& fine, const Vec3d* in, Vec3d* out) const;

  private:
    static constexpr std::uint32_t none = RootNet::none;
    using Place = RootNet::Place;
    using Seen = RootNet::Seen;
    struct Term {
        Seen at;
        double weight;
    };
    using Row = std::vector<Term>;
    /// Rows of a number of places, rows_per_point() each.
    using Pattern = std::vector<Row>;
    struct PatternOrder;
    /// At most two surfaces with tangents meet.
    std::uint32_t rows_per_point() const { return kind_ == Kind::points ? 1 : 4; }
    std::uint32_t rows_inside() const { return kind_ == Kind::points ? 1 : 2; }

    bool learn_inside(const Lesson& lesson);
    template <class SeenAt>
    bool rows_of(const Lesson& lesson, int fine_vertex, const SeenAt& seen_at, std::span<Row> out) const;
    bool corner_rows(const Lesson& lesson, std::uint32_t h, Pattern& out) const;
    bool side_rows(const Lesson& lesson, std::uint32_t h, Pattern& out) const;

    struct Work;
    template <class Finish>
    void apply(const RootLayout& coarse, const RootLayout& fine, const Vec3d* in, Vec3d* out) const;
    template <class Finish>
    void inside(const RootLayout& coarse, const RootLayout& fine, std::uint32_t f, Vec3d* out, const Work& work) const;
    template <class Finish>
    void side(const RootLayout& coarse, const RootLayout& fine, std::uint32_t h, const Vec3d* in, Vec3d* out,
              Work& work) const;
    template <class Finish>
    void corner(const RootLayout& coarse, const RootLayout& fine, std::uint32_t h, const Vec3d* in, Vec3d* out) const;

    const RootNet& net_;
    std::uint32_t factor_;
    Kind kind_;
    std::ptrdiff_t template_segments_ = 0;  ///< of the points' level
    std::uint32_t depth_ = 0;               ///< points that far from all sides go by the rows inside
    std::uint32_t reach_ = 0;               ///< from a corner along a side: points nearer than that are its
    /// By the place modulo the factor: y, then x, then the row. Points are seen from where the result lies.
    std::vector<Row> inside_;
    std::vector<Place> corner_places_;
    std::vector<Pattern> corner_patterns_, side_patterns_;
    std::vector<std::uint32_t> corner_pattern_, side_pattern_;  ///< of each half-edge
};

}  // namespace tetrakis::detail
