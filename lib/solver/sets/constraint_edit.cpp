// SPDX-License-Identifier: Apache-2.0
// How constraints follow a change of the tissue, and how that is taken back.
#include <algorithm>
#include <cmath>
#include <memory_resource>

#include "pbdsurg/coloring/color.h"

#include "lib/solver/sets/constraint_groups.h"
#include "lib/solver/sets/constraint_sets.h"
#include "lib/solver/sets/fibre_record.h"
#include "lib/solver/sets/free_groups.h"
#include "lib/solver/sets/membrane_record.h"
#include "lib/solver/sets/neo_hookean_record.h"
#include "lib/solver/sets/stiff_links.h"
#include "lib/tissue/hinges.h"
#include "lib/tissue/split_tets.h"

namespace pbdsurg {
namespace {

// A constraint that is to come.
template <class Constraint>
struct NewConstraint {
  Index id;
  std::array<Index, Constraint::kVertexCount> vertices;
  ConstraintRecord<Constraint> record;
};

}  // namespace

/// Follows one change, step by step in the order in which the tissue did, so that groups fill as
/// they did when constraints and tissue changed at once.
class ConstraintSets::Edit {
 public:
  Edit(ConstraintSets& sets, const Tissue& tissue, const TissueChange& change)
      : sets_(sets),
        state_(sets.state_),
        tissue_(tissue),
        change_(change),
        groups_(sets, tissue, change, state_.scratch.get(), sets.is_taken_, sets.opened_groups_),
        reshaped_(state_.scratch.get()) {
    for (std::size_t i = 0; i < change.reshaped_tets.size(); ++i) {
      reshaped_.emplace_back(change.reshaped_tets[i].tet, static_cast<Index>(i));
    }
    std::ranges::sort(reshaped_);  // of several entries of a tetrahedron, the first comes first
  }

  void run() {
    prefetch();
    for (const RestLengthChange& rest : change_.edit.rest_lengths) {
      set_rest_length(rest);
    }
    for (std::size_t i = 0; i < change_.edit.rest_volumes.size(); ++i) {
      set_rest_volume(change_.edit.rest_volumes[i], sets_.edge_tets_before_[i]);
    }
    for (const RestAreaChange& rest : change_.edit.rest_areas) {
      set_rest_area(of<MembraneConstraint>(), rest.triangle, rest.rest_area);
      log<MembraneConstraint>(rest.triangle);
    }
    for (const StiffnessChange& change : change_.edit.stiffnesses) {
      const Material& material = tissue_.bodies()[tissue_.body_of_tet(change.tet)].material;
      set_stiffness(of<NeoHookeanConstraint>(), change.tet, material, change.factor);
      log<NeoHookeanConstraint>(change.tet);
    }
    for (const TriangleStiffnessChange& change : change_.edit.triangle_stiffnesses) {
      const Body& sheet = tissue_.bodies()[tissue_.body_of_triangle(change.triangle)];
      set_stiffness(of<MembraneConstraint>(), change.triangle, sheet, change.factor);
      log<MembraneConstraint>(change.triangle);
    }
    for (const LinkLengthChange& change : change_.edit.link_lengths) {
      set_link_length(change);
    }
    const std::span<const Index> links(change_.removed_links);
    const std::size_t asked_links = change_.edit.remove_links.size();
    std::ranges::for_each(links.first(asked_links), [&](Index l) { remove_link(l); });
    for (const LinkMove& move : change_.edit.link_moves) {
      const Link& link = tissue_.links()[move.link];
      const Edge ends{link.first, link.second};
      set_places<DistanceConstraint>(sets_.distance_ids.of_link(move.link), ends);
      set_places<StiffLinkConstraint>(move.link, ends);
    }
    const auto first_parent = static_cast<std::size_t>(change_.first_removed_parent);
    remove_tets(0, first_parent, true);
    for (const Index triangle : change_.removed_triangles) {
      remove<MembraneConstraint>(triangle);
    }
    move_corners();
    for (const TriangleMove& move : change_.edit.triangle_moves) {
      set_places<MembraneConstraint>(move.triangle, tissue_.triangles()[move.triangle]);
    }
    replace_parents(first_parent);
    for (const FibreChange& change : change_.edit.fibres) {
      set_fibre(change.tet);
    }
    std::ranges::for_each(links.subspan(asked_links), [&](Index l) { remove_link(l); });
    for (const Index hinge : change_.removed_hinges) {
      remove<BendingConstraint>(hinge);
    }
    for (const Index hinge : change_.moved_hinges) {
      set_places<BendingConstraint>(hinge, tissue_.hinges()[hinge].vertices);
    }
    for (const TriangleStiffnessChange& change : change_.edit.triangle_stiffnesses) {
      set_hinge_stiffnesses(change.triangle);
    }
    add_bodies();
    for (auto l = static_cast<std::size_t>(change_.first_new_link); l < tissue_.links().size();
         ++l) {
      add_link(static_cast<Index>(l));
    }
    for (const Index v : change_.edit.unfix_vertices) {
      std::ranges::for_each(tissue_.links_at(v), [&](Index l) { stiffen(l); });
    }
  }

