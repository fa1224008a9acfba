// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The neighbourhoods of free vertices, coloured and laid out for the vertex-block method. Vertices
/// go by their places here, see SolverData.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/base/undo_array.h"
#include "pbdsurg/coloring/color.h"
#include "pbdsurg/solver/solver_options.h"

#include "lib/base/list_pool.h"
#include "lib/coloring/local_walk.h"
#include "lib/solver/methods/fixed_point.h"
#include "lib/solver/methods/vertex_rows.h"
#include "lib/solver/methods/vertex_strip.h"
#include "lib/solver/state/particle.h"

namespace pbdsurg {

/// What a tetrahedron adds to the energy of its vertices.
struct VertexTet {
  Tet vertices{};
  std::array<float, 6> weights{};       ///< N/m, of the pulls along kTetEdges; zero for none
  float stiffness = 0;                  ///< N/m^5, >= 0, of the volume
  float target = 0;                     ///< m^3
  std::array<float, 6> edge_damping{};  ///< N s/m, >= 0, along kTetEdges
  float volume_damping = 0;             ///< N s/m^5, >= 0
  std::array<float, 3> fibre_shares{};  ///< 1/m, FibreConstraint::kShares
  float fibre_stiffness = 0;            ///< N m, >= 0; zero for none
};

/// What an edge or a link adds.
struct VertexSpring {
  Edge vertices{};
  float stiffness = 0;        ///< N/m, >= 0
  float rest = 0;             ///< m
  float damping = 0;          ///< N s/m, >= 0
  float limit_stiffness = 0;  ///< N/m, >= 0, of what pulls it where it is longer than
  float limit = 0;            ///< m, > 0 with a stiffness
};

/// What a triangle of a sheet adds.
struct VertexTriangle {
  Triangle vertices{};
  std::array<float, 3> weights{};       ///< N/m, of the pulls along the edges opposite these
  float stiffness = 0;                  ///< N/m^3, >= 0, of the area; zero for none
  float target = 0;                     ///< m^2
  std::array<float, 3> edge_damping{};  ///< N s/m, >= 0, along the edges
  float area_damping = 0;               ///< N s/m^3, >= 0
};

/// What a hinge adds.
struct VertexHinge {
  std::array<Index, 4> vertices{};
  std::array<float, 6> weights{};  ///< N/m, SheetHinge::weights; zero for none
  float moment = 0;                ///< N/m^2, SheetHinge::moment
  float stiffness = 0;             ///< N m, >= 0, of the angle; zero for none
  float rest = 0;                  ///< BendingConstraint::kRest
  float damping = 0;               ///< N m s, >= 0, of the angle
};

/// Free vertices in colours: no tetrahedron, triangle, spring or hinge that acts joins two of one
/// colour, unless all move at once.
///
/// What edits bring finds its place without the rest: a new vertex gets the first colour that its
/// neighbours leave it, or one by a walk that moves some of them to other colours (local_walk.h),
/// and opens one only where that fails; a colour that few vertices have is emptied where such a
/// walk can. A vertex with more rows than its block has room for moves to another block of its
/// colour. Colours follow each other without gaps: where one gets a block, each behind it moves its
/// first to its end. A colour that is empty stays, without blocks, and is the next to open.
///
/// Damping resists the rate at which lengths and volumes change and never a rigid motion: over a
/// substep of length h, a dashpot c adds (c / h) / 2 (l - l_start)^2 to the energy. Together with
/// what the row has already, that is one spring again, of stiffness k + c / h and a target between
/// the two. So sweeps need not know of damping; damp_rows() does, once a substep. Hinges alone have
/// numbers of their own for it: BendingConstraint::Turning.
class VertexBlocks {
 public:
  VertexBlocks() = default;

