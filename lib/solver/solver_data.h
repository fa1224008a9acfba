// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Everything a solver holds, for the backends that step it and the edits that change it.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <memory_resource>
#include <span>
#include <vector>

#include "pbdsurg/constraints/distance.h"
#include "pbdsurg/constraints/neo_hookean.h"
#include "pbdsurg/constraints/strain_limit.h"
#include "pbdsurg/constraints/volume.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/solver/solver.h"

#include "solver/changes.h"
#include "solver/constraint_slots.h"
#include "solver/distance_ids.h"
#include "solver/edge_owners.h"
#include "solver/edit_journal.h"
#include "solver/particle.h"
#include "solver/tool_state.h"
#include "solver/vertex_lists.h"
#include "solver/vertex_method.h"

namespace pbdsurg {

/// What each copy of a scene has of its own.
struct CopyState {
  // State lies in the order of places, in which near vertices are near, so that threads that work
  // on different parts of a body share few cache lines. Constraints name places.
  std::vector<Particle> particles;   // [place] inverse masses are alike in all copies
  std::vector<Velocity> velocities;  // [place]
  std::vector<float> falling;        // [place] of the vertex-block method, as in Snapshot
  std::vector<ToolState> tools;
  Index attachment_colors = 0;
  bool is_state_current = true;  // else positions, velocities and `falling` are the backend's
  std::vector<Eigen::Vector3f> watched_positions;  // [watched_places.size()] m
  StepReport last_report;

  /// As it is here, see `is_state_current`.
  [[nodiscard]] VertexMotion motion_of(Index place) const noexcept {
    const Particle& p = particles[place];
    return {p.x, p.y, p.z, velocities[place], falling.empty() ? 0.0F : falling[place]};
  }
  void set_motion(Index place, const VertexMotion& motion) noexcept {
    particles[place] = {motion.x, motion.y, motion.z, particles[place].w};
    velocities[place] = motion.velocity;
    if (!falling.empty()) {
      falling[place] = motion.falling;
    }
  }

  /// Follows what tools hold: an attachment's colour is the number of tools before it that hold the
  /// same vertex. Cost: O(held vertices).
  void color_attachments();
};

class Backend;

/// All that copies share, and the state of copy 0; while a backend that works on these arrays steps
/// another copy, that one's.
class SolverData : public CopyState {
 public:
  static constexpr const char* kWho = "a solver";

  /// By which it is known again; whoever holds on to it keeps others from having the same.
  std::shared_ptr<const char> identity = std::make_shared<const char>();
  SolverOptions options;
  Eigen::Vector3f gravity;
  std::vector<Body> bodies;
  std::vector<Index> tissue_counts;  // [body] of its vertices that have mass
  std::vector<Index> later_vertex_bodies, later_tet_bodies;  // of what edits added, in its order

  std::vector<Index> place_of_vertex;  // [vertex_count]
  std::vector<Particle> previous;      // [place] at the start of the substep, of the copy at work
  std::vector<CopyState> others;       // [copies - 1] copy 1 and on

  // live topology: ids are stable, dead ones stay in the id arrays
  std::vector<Tet> tets;                        // [tet_count]
  std::vector<Edge> edges;                      // [edge_count]
  std::vector<Link> links;                      // [link_count]
  DistanceIds distance_ids;                     // of edges and links
  std::vector<std::array<Index, 6>> tet_edges;  // [tet_count] edge ids
  std::vector<Index> edge_tets;                 // [edge_count] live tetrahedra around each edge
  VertexLists vertex_tets;                      // [vertex_count] live tetrahedra at each vertex
  VertexLists vertex_links;                     // [vertex_count] live links at each vertex
  std::vector<bool> tet_alive;                  // [tet_count]
  std::vector<double> tet_masses;               // [tet_count] kg
  std::vector<double> vertex_masses;            // [vertex_count] kg
  std::uint64_t topology_version = 0;
  std::uint64_t last_topology_version = 0;  // ever given
  EditJournal journal;

  // Constraints: distances of edges of springs and of links; bodies without volume constraints have
  // none of these, and Neo-Hookean bodies neither those nor distances.
  // Groups are the colours, then overflow; in a nested plan those of each domain. In a joint plan
  // six more groups of distances follow for each group of volumes, one for each of kTetEdges: edges
  // at that place of the tetrahedra that own them. Groups that edits open follow.
  ConstraintSlots<DistanceConstraint> distances;         // [distance_ids.count()]
  ConstraintSlots<VolumeConstraint> volumes;             // [tet_count]
  ConstraintSlots<NeoHookeanConstraint> neo_hookeans;    // [tet_count]
  ConstraintSlots<StrainLimitConstraint> strain_limits;  // [edge_count]
  Index first_joint_group = 0;                           // of distances
  std::vector<Phase> constraint_phases;                  // all that there can be, in order
  std::vector<Index> domain_counts;                      // [level] of a nested plan
  bool has_damping = false;                              // of any material
  EdgeOwners edge_owners;
  VertexMethod vertex_method;
  StepPlan plan;
  std::unique_ptr<Backend> backend;