 private:
  template <class Constraint>
  [[nodiscard]] ConstraintSlots<Constraint>& of() const noexcept {
    return sets_.of<Constraint>();
  }

  template <class Constraint>
  void log(Index id) {
    state_.log_constraint(KindOf<Constraint>::kPhase, id);
  }

  // What removals will need, all at once: it lies scattered.
  void prefetch() const {
    const auto& volumes = of<VolumeConstraint>();
    const auto& distances = of<DistanceConstraint>();
    for (const Index t : change_.removed_tets) {
      volumes.prefetch_location(t);
    }
    for (const Index e : change_.removed_edges) {
      distances.prefetch_location(sets_.distance_ids.of_edge(e));
    }
    for (const Index t : change_.removed_tets) {
      volumes.prefetch_removal(t);
    }
    for (const Index e : change_.removed_edges) {
      distances.prefetch_removal(sets_.distance_ids.of_edge(e));
    }
  }

  // --- rest shape ----------------------------------------------------------------------------

  void scale_limit(Index edge, float factor) {
    auto& limits = of<StrainLimitConstraint>();
    if (limits.is_alive(edge)) {
      const float limit = limits.record(edge).parameters[StrainLimitConstraint::kLimit];
      limits.set_parameter(edge, StrainLimitConstraint::kLimit, limit * factor);
      log<StrainLimitConstraint>(edge);
    }
  }

  // A strain limit keeps its share of the rest length.
  void set_rest_length(const RestLengthChange& rest) {
    auto& distances = of<DistanceConstraint>();
    const Index distance = sets_.distance_ids.of_edge(rest.edge);
    const float before = distances.record(distance).parameters[DistanceConstraint::kRest];
    scale_limit(rest.edge, rest.rest_length / before);
    distances.set_parameter(distance, DistanceConstraint::kRest, rest.rest_length);
    log<DistanceConstraint>(distance);
  }

  void set_rest_volume(const RestVolumeChange& rest, const std::array<Index, 6>& edge_tets) {
    auto& solids = of<NeoHookeanConstraint>();
    if (!solids.is_alive(rest.tet)) {
      of<VolumeConstraint>().set_parameter(rest.tet, VolumeConstraint::kRest, rest.rest_volume);
      log<VolumeConstraint>(rest.tet);
      return;
    }
    // an edge has no rest length of its own: where all n tetrahedra around it change alike, n times
    // the n-th root makes it follow their sides
    const double ratio = double{rest.rest_volume} / rest_volume(solids.record(rest.tet));
    const std::span<const Index, 6> edges = edges_before(rest.tet);
    for (std::size_t e = 0; e < 6; ++e) {
      scale_limit(edges[e], static_cast<float>(std::pow(ratio, 1.0 / (3 * edge_tets[e]))));
    }
    pbdsurg::set_rest_volume(solids, rest.tet, rest.rest_volume);
    log<NeoHookeanConstraint>(rest.tet);
    if (of<FibreConstraint>().is_alive(rest.tet)) {
      set_fibre(rest.tet);
    }
  }

  // As the tissue has it now, of a live tetrahedron or one that the edit has removed.
  void set_fibre(Index tet) {
    auto& fibres = of<FibreConstraint>();
    const Fibre& fibre = tissue_.fibre(tet);
    if (fibre.stiffness <= 0 || !of<NeoHookeanConstraint>().is_alive(tet)) {
      remove<FibreConstraint>(tet);
      return;
    }
    const auto numbers = fibre_numbers(of<NeoHookeanConstraint>().record(tet).parameters, fibre);
    if (!fibres.is_alive(tet)) {
      const Tet& vertices = tissue_.tets()[tet];
      add<FibreConstraint>(tet, vertices, {state_.places_of(vertices), numbers});
      return;
    }
    for (int p = 0; p < FibreConstraint::kParameterCount; ++p) {
      fibres.set_parameter(tet, static_cast<FibreConstraint::Parameter>(p), numbers[p]);
    }
    log<FibreConstraint>(tet);
  }

