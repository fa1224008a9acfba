// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How vertices of a solver move, what its tools do, and what its backend has to hear of that.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <memory>
#include <memory_resource>
#include <span>
#include <vector>

#include "pbdsurg/base/export.h"
#include "pbdsurg/solver/copy_factors.h"
#include "pbdsurg/solver/solver_options.h"

#include "lib/solver/program/backend.h"
#include "lib/solver/state/changes.h"
#include "lib/solver/state/near_features.h"
#include "lib/solver/state/particle.h"
#include "lib/solver/state/tool_state.h"
#include "lib/solver/state/touch_lists.h"
#include "lib/solver/substep_rule.h"

namespace pbdsurg {

/// What each copy of a scene has of its own.
struct CopyState {
  // State lies in the order of places, in which near vertices are near, so that threads that work
  // on different parts of a body share few cache lines. Constraints name places.
  std::vector<Particle> particles;          // [place] inverse masses are alike in all copies
  std::vector<Velocity> velocities;         // [place]
  std::vector<Carry> carries;               // [place] in compliance mode, else empty
  std::vector<Way> ways;                    // [place] of BDF2, else empty: of the last substep, and
  std::vector<Velocity> velocities_before;  // [place] where that began
  float past_substep = 0;                   // s, where lengths count: its own; zero where none does
  std::vector<Load> forces;                 // [place] N, empty while none was set
  CopyFactors factors;
  std::vector<ToolState> tools;
  NearLists near;
  TissueTouches touches;
  Index attachment_colors = 0;
  bool is_state_current = true;                    // else the arrays above are the backend's
  std::vector<Eigen::Vector3f> watched_positions;  // [watched_places.size()] m
  StepReport last_report;
  Index fast_tools = 0;  ///< of the current step: see StepReport

  /// m/N, as a substep takes it: see substep_numbers().
  [[nodiscard]] float grasp_compliance(const Attachment& attachment) const noexcept {
    return factors.stiffness * attachment.compliance;
  }

  /// m/N, likewise, of the spring of a coupled tool.
  [[nodiscard]] float spring_compliance(const ToolState& tool) const noexcept {
    return factors.stiffness / tool.coupling.stiffness;
  }

  /// As it is here, see `is_state_current`.
  [[nodiscard]] VertexMotion motion_of(Index place) const noexcept {
    const Particle& p = particles[place];
    return {p.x,
            p.y,
            p.z,
            velocities[place],
            carries.empty() ? Carry{} : carries[place],
            ways.empty() ? Way{} : ways[place],
            ways.empty() ? Velocity{} : velocities_before[place]};
  }
  void set_motion(Index place, const VertexMotion& motion) noexcept {
    particles[place] = {motion.x, motion.y, motion.z, particles[place].w};
    velocities[place] = motion.velocity;
    if (!carries.empty()) {
      carries[place] = motion.carry;
    }
    if (!ways.empty()) {
      ways[place] = motion.way;
      velocities_before[place] = motion.velocity_before;
    }
  }

  /// The vertex cannot move: it has no motion, before either.
  void stop(Index place) noexcept {
    velocities[place] = {};
    if (!ways.empty()) {
      ways[place] = {};
      velocities_before[place] = {};
    }
  }

  /// Makes the next substep of BDF2 one of implicit Euler, and velocities of explicit steps those
  /// of now.
  void forget_past() noexcept {
    past_substep = 0;
    std::ranges::fill(ways, Way{});
    std::ranges::fill(velocities_before, Velocity{});
  }

  [[nodiscard]] std::size_t memory_bytes() const noexcept;

  /// Whether a tool pushes tissue: it does not while its jaws are shut around some.
  [[nodiscard]] PBDSURG_API bool pushes(Index tool) const noexcept;

  /// Follows what tools hold: an attachment's colour is the number of tools before it that hold the
  /// same vertex. Cost: O(held vertices).
  void color_attachments();
};

class Tissue;
class VertexBlocks;

/// All that copies share of motion, and the state of copy 0.
struct SolverState : CopyState {
  SolverOptions options;
  SubstepRule substep_rule;
  StepPart part;                                // of the step that runs
  Eigen::Vector3f gravity;                      // m/s^2, of bodies without their own
  std::vector<Eigen::Vector3f> body_gravities;  // [body] m/s^2, empty while none has its own
  std::vector<Load> gravities;                  // [place] likewise
  std::vector<Index> place_of_vertex;           // [vertex_count]
  std::vector<CopyState> others;                // [copies - 1] copy 1 and on
  std::unique_ptr<Backend> backend;