  // between steps
  enum class Step { none, running, finished };  // finished: its report was not asked for yet
  Step step_in_flight = Step::none;
  StepReport report;  // of a finished step
  Changes changes;    // since the last step began
  std::vector<Index> watched_places;
  std::vector<Index> read_places;  // buffer of reads from the backend
  std::vector<Index> edit_buffer;  // of what an edit needs for a while
  std::vector<bool> group_buffer;  // [group of a kind] likewise
  // for lists of the like: keeps what it has got, so that later edits ask for no memory
  std::unique_ptr<std::pmr::memory_resource> scratch =
      std::make_unique<std::pmr::unsynchronized_pool_resource>(
          std::pmr::pool_options{.largest_required_pool_block = std::size_t{1} << 20});

  [[nodiscard]] Index copy_count() const noexcept { return static_cast<Index>(others.size()) + 1; }
  [[nodiscard]] CopyState& copy(Index index) { return index == 0 ? *this : others[index - 1]; }
  [[nodiscard]] const CopyState& copy(Index index) const {
    return index == 0 ? *this : others[index - 1];
  }

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

  [[nodiscard]] bool is_link_alive(Index link) const noexcept {
    return distances.is_alive(distance_ids.of_link(link));
  }

  /// Whether a distance is that of an edge with an owner, see EdgeOwners.
  [[nodiscard]] bool is_owned(Index distance) const noexcept {
    const Index edge = distance_ids.edge_of(distance);
    return edge != kInvalidIndex && edge_owners[edge] != kInvalidIndex;
  }

  /// Of the edges at a place in kTetEdges of tetrahedra of one colour.
  [[nodiscard]] Index joint_group(Index color, Index place) const noexcept {
    return first_joint_group + 6 * color + place;
  }

  /// How many constraints a phase projects; zero for phases of other kinds.
  [[nodiscard]] Index constraint_count(const Phase& phase) const noexcept;

  /// Where a joint plan projects an edge that has an owner.
  [[nodiscard]] Index joint_group_of(Index edge) const noexcept;

  /// @param dt  s, as Solver::step() takes it
  void start_step(float dt);

  /// Waits for the step that is running, if one is. All that reads the state, or changes what
  /// Backend says must stay while a step runs, calls this first.
  void finish_running_step();

  /// Makes positions, velocities and `falling` of a copy those of now.
  void fetch_state(Index copy);

  /// As fetch_state(), of some vertices with tissue in all copies: what else is out of date stays
  /// so. Cost: proportional to these.
  void fetch_motion(std::span<const Index> vertices);

  /// Reads some positions of a copy, without fetching all.
  /// @param vertices  [n] scene vertices
  /// @param out       [n] m
  void read_positions(Index copy, std::span<const Index> vertices, std::span<Eigen::Vector3f> out);

  /// In all copies; a vertex that cannot move stops.
  /// @param w  1/kg
  void set_inverse_mass(Index vertex, float w);

  /// Sets mass and inverse mass; what has none left stops. Kept in mind.
  /// @param mass  kg, >= 0
  void set_mass(Index vertex, double mass);

  /// Sets a mass alone, and counts the tissue of its body.
  void count_mass(Index vertex, double mass);

  // Entries of the log, for backends that need it.
  void log_constraint(PhaseKind kind, Index id);
  void log_tet(Index tet);
  void log_vertex(Index vertex);
  void log_moved(Index vertex);

  // Topology, kept in mind; constraints are another matter.
  void set_tet(Index tet, const Tet& vertices, const std::array<Index, 6>& edges_of_tet);
  void set_edge_tets(Index edge, Index count);
  void set_edge(Index edge, const Edge& ends);
  void set_link(Index link, Index first, Index second);
  void add_tet_at(Index vertex, Index tet);
  void remove_tet_at(Index vertex, Index tet);
  void add_link_at(Index vertex, Index link);
  void remove_link_at(Index vertex, Index link);

  [[nodiscard]] Index body_of_vertex(Index vertex) const noexcept;
  [[nodiscard]] Index body_of_tet(Index tet) const noexcept;