  // Of what is left of them at the end of the edit.
  void set_hinge_stiffnesses(Index triangle) {
    if (!tissue_.is_triangle_alive(triangle)) {
      return;
    }
    const Triangle& corners = tissue_.triangles()[triangle];
    for_each_hinge_of(tissue_data(tissue_), corners, [&](Index hinge) {
      const auto numbers = hinge_numbers(tissue_, hinge);
      of<BendingConstraint>().set_parameter(hinge, BendingConstraint::kStiffness,
                                            numbers[BendingConstraint::kStiffness]);
      log<BendingConstraint>(hinge);
    });
  }

  void set_link_length(const LinkLengthChange& change) {
    const Index distance = sets_.distance_ids.of_link(change.link);
    of<DistanceConstraint>().set_parameter(distance, DistanceConstraint::kRest, change.rest_length);
    log<DistanceConstraint>(distance);
    if (of<StiffLinkConstraint>().is_alive(change.link)) {
      of<StiffLinkConstraint>().set_parameter(change.link, StiffLinkConstraint::kRest,
                                              change.rest_length);
      log<StiffLinkConstraint>(change.link);
    }
  }

  // --- removal -------------------------------------------------------------------------------

  template <class Constraint>
  void remove(Index id) {
    if (of<Constraint>().is_alive(id)) {
      of<Constraint>().remove(id);
      log<Constraint>(id);
    }
  }

  void remove_link(Index link) {
    remove<DistanceConstraint>(sets_.distance_ids.of_link(link));
    remove<StiffLinkConstraint>(link);
  }

  // @param first, end       of the removed ones
  // @param is_before_moves  of corners
  void remove_tets(std::size_t first, std::size_t end, bool is_before_moves) {
    Index edge = first == 0 ? 0 : change_.removed_edge_ends[first - 1];
    for (std::size_t i = first; i < end; ++i) {
      for (; edge < change_.removed_edge_ends[i]; ++edge) {
        remove<DistanceConstraint>(sets_.distance_ids.of_edge(change_.removed_edges[edge]));
        remove<StrainLimitConstraint>(change_.removed_edges[edge]);
      }
      const Index tet = change_.removed_tets[i];
      if (of<VolumeConstraint>().is_alive(tet)) {
        remove<VolumeConstraint>(tet);
        for (const Index e : tissue_.tet_edges()[tet]) {
          if (sets_.edge_owners[e] == tet &&
              of<DistanceConstraint>().is_alive(sets_.distance_ids.of_edge(e))) {
            hand_over(e, is_before_moves);
          }
        }
      }
      remove<NeoHookeanConstraint>(tet);
      remove<FibreConstraint>(tet);
    }
  }

  // Puts a live edge that had an owner where one around it can project it, or on its own.
  void hand_over(Index edge, bool is_before_moves) {
    const Index distance = sets_.distance_ids.of_edge(edge);
    const auto edges_of = [&](Index tet) -> std::span<const Index, 6> {
      return is_before_moves ? edges_before(tet) : tissue_.tet_edges()[tet];
    };
    sets_.edge_owners.hand_over(edge, edges_of, of<VolumeConstraint>());
    const Index owner = sets_.edge_owners[edge];
    Index group = kInvalidIndex;
    if (owner == kInvalidIndex) {
      sets_.has_grown_ = true;
      group = groups_.find<DistanceConstraint>(tissue_.edges()[edge]);
    } else {
      const auto edges = edges_of(owner);
      const auto place = std::ranges::find(edges, edge) - edges.begin();
      group = sets_.joint_group(of<VolumeConstraint>().group_of(owner), static_cast<Index>(place));
    }
    of<DistanceConstraint>().move(distance, group);
    log<DistanceConstraint>(distance);
  }

  // Of a tetrahedron before its corners moved.
  [[nodiscard]] std::span<const Index, 6> edges_before(Index tet) const noexcept {
    if (change_.edit.corner_moves.empty()) {
      return tissue_.tet_edges()[tet];
    }
    const auto first = std::ranges::lower_bound(reshaped_, tet, {}, &Reshaped::first);
    return first == reshaped_.end() || first->first != tet
               ? tissue_.tet_edges()[tet]
               : change_.reshaped_tets[static_cast<std::size_t>(first->second)].edges;
  }