  /// @param moves      [vertex_count] whether a vertex is free
  /// @param tets       [tet_count] those without weights, stiffness and damping do nothing
  /// @param springs    [spring_count] likewise
  /// @param hinges     [hinge_count] likewise
  /// @param coloring   of the vertices, without max_colors; repair is followed by a search for
  ///                   fewer
  /// @param unit       m, of fixed points
  /// @param at_once    whether all move at once, in one colour
  /// @param triangles  [triangle_count] those without stiffness do nothing
  VertexBlocks(const std::vector<bool>& moves, std::vector<VertexTet> tets,
               std::vector<VertexSpring> springs, std::vector<VertexHinge> hinges,
               const ColoringOptions& coloring, float unit = kUsualUnit, bool at_once = false,
               std::vector<VertexTriangle> triangles = {});

  /// m, of fixed points.
  [[nodiscard]] float unit() const noexcept { return unit_; }
  void set_unit(float unit) noexcept { unit_ = unit; }

  [[nodiscard]] Index vertex_count() const noexcept { return static_cast<Index>(places_.size()); }
  [[nodiscard]] Index color_count() const noexcept {
    return static_cast<Index>(first_block_.size()) - 1;
  }

  /// Blocks of a colour: [first, first + count).
  [[nodiscard]] RowRange blocks(Index color) const noexcept {
    return {first_block_[color], first_block_[color + 1] - first_block_[color]};
  }
  [[nodiscard]] Index block_count() const noexcept { return static_cast<Index>(blocks_.size()); }
  [[nodiscard]] VertexRows rows() const noexcept {
    return {blocks_.data(),    pulls_.data(),  springs_.data(), volumes_.data(), hinges_.data(),
            triangles_.data(), fibres_.data(), strips_.data(),  fans_.data()};
  }
  [[nodiscard]] DampedRows damped_rows() noexcept {
    return {blocks_.data(),         springs_.data(),          volumes_.data(),
            hinges_.data(),         triangles_.data(),        damped_springs_.data(),
            damped_volumes_.data(), damped_triangles_.data(), strips_.data(),
            damped_strips_.data()};
  }

  /// The rows that are a block's, in use or not: it keeps them where edits give it another index,
  /// and its lanes in use have all of them, padded.
  struct BlockRoom {
    Index number;  ///< below room_count()
    RowRange pulls, springs, volumes, hinges, triangles, fibres;
  };
  [[nodiscard]] PBDSURG_API BlockRoom room_of(Index block) const noexcept;
  [[nodiscard]] Index room_count() const noexcept { return room_count_; }

  /// How much more of each array an edit may need that brings so much: in none that is empty.
  struct Growth {
    std::size_t blocks = 0, pulls = 0, springs = 0, volumes = 0, hinges = 0, triangles = 0,
                fibres = 0, strips = 0, fans = 0;
  };
  [[nodiscard]] PBDSURG_API Growth expected_growth(const SpareRoom& spare) const noexcept;

  /// All arrays, for those who keep a copy of them.
  struct Arrays {
    std::span<const VertexBlock> blocks;
    std::span<const PullRow> pulls;
    std::span<const SpringRow> springs;
    std::span<const VolumeRow> volumes;
    std::span<const HingeRow> hinges;
    std::span<const TriangleRow> triangles;
    std::span<const FibreRow> fibres;
    std::span<const DampedRow> damped_springs, damped_volumes,
        damped_triangles;  ///< or empty
    std::span<const StripRow> strips;
  };
  [[nodiscard]] Arrays arrays() const noexcept {
    return {blocks_, pulls_,          springs_,        volumes_,          hinges_, triangles_,
            fibres_, damped_springs_, damped_volumes_, damped_triangles_, strips_};
  }

  /// Where a vertex is; no block holds one that is not free.
  struct Place {
    Index block = kInvalidIndex;
    Index lane = 0;
  };
  [[nodiscard]] Place place_of(Index vertex) const noexcept { return places_[vertex]; }

  /// Of a vertex in a block; kInvalidIndex for others.
  [[nodiscard]] Index color_of(Index vertex) const noexcept { return color_of_[vertex]; }