  /// The ids from which on those may be a body's that it did not come with.
  [[nodiscard]] Index first_later_vertex(Index body) const noexcept;
  [[nodiscard]] Index first_later_tet(Index body) const noexcept;

  /// Removes the constraints of an edge that has no tetrahedron any more.
  void remove_edge(Index edge);

  /// Puts a live edge that had an owner where one around it can project it, or on its own.
  void hand_over(Index edge);

  /// Removes a tetrahedron's volume constraint and hands the edges that it owns to others.
  /// Cost: proportional to the tetrahedra around its edges.
  void remove_volume(Index tet);

  /// Lets tools of all copies go of vertices without tissue. Kept in mind.
  void release_dead_vertices();

  /// From here on, changes belong to a new edit; those before are for good.
  /// @param stopping  [n] vertices that will lose their last tetrahedron
  /// @param ends      [n] vertices whose motion the edit looks at; if there are any, no step may
  /// run
  void begin_edit(std::span<const Index> stopping, std::span<const Index> ends);

  /// Tells backends, and undo, that constraints are added, or that such are gone.
  void log_growth();

  /// Keeps in mind how the vertices at EditJournal::stopped move, or has the backend do so; waits
  /// for no step.
  void keep_motion();
  /// Brings what the backend keeps in mind of that into EditJournal::motions; waits.
  void collect_motion();

  /// Gives the topology a new number.
  /// @param fingerprint  by which the edit is known
  void end_edit(std::uint64_t fingerprint);

  /// Takes back the last edit, which must be open. Cost: proportional to the edit and O(phases).
  void undo_edit();

  /// Lets tools of all copies go of vertices from an id on, which are about to go themselves.
  /// @return  whether any held one
  bool release_vertices_from(Index end);

  /// A tool of a copy gave up what it holds: no undo brings it back.
  void forget_releases(Index copy, Index tool);

  /// Phases follow what tools of any copy hold and what is left, so this is called after each
  /// grasp, release or removal. Cost: O(phases + tools of all copies).
  void rebuild_plan();

  /// As rebuild_plan(), but at no cost where an edit, or its undo, left no phase without
  /// constraints and gave none its first.
  /// @param releases  whether tools let go, or hold again
  void update_plan(bool releases);
};

/// Calls visit(vertex), visit(tet) for those of a body, dead ones, too; ids ascend. Cost: O(those
/// that it came with, and all that edits brought).
template <class Visit>
void for_each_vertex_of(const SolverData& data, Index body, Visit visit) {
  const Body& own = data.bodies[body];
  for (Index v = own.first_vertex; v < own.first_vertex + own.vertex_count; ++v) {
    visit(v);
  }
  const auto end = static_cast<Index>(data.place_of_vertex.size());
  for (Index v = data.first_later_vertex(body); v < end; ++v) {
    if (data.body_of_vertex(v) == body) {
      visit(v);
    }
  }
}
template <class Visit>
void for_each_tet_of(const SolverData& data, Index body, Visit visit) {
  const Body& own = data.bodies[body];
  for (Index t = own.first_tet; t < own.first_tet + own.tet_count; ++t) {
    visit(t);
  }
  const auto end = static_cast<Index>(data.tets.size());
  for (Index t = data.first_later_tet(body); t < end; ++t) {
    if (data.body_of_tet(t) == body) {
      visit(t);
    }
  }
}

/// Calls visit(tet) for those without constraints of their own, dead ones, too.
template <class Visit>
void for_each_tube_tet(const SolverData& data, Visit visit) {
  const auto is_tube = [](const Body& body) {
    return body.material.model == ElasticModel::springs && !has_volume_constraints(body);
  };
  if (std::ranges::none_of(data.bodies, is_tube)) {
    return;
  }
  for (const Body& body : data.bodies) {
    for (Index t = body.first_tet; is_tube(body) && t < body.first_tet + body.tet_count; ++t) {
      visit(t);
    }
  }
  const auto first_later = static_cast<Index>(data.tets.size() - data.later_tet_bodies.size());
  for (std::size_t i = 0; i < data.later_tet_bodies.size(); ++i) {
    const Body& body = data.bodies[data.later_tet_bodies[i]];
    const Index tet = first_later + static_cast<Index>(i);
    const bool came_with_body = tet >= body.first_tet && tet < body.first_tet + body.tet_count;
    if (is_tube(body) && !came_with_body) {
      visit(tet);
    }
  }
}

SolverData& solver_data(Solver& solver);
const SolverData& solver_data(const Solver& solver);

}  // namespace pbdsurg