  // --- parting -------------------------------------------------------------------------------

  template <class Constraint, std::size_t kCount>
  void set_places(Index id, const std::array<Index, kCount>& vertices) {
    if (of<Constraint>().is_alive(id)) {
      of<Constraint>().set_places(id, state_.places_of(vertices));
      log<Constraint>(id);
    }
  }

  void move_corners() {
    for (const CornerMove& move : change_.edit.corner_moves) {
      const Tet& vertices = tissue_.tets()[move.tet];
      set_places<VolumeConstraint>(move.tet, vertices);
      set_places<NeoHookeanConstraint>(move.tet, vertices);
      set_places<FibreConstraint>(move.tet, vertices);
    }
    for (const Index edge : change_.moved_edges) {
      const Edge& ends = tissue_.edges()[edge];
      set_places<DistanceConstraint>(sets_.distance_ids.of_edge(edge), ends);
      set_places<StrainLimitConstraint>(edge, ends);
    }
    for (const Index edge : change_.corner_edges) {  // the owner may have left it
      const Index owner = sets_.edge_owners[edge];
      if (owner != kInvalidIndex && std::ranges::count(tissue_.tet_edges()[owner], edge) == 0) {
        hand_over(edge, false);
      }
    }
    for (const PartedEdge& parted : change_.parted_edges) {
      add_edge(parted.edge, sets_.numbers_of_edge(parted.origin));
    }
  }

  // --- what comes ----------------------------------------------------------------------------

  template <class Constraint>
  void add(Index id, std::span<const Index> vertices, const ConstraintRecord<Constraint>& record) {
    of<Constraint>().add(id, groups_.find<Constraint>(vertices), record);
    log<Constraint>(id);
  }

  void add_edge(Index edge, const EdgeNumbers& numbers) {
    const Edge& ends = tissue_.edges()[edge];
    if (numbers.distance) {
      add<DistanceConstraint>(sets_.distance_ids.of_edge(edge), ends,
                              {state_.places_of(ends), *numbers.distance});
    }
    if (numbers.limit) {
      add<StrainLimitConstraint>(edge, ends, {state_.places_of(ends), *numbers.limit});
    }
  }

  void add_link(Index id) {
    const Link& link = tissue_.links()[id];
    const Edge ends{link.first, link.second};
    add<DistanceConstraint>(sets_.distance_ids.of_link(id), ends,
                            {state_.places_of(ends), link_numbers(link, state_.options.mode)});
    stiffen(id);
  }

  // A link that vertex blocks cannot take as a spring, with ends as they are now.
  void stiffen(Index id) {
    const Edge ends{tissue_.links()[id].first, tissue_.links()[id].second};
    const auto numbers = stiff_link_numbers(tissue_, id, state_.options);
    if (numbers && !of<StiffLinkConstraint>().is_alive(id)) {
      add<StiffLinkConstraint>(id, ends, {state_.places_of(ends), *numbers});
    }
  }

  // A part's numbers, taken from the parent while that is there.
  struct Part {
    Index tet;
    std::optional<ConstraintRecord<VolumeConstraint>> volume;
    std::optional<ConstraintRecord<NeoHookeanConstraint>> neo_hookean;
    std::optional<ConstraintRecord<FibreConstraint>> fibre;
  };

  [[nodiscard]] Part part_of(Index tet, const NewTet& added, const Shares& shares) const {
    Part part{tet, {}, {}, {}};
    const Tet places = state_.places_of(added.vertices);
    if (of<VolumeConstraint>().is_alive(added.parent)) {
      part.volume = of<VolumeConstraint>().record(added.parent);
      part.volume->places = places;
      part.volume->parameters[VolumeConstraint::kRest] *= static_cast<float>(volume_share(shares));
    }
    if (of<NeoHookeanConstraint>().is_alive(added.parent)) {
      part.neo_hookean =
          make_part(of<NeoHookeanConstraint>().record(added.parent), sides_of(shares), places);
    }
    if (const Fibre& fibre = tissue_.fibre(tet); fibre.stiffness > 0) {
      part.fibre = {places, fibre_numbers(part.neo_hookean->parameters, fibre)};
    }
    return part;
  }