  /// The lanes of a vertex in its block: idle ones, too, if they repeat it.
  [[nodiscard]] LaneBits lanes_of(Index vertex) const noexcept {
    const auto [block, lane] = places_[vertex];
    const Index lanes = blocks_[block].lane_count;
    return LaneBits{1} << lane | (lane == lanes - 1 ? ~LaneBits{0} << lanes : 0);
  }

  /// Whether damp_rows() has anything to do.
  [[nodiscard]] bool has_damping() const noexcept { return has_damping_; }

  // Changes; refresh() makes them felt. Vertices may be others than before. Cost: constant.
  void set_tet(Index tet, const VertexTet& terms);
  void remove_tet(Index tet);
  void set_spring(Index spring, const VertexSpring& terms);
  void set_spring_rest(Index spring, float rest);
  void set_limit(Index spring, float stiffness, float limit);
  void remove_spring(Index spring);
  void set_triangle(Index triangle, const VertexTriangle& terms);
  void remove_triangle(Index triangle);
  void set_hinge(Index hinge, const VertexHinge& terms);
  void remove_hinge(Index hinge);
  [[nodiscard]] const VertexTet& tet(Index id) const noexcept { return tets_[id]; }

  // Additions, behind what there is; refresh() makes them felt. What is damped can only come where
  // something is already. Cost: constant, beside growth of arrays.
  /// @param count  of all vertices; new ones are not free
  void add_vertices(Index count);
  void set_free(Index vertex);
  void add_tet(const VertexTet& terms);
  void add_spring(const VertexSpring& terms);
  void add_triangle(const VertexTriangle& terms);
  void add_hinge(const VertexHinge& terms);

  // Those that a vertex has or had, ascending.
  [[nodiscard]] std::span<const Index> tets_at(Index vertex) const { return tets_at_[vertex]; }
  [[nodiscard]] std::span<const Index> springs_at(Index vertex) const {
    return springs_at_[vertex];
  }
  [[nodiscard]] std::span<const Index> triangles_at(Index vertex) const {
    return given_triangles_.size() == 0 ? std::span<const Index>() : triangles_at_[vertex];
  }
  [[nodiscard]] std::span<const Index> hinges_at(Index vertex) const {
    return given_hinges_.size() == 0 ? std::span<const Index>() : hinges_at_[vertex];
  }

  /// What is removed has no terms.
  [[nodiscard]] std::span<const VertexTet> tets() const noexcept { return tets_.values(); }
  [[nodiscard]] std::span<const VertexSpring> springs() const noexcept { return given_.values(); }
  [[nodiscard]] std::span<const VertexTriangle> triangles() const noexcept {
    return given_triangles_.values();
  }
  [[nodiscard]] std::span<const VertexHinge> hinges() const noexcept {
    return given_hinges_.values();
  }

  /// Rebuilds the rows of vertices at what has changed. Cost: proportional to the neighbours of
  /// those vertices, and of those that a walk moves; and, where a colour gets or loses a block, to
  /// the colours.
  void refresh();

  /// Vertices whose rows were rebuilt since begin_edit() or undo(), that are in other lanes, or
  /// that no block has any more; where all move at once, those in other blocks, too. Some more than
  /// once.
  [[nodiscard]] std::span<const Index> refreshed() const noexcept { return refreshed_; }

  /// Blocks that are others since then, not by the number of their rows alone: by their lanes, by
  /// their rows' place, or because there are so many no more. Some more than once.
  [[nodiscard]] std::span<const Index> changed_blocks() const noexcept { return changed_blocks_; }

  /// Makes room, so that edits find no memory for so much.
  void reserve(const SpareRoom& spare);

  /// Forgets what changed so far.
  void begin_edit() noexcept;

  /// Takes back all changes since begin_edit(); refresh() makes that felt. Vertices have the
  /// colours and rows that they had, in these other places maybe.
  void undo();