  // between steps
  enum class Step { none, running, finished };  // finished: its report was not asked for yet
  Step step_in_flight = Step::none;
  // What follows a step that a device has done.
  void (*end_step)(SolverState& data) = nullptr;
  StepReport report;                  // of a finished step
  float step_length = 0;              // s, of the step begun last
  Index steps_since_convergence = 0;  // was measured
  Changes changes;                    // since the last step began
  std::vector<Index> watched_places;
  std::vector<Index> read_places;  // buffer of reads from the backend

  // by tools, of vertices that the last edit left without tissue
  struct Release {
    Index copy, tool;
    std::size_t entry;  ///< of the tool's attachments, after those released before it
    Attachment attachment;
  };
  std::vector<Release> releases;

  // likewise, of points of grips
  struct GripRelease {
    Index copy, tool;
    std::size_t entry;  ///< of the grip's points, after those released before it
    GripPoint point;
  };
  std::vector<GripRelease> grip_releases;

  // for lists of a while: keeps what it has got, so that later edits ask for no memory
  std::unique_ptr<std::pmr::memory_resource> scratch =
      std::make_unique<std::pmr::unsynchronized_pool_resource>(
          std::pmr::pool_options{.largest_required_pool_block = std::size_t{1} << 20});

  /// Whether jaws hold something with a limit, in any copy.
  [[nodiscard]] PBDSURG_API bool has_grips() const noexcept;

  [[nodiscard]] Index copy_count() const noexcept { return static_cast<Index>(others.size()) + 1; }
  [[nodiscard]] CopyState& copy(Index index) { return index == 0 ? *this : others[index - 1]; }
  [[nodiscard]] const CopyState& copy(Index index) const {
    return index == 0 ? *this : others[index - 1];
  }

  /// [place] scene vertices. Cost: O(vertices).
  [[nodiscard]] std::vector<Index> vertices_at_places() const;

  [[nodiscard]] Particle& particle(Index vertex) { return particles[place_of_vertex[vertex]]; }
  [[nodiscard]] const Particle& particle(Index vertex) const {
    return particles[place_of_vertex[vertex]];
  }

  /// @param vertices  of the scene
  template <std::size_t kCount>
  [[nodiscard]] std::array<Index, kCount> places_of(
      const std::array<Index, kCount>& vertices) const {
    std::array<Index, kCount> places;
    std::transform(vertices.begin(), vertices.end(), places.begin(),
                   [&](Index v) { return place_of_vertex[v]; });
    return places;
  }

  /// Waits for the step that is running, if one is. All that reads the state, or changes what
  /// Backend says must stay while a step runs, calls this first.
  void finish_running_step();

  /// Makes particles, velocities and carries of a copy those of now.
  PBDSURG_API void fetch_state(Index copy);

  /// As fetch_state(), of some vertices with tissue in all copies: what else is out of date stays
  /// so. Cost: proportional to these.
  void fetch_motion(std::span<const Index> vertices);

  /// Reads some positions of a copy, without fetching all.
  /// @param vertices  [n] scene vertices
  /// @param out       [n] m
  void read_positions(Index copy, std::span<const Index> vertices, std::span<Eigen::Vector3f> out);

  /// What the copy needs that is the stiffest for its density.
  [[nodiscard]] PBDSURG_API SubstepRule rule_of_copies() const noexcept;

  /// m/s^2
  /// @param body  of the tissue
  [[nodiscard]] const Eigen::Vector3f& gravity_of(Index body) const {
    return body_gravities.empty() ? gravity : body_gravities[body];
  }

  /// From here on bodies have gravities of their own, or all have one again, if there are none.
  /// @param own  [body_count] m/s^2
  void set_body_gravities(const Tissue& tissue, std::vector<Eigen::Vector3f> own);

  /// In all copies; a vertex that cannot move stops.
  /// @param w  1/kg
  void set_inverse_mass(Index vertex, float w);

  // Entries of the log, for backends that need it.
  void log_constraint(PhaseKind kind, Index id);
  void log_tet(Index tet);
  void log_vertex(Index vertex);
  void log_moved(Index vertex);
  void log_force(Index copy, Index place);

  /// Constraints are added, or such are gone.
  void log_growth();

  /// Rows are others than before an edit, or its undo.
  /// @param are_anew  whether they were laid out anew
  void log_rows(const VertexBlocks& blocks, bool are_anew);
  void log_shares(std::span<const Index> places);

  /// A tool of a copy gave up what it holds: no undo brings it back.
  void forget_releases(Index copy, Index tool);

  /// Makes room for what a tool can touch, so that no step allocates; of all tools for the latter.
  void reserve_tool(ToolState& tool) const;
  void reserve_tools();

  /// Likewise for what bodies can touch of each other, where they meet.
  void reserve_touches();

  [[nodiscard]] std::size_t memory_bytes() const noexcept;
};

}  // namespace pbdsurg