  // @param first_parent  of the removed tetrahedra
  void replace_parents(std::size_t first_parent) {
    std::pmr::vector<Part> parts(state_.scratch.get());
    std::pmr::vector<std::pair<Index, EdgeNumbers>> edges(state_.scratch.get());
    Index next_edge = change_.first_new_edge + static_cast<Index>(change_.parted_edges.size());
    for (std::size_t i = 0; i < change_.edit.new_tets.size(); ++i) {
      const NewTet& added = change_.edit.new_tets[i];
      const Index id = change_.first_new_tet + static_cast<Index>(i);
      const Shares shares =
          *find_shares(tissue_.tets()[added.parent], change_.edit, added, change_.first_new_vertex);
      std::array<EdgeNumbers, 6> of_parent;
      for (std::size_t e = 0; e < 6; ++e) {
        of_parent[e] = sets_.numbers_of_edge(tissue_.tet_edges()[added.parent][e]);
      }
      for (std::size_t e = 0; e < 6; ++e) {
        if (tissue_.tet_edges()[id][e] == next_edge) {
          const auto [a, b] = kTetEdges[e];
          edges.emplace_back(next_edge++, part_numbers(of_parent, shares[a], shares[b]));
        }
      }
      parts.push_back(part_of(id, added, shares));
    }
    remove_tets(first_parent, change_.removed_tets.size(), false);
    for (const Part& part : parts) {
      const Tet& vertices = tissue_.tets()[part.tet];
      if (part.volume) {
        add<VolumeConstraint>(part.tet, vertices, *part.volume);
      }
      if (part.neo_hookean) {
        add<NeoHookeanConstraint>(part.tet, vertices, *part.neo_hookean);
      }
      if (part.fibre) {
        add<FibreConstraint>(part.tet, vertices, *part.fibre);
      }
    }
    for (const auto& [edge, numbers] : edges) {
      add_edge(edge, numbers);
    }
  }

  void add_bodies() {
    const Scene& scene = change_.edit.new_bodies;
    if (scene.bodies().empty()) {
      return;
    }
    const Index first_vertex = change_.first_vertex_of_bodies();
    const Index first_tet =
        change_.first_new_tet + static_cast<Index>(change_.edit.new_tets.size());
    std::vector<Edge> edges;  // in vertices of the scene
    for (const Edge& edge :
         tissue_.edges().subspan(static_cast<std::size_t>(change_.first_new_edge))) {
      if (edge[0] >= first_vertex) {
        edges.push_back({edge[0] - first_vertex, edge[1] - first_vertex});
      }
    }
    const Index first_edge =
        static_cast<Index>(tissue_.edges().size()) - static_cast<Index>(edges.size());
    const ConstraintNumbers numbers = numbers_at_rest(scene, edges, state_.options.mode);
    sets_.has_damping = pbdsurg::has_damping(tissue_.bodies());

    std::vector<NewConstraint<VolumeConstraint>> volumes;
    std::vector<NewConstraint<NeoHookeanConstraint>> neo_hookeans;
    std::vector<NewConstraint<FibreConstraint>> fibres;
    for (std::size_t i = 0; i < numbers.tets.size(); ++i) {
      const Index id = first_tet + static_cast<Index>(i);
      const Tet& vertices = tissue_.tets()[id];
      const Tet places = state_.places_of(vertices);
      if (numbers.tets[i].volume) {
        volumes.push_back({id, vertices, {places, *numbers.tets[i].volume}});
      }
      if (numbers.tets[i].neo_hookean) {
        neo_hookeans.push_back({id, vertices, {places, *numbers.tets[i].neo_hookean}});
      }
      if (numbers.tets[i].fibre) {
        fibres.push_back({id, vertices, {places, *numbers.tets[i].fibre}});
      }
    }
    std::vector<NewConstraint<DistanceConstraint>> distances;
    std::vector<NewConstraint<StrainLimitConstraint>> limits;
    for (std::size_t i = 0; i < numbers.edges.size(); ++i) {
      const Index id = first_edge + static_cast<Index>(i);
      const Edge& vertices = tissue_.edges()[id];
      const Edge places = state_.places_of(vertices);
      if (numbers.edges[i].distance) {
        distances.push_back(
            {sets_.distance_ids.of_edge(id), vertices, {places, *numbers.edges[i].distance}});
      }
      if (numbers.edges[i].limit) {
        limits.push_back({id, vertices, {places, *numbers.edges[i].limit}});
      }
    }
    std::vector<NewConstraint<MembraneConstraint>> membranes;
    for (std::size_t i = 0; i < numbers.triangles.size(); ++i) {
      const Index id = change_.first_new_triangle + static_cast<Index>(i);
      const Triangle& vertices = tissue_.triangles()[id];
      membranes.push_back({id, vertices, {state_.places_of(vertices), *numbers.triangles[i]}});
    }
    std::vector<NewConstraint<BendingConstraint>> bendings;
    for (std::size_t i = 0; i < numbers.hinges.size(); ++i) {
      const Index id = change_.first_new_hinge + static_cast<Index>(i);
      const auto& vertices = tissue_.hinges()[id].vertices;
      bendings.push_back({id, vertices, {state_.places_of(vertices), *numbers.hinges[i]}});
    }
    add_apart(std::move(volumes));
    add_apart(std::move(distances));
    add_apart(std::move(neo_hookeans));
    add_apart(std::move(limits));
    add_apart(std::move(bendings));
    add_apart(std::move(membranes));
    add_apart(std::move(fibres));
  }