  /// Bytes in use.
  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  // One vertex's rows before they are laid out.
  struct Pull {
    Index neighbor;
    float weight;
    float damping;  // N s/m
  };
  struct Spring {
    Index neighbor;
    float stiffness, rest, damping;
  };
  struct Volume {
    std::array<Index, 3> face;
    float stiffness, target, damping;
  };
  struct Bend {
    std::array<Index, 3> neighbors;  // as in HingeRow
    bool is_opposite;
    float moment, stiffness, rest, damping;
  };
  struct Area {
    std::array<Index, 2> neighbors;
    std::array<float, 2> weights;
    float stiffness, target, damping;
  };
  struct Fibres {
    std::array<Index, 3> neighbors;
    std::array<float, 3> shares;
    float stiffness;
  };
  struct Neighborhood {
    std::vector<Pull> pulls;
    std::vector<Spring> springs;
    std::vector<Volume> volumes;
    std::vector<Bend> hinges;
    std::vector<Area> triangles;
    std::vector<Fibres> fibres;
  };
  struct Rows {
    Index pulls = 0, springs = 0, volumes = 0, hinges = 0, strips = 0, triangles = 0, fibres = 0,
          fans = 0, fan_steps = 0;

    [[nodiscard]] static Rows most(const Rows& a, const Rows& b) noexcept;
    /// Strips and fans do without.
    [[nodiscard]] bool has_room_for(const Rows& needs) const noexcept;
  };
  // Where the rows of a block begin, and how many there may be.
  struct Room {
    Rows firsts, counts;
    Index number;
  };
  enum class List : std::uint8_t { tets, springs, hinges, triangles };
  struct ListChange {
    List list;
    bool is_added;
    Index vertex, element;
  };
  struct ColorChange {
    Index vertex, before;
  };
  struct Counts {
    Index vertices = 0, tets = 0, springs = 0, hinges = 0, triangles = 0, colors = 0;
  };

  [[nodiscard]] Coloring color_vertices(const std::vector<bool>& moves,
                                        const ColoringOptions& options) const;
  void append_block(Index color, std::span<const Index> vertices);
  [[nodiscard]] bool is_neighborhood_damped() const noexcept;
  bool note_flags(VertexBlock& block) const noexcept;
  [[nodiscard]] Room make_room(const Rows& counts);
  static void occupy(VertexBlock& block, const Room& room) noexcept;
  void touch(std::span<const Index> vertices);
  [[nodiscard]] ListPool& list(List which) noexcept;
  void change_list(List which, Index vertex, Index element, bool is_added);
  template <class Element>
  void set(UndoArray<Element>& elements, List which, Index id, const Element& terms);
  template <class Element>
  void add(UndoArray<Element>& elements, List which, const Element& terms);
  void note_conflicts(std::span<const Index> vertices);
  void add_pull(const Pull& pull);
  void find_neighborhood(Index vertex);
  void write_rows(Index vertex) noexcept;
  void write_lane(const VertexBlock& block, Index lane) noexcept;
  void find_strip();
  void count_rows(VertexBlock& block) noexcept;

  // vertex_sheet_rows.cpp
  void find_triangles(Index vertex);
  void add_dashpot(Index neighbor, float damping);
  void write_triangles(const VertexBlock& block, Index lane, Index count) noexcept;
  void find_hinges(Index vertex);
  void write_hinges(const VertexBlock& block, Index lane, Index count) noexcept;
  Index find_fan();
  void write_fan(const VertexBlock& block, Index lane, Index count) noexcept;

  // vertex_growth.cpp
  [[nodiscard]] bool is_fresh(Index vertex) const noexcept;
  void give_colors();
  void find_neighbors(Index vertex);
  [[nodiscard]] Index free_color(Index vertex);
  void rearrange_colors();
  void append_vertices(Index color, std::vector<Index>& vertices) const;
  bool walk(std::span<const Index> colors, std::int64_t effort);
  void open_color(Index color);
  void change_color(Index vertex, Index color);
  void set_color(Index vertex, Index color);
  void take_lane(Index vertex);
  void leave_lane(Index vertex) noexcept;
  void copy_lane(const VertexBlock& block, Index from, Index to) noexcept;
  [[nodiscard]] Index open_block(Index color, const Rows& needs);
  [[nodiscard]] Index add_block(Index color, const Rows& needs);
  void remove_block(Index block);
  void move_block(Index color, Index from, Index to) noexcept;

