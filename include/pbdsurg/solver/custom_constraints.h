// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Constraints of a program's own, projected once a sweep.

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <span>
#include <string>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/constraints/projection.h"
#include "pbdsurg/tissue/follower.h"

namespace pbdsurg {

class CustomConstraints;
class Filling;
struct StepContext;
class Tissue;

/// The vertices of one copy within a sweep, as a set of custom constraints sees and pushes them.
///
/// A set writes no position: it pushes vertices by forces, and a vertex goes where the method says
/// that such a force takes it. So no position loses digits, the sweeps to come know the force, and
/// pushes that sum to zero keep linear momentum: of projections; with vertex blocks that of free
/// pieces that satisfy() joins.
///
/// Vertices are those of the scene.
///
/// @throws InvalidArgument  from all that take a vertex, naming the set and a vertex out of range
class PBDSURG_API ConstraintSweep {
 public:
  /// A vertex of a constraint, and how the constraint's value changes with its place.
  struct Corner {
    Index vertex;              ///< of the scene
    Eigen::Vector3f gradient;  ///< of the value, by its position
  };

  /// What a multiplier may be: of a rope that pulls where it is too long, at most zero.
  struct Range {
    float least = -std::numeric_limits<float>::infinity();  ///< as a multiplier
    float most = std::numeric_limits<float>::infinity();    ///< likewise
  };

  /// The solver makes these.
  ConstraintSweep(const StepContext& step, const CustomConstraints& set,
                  const Substep<float>& lengths, int index);

  /// Of the scene, that this is about: see SolverOptions::copies.
  [[nodiscard]] Index copy() const noexcept;
  /// 0 for the first sweep of a substep; -1 for the call of the vertex-block method before it,
  /// whose places are where vertices would go without the set.
  [[nodiscard]] int index() const noexcept { return index_; }
  /// s, of the substep
  [[nodiscard]] float dt() const noexcept;
  /// Whether Solver::convergence() tries a substep that nobody will have made.
  [[nodiscard]] bool is_probe() const noexcept;
  [[nodiscard]] const Tissue& tissue() const noexcept;  ///< that the vertices are of

  /// m, where a vertex is now, rounded; not a number where it is lost
  [[nodiscard]] Eigen::Vector3f position(Index vertex) const;
  /// m, where it was at the start of the substep
  [[nodiscard]] Eigen::Vector3f start(Index vertex) const;
  /// m, from one vertex to another: with more digits than the difference of two positions, far from
  /// the origin.
  [[nodiscard]] Eigen::Vector3f way(Index from, Index to) const {
    const std::size_t a = quad(from), b = quad(to);
    return (base(b) - base(a)) + (moved(b) - moved(a));
  }
  /// Likewise, to a place.
  [[nodiscard]] Eigen::Vector3f way_to(Index from, const Eigen::Vector3f& to) const {
    const std::size_t a = quad(from);
    return (to - base(a)) - moved(a);
  }

  /// 1/kg; 0 where the vertex is fixed or without tissue
  [[nodiscard]] float inverse_mass(Index vertex) const { return moving_[quad(vertex) + 3]; }
  /// Whether something is there: not where an edit took all its tissue away.
  [[nodiscard]] bool has_tissue(Index vertex) const;

  /// m, how far a push takes a vertex: by its inertia, and with vertex blocks by what its tissue
  /// holds against it, too. Zero where it is fixed or without tissue, or a tool holds it rigidly
  /// with vertex blocks.
  /// @param vertex  one of CustomConstraints::vertices()
  /// @param force   N
  [[nodiscard]] Eigen::Vector3f yield(Index vertex, const Eigen::Vector3f& force) const;

  /// Pushes a vertex, as far as it yields. Does nothing to one that is lost.
  /// @param vertex  one of CustomConstraints::vertices()
  /// @param force   N, in addition to earlier pushes of the substep
  /// @throws InvalidArgument  naming the set, the vertex and the force, if that is not finite, or
  ///                          takes the vertex where nothing is finite, or no set named the vertex
  void push(Index vertex, const Eigen::Vector3f& force);

  /// One projection of a constraint with a compliance, after Macklin et al. 2016, "XPBD": changes
  /// its multiplier so that value + compliance * multiplier = 0 as far as vertices yield, and
  /// pushes these. Nothing happens where no corner yields, or one is lost so that no number is
  /// finite.
  ///
  /// With vertex blocks 0.7 of the way in the sweeps, since neighbours yield together, and further
  /// than each alone.
  /// @param corners     each vertex once; the force on it is multiplier times gradient
  /// @param value       of the constraint, in m where gradients are pure numbers
  /// @param compliance  >= 0, m/N in that case; 0: rigid
  /// @param multiplier  N in that case: of this constraint in this substep so far, at first 0
  /// @return            the multiplier from now on
  /// @throws InvalidArgument  naming the set, a vertex and the number that is not finite or
  /// negative
  [[nodiscard]] float satisfy(std::span<const Corner> corners, float value, float compliance,
                              float multiplier, Range range);
  /// Without bounds.
  [[nodiscard]] float satisfy(std::span<const Corner> corners, float value, float compliance,
                              float multiplier) {
    return satisfy(corners, value, compliance, multiplier, Range());
  }