  // Adds constraints of vertices that have none yet: coloured by themselves, as those of a scene.
  template <class Constraint>
  void add_apart(std::vector<NewConstraint<Constraint>> added) {
    using Places = std::array<Index, Constraint::kVertexCount>;
    std::ranges::stable_sort(added, {}, [](const NewConstraint<Constraint>& each) {
      return std::ranges::min(each.record.places);  // as those of a scene lie
    });
    const Index first = change_.first_vertex_of_bodies();
    std::vector<Places> places;
    for (const NewConstraint<Constraint>& each : added) {
      places.push_back(each.record.places);
      for (Index& place : places.back()) {
        place -= first;  // new places follow the others, as new vertices do
      }
    }
    const Coloring coloring = color_constraints(
        {std::span<const Places>(places), tissue_.vertex_count() - first}, state_.options.coloring);
    std::vector<Index> groups = joinable_groups(sets_, KindOf<Constraint>::kPhase);
    while (groups.size() < static_cast<std::size_t>(coloring.color_count)) {
      groups.push_back(groups_.open<Constraint>());
    }
    const auto is_over = [&](std::size_t i) { return coloring.color_of[i] == kOverflowColor; };
    for (std::size_t i = 0; i < added.size(); ++i) {
      if (!is_over(i)) {
        of<Constraint>().add(added[i].id, groups[coloring.color_of[i]], added[i].record);
        log<Constraint>(added[i].id);
      }
    }
    for (std::size_t i = 0; i < added.size(); ++i) {
      if (is_over(i)) {
        add<Constraint>(added[i].id, added[i].vertices, added[i].record);
      }
    }
  }

  ConstraintSets& sets_;
  SolverState& state_;
  const Tissue& tissue_;
  const TissueChange& change_;
  FreeGroups groups_;
  using Reshaped = std::pair<Index, Index>;  // tetrahedron, entry of reshaped_tets
  std::pmr::vector<Reshaped> reshaped_;      // ascending
};

void ConstraintSets::follow(const Tissue& tissue, const TissueChange& change) noexcept {
  for_each_set([](auto& set) { set.begin_edit(); });
  edge_owners.begin_edit();
  opened_groups_.clear();
  has_grown_ = change.adds();
  for (auto e = static_cast<std::size_t>(change.first_new_edge); e < tissue.edges().size(); ++e) {
    distance_ids.add_edge();
  }
  for (auto l = static_cast<std::size_t>(change.first_new_link); l < tissue.links().size(); ++l) {
    distance_ids.add_link();
  }
  Edit(*this, tissue, change).run();
  finish();
}

void ConstraintSets::undo(const Tissue& tissue, const TissueChange& change) noexcept {
  const auto undo_set = [&]<class Constraint>(ConstraintSlots<Constraint>& set) {
    set.undo([&](Index id) { state_.log_constraint(KindOf<Constraint>::kPhase, id); });
  };
  for_each_set(undo_set);
  edge_owners.undo();
  if (!change.edit.new_bodies.bodies().empty()) {
    has_damping = pbdsurg::has_damping(tissue.bodies());
  }
  distance_ids.shrink(static_cast<std::size_t>(change.first_new_edge),
                      static_cast<std::size_t>(change.first_new_link));
  for (; !opened_groups_.empty(); opened_groups_.pop_back()) {
    close_group(*this, opened_groups_.back());
  }
  finish();
}

void ConstraintSets::finish() {
  has_other_phases_ = has_grown_;
  for_each_set([&](auto& set) { has_other_phases_ |= set.take_change_of_groups(); });
  if (has_grown_) {
    state_.log_growth();
  }
}

}  // namespace pbdsurg