  // What is removed keeps its vertices and has no terms any more.
  UndoArray<VertexTet> tets_;                  // [tet_count]
  UndoArray<VertexSpring> given_;              // [spring_count]
  UndoArray<VertexHinge> given_hinges_;        // [hinge_count]
  UndoArray<VertexTriangle> given_triangles_;  // [triangle_count]
  ListPool tets_at_, springs_at_;              // [vertex_count] all that there ever were
  ListPool hinges_at_;                         // likewise; no lists if there is no hinge
  ListPool triangles_at_;                      // likewise
  bool has_damping_ = false;
  bool at_once_ = false;
  float unit_ = kUsualUnit;

  std::vector<bool> is_free_;             // [vertex_count]
  std::vector<Index> color_of_;           // [vertex_count] kInvalidIndex where it has none
  std::vector<Index> color_sizes_;        // [color_count] vertices that have it
  std::vector<Index> first_block_{0};     // [color_count + 1]
  std::vector<std::vector<Index>> open_;  // [color] blocks with idle lanes
  std::vector<VertexBlock> blocks_;
  std::vector<PullRow> pulls_;
  std::vector<SpringRow> springs_;
  std::vector<VolumeRow> volumes_;
  std::vector<HingeRow> hinges_;
  std::vector<DampedRow> damped_springs_;  // [springs_.size()] if there is damping
  std::vector<DampedRow> damped_volumes_;  // [volumes_.size()] likewise
  std::vector<TriangleRow> triangles_;
  std::vector<DampedRow> damped_triangles_;  // [triangles_.size()] if there is damping
  std::vector<FibreRow> fibres_;
  std::vector<StripRow> strips_;
  std::vector<DampedRow> damped_strips_;  // [strips_.size()] likewise
  std::vector<FanRow> fans_;
  std::vector<Room> rooms_;       // [block]
  std::vector<Room> left_rooms_;  // of blocks that are gone
  std::vector<Place> places_;     // [vertex_count]
  std::vector<Rows> needs_;       // [vertex_count]

  Index room_count_ = 0;  // ever made

  std::vector<Index> touched_, refreshed_, changed_blocks_;
  std::vector<bool> is_touched_;  // [vertex_count]
  std::vector<Index> conflicts_;  // vertices with a neighbour of their colour, maybe

  // Since begin_edit().
  Counts counts_before_;
  float unit_before_ = kUsualUnit;
  std::vector<ListChange> list_changes_;
  std::vector<ColorChange> color_changes_;

  std::vector<Index> near_;          // neighbours of the vertex at hand
  std::vector<bool> is_near_;        // [vertex_count] of these, while they are sought
  std::vector<bool> is_color_free_;  // [color] at the vertex at hand
  std::vector<Index> uncolored_;     // of the edit at hand
  LocalWalk local_walk_;
  Neighborhood neighborhood_;  // of the vertex at hand
  struct StripEntry {
    Index corner;
    float stiffness, target, weight;  // as in StripRow
    float damping = 0;                // of a face, as in DampedRow
  };
  VertexStrip strip_;
  std::vector<std::array<Index, 3>> faces_;  // likewise
  std::vector<StripEntry> strip_entries_;    // likewise
  struct FanEntry {
    Index corner;
    float stiffness, target, within, weight;  // as in FanRow
  };
  std::vector<FanEntry> fan_entries_;  // likewise
  std::vector<bool> is_left_;          // [triangle] in no fan yet, likewise
};

/// Sets stiffness and target of damped rows for a substep, in one thread.
/// @param bases       [place] where the substep starts, with
/// @param carries     [place]
/// @param inverse_dt  1/s
void add_damping(const DampedRows& rows, Index block_count, std::span<const Particle> bases,
                 std::span<const Carry> carries, float inverse_dt) noexcept;

}  // namespace pbdsurg