  /// satisfy() for a constraint of many neighbours at once, such as the volume of a hollow: the
  /// whole way in each sweep, since nothing else makes up for what it would leave undone. The
  /// coarse correction of vertex blocks then moves its vertices, too, by what keeps to the
  /// constraint; of more than 12 in a scene, it leaves vertices of the others out, as those that
  /// satisfy() pushes.
  /// @throws InvalidArgument  as satisfy()
  [[nodiscard]] float satisfy_together(std::span<const Corner> corners, float value,
                                       float compliance, float multiplier, Range range);

 private:
  [[nodiscard]] std::size_t quad(Index vertex) const {
    if (static_cast<std::size_t>(vertex) >= vertex_count_) {
      refuse(vertex);
    }
    return 4 * static_cast<std::size_t>(places_[vertex]);
  }
  [[nodiscard]] static Eigen::Vector3f vector(const float* quads, std::size_t first) {
    return {quads[first], quads[first + 1], quads[first + 2]};
  }
  [[nodiscard]] Eigen::Vector3f base(std::size_t quad) const {
    return bases_ != nullptr ? vector(bases_, quad) : Eigen::Vector3f(0, 0, 0);
  }
  [[nodiscard]] Eigen::Vector3f moved(std::size_t quad) const {
    const Eigen::Vector3f now = vector(moving_, quad);
    return index_ < 0 ? Eigen::Vector3f(now + vector(ahead_, quad)) : now;
  }
  struct Answer {
    float multiplier, give;
  };
  [[nodiscard]] Index named_place(Index vertex) const;
  [[nodiscard]] Answer solve(std::span<const Corner> corners, float value, float compliance,
                             float multiplier, Range range, float share) const;
  float change(std::span<const Corner> corners, const Answer& answer, float multiplier,
               bool leaves_out);
  void move(Index vertex, const Eigen::Vector3f& force);
  void guard(Index place, float stiffness);
  [[noreturn]] void refuse(Index vertex) const;
  [[noreturn]] void refuse(Index vertex, const std::string& why) const;
  [[nodiscard]] bool is_lost(std::size_t quad) const noexcept;

  const StepContext& step_;
  const CustomConstraints& set_;
  const Substep<float>& lengths_;
  int index_;
  bool has_blocks_;
  std::size_t vertex_count_;
  const Index* places_;  // [vertex_count]
  float* moving_;        // [place][4] m and 1/kg: displacements, in fraction mode positions
  const float* bases_;   // [place][4] m, from where displacements count; null in fraction mode
  // [place][4] m, of the vertex-block method: from there to where vertices go by themselves
  const float* ahead_;
};

/// A set of constraints of a program's own: tethers, sutures, springs to an instrument, limits. A
/// solver on a CPU projects it once a sweep, after tissue and links and before what tools hold and
/// push: Solver::add_constraints(). As a Follower it goes along with edits, undo and compaction of
/// the tissue.
///
/// In each step
///
///     begin_step(copies), vertices()           once
///       begin_substep(sweep)                   for each copy and substep
///         project(sweep)                       for each sweep
///
/// Multipliers are the set's own: one for each constraint and copy, 0 at begin_substep(). Calls for
/// one copy come one after another, from one thread at a time, in the order in which the sets were
/// added; those for different copies may come at the same time, from the threads of the executor. A
/// set whose pushes depend on nothing but what it is told has the same results on any number of
/// threads.
///
/// What a callback throws comes out of Solver::step(), which has then changed nothing of the
/// solver.
class PBDSURG_API CustomConstraints : public Follower {
 public:
  /// For messages: "tethers".
  [[nodiscard]] virtual std::string name() const = 0;

  /// All vertices that it may push in the step to come, in any order, also more than once.
  [[nodiscard]] virtual std::span<const Index> vertices() const = 0;

  /// Before anything else of a step, or of Solver::convergence(): the place to take memory, or to
  /// refuse the step by throwing.
  virtual void begin_step(Index /*copies*/) {}

  /// Before the first project() of a substep: sets multipliers to zero. Pushes nothing.
  virtual void begin_substep(const ConstraintSweep& /*sweep*/) {}

  /// Projects the constraints of one copy, once each.
  virtual void project(ConstraintSweep& sweep) = 0;

  /// What a device projects in their place, without calls: of a Lumen alone.
  [[nodiscard]] virtual Filling* filling() noexcept { return nullptr; }
};

}  // namespace pbdsurg
