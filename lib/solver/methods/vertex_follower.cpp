// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/vertex_follower.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "pbdsurg/tissue/tissue_change.h"

#include "lib/solver/methods/vertex_elements.h"
#include "lib/solver/methods/vertex_method.h"
#include "lib/solver/sets/membrane_record.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/solver_data.h"
#include "lib/tissue/hinges.h"

namespace pbdsurg {
namespace {

// Vertices that come in an edit, as a share of all: beyond, rows are laid out anew, in the colours
// of a fresh start.
constexpr double kMostNewVertices = 0.25;

}  // namespace

void VertexFollower::validate(const Tissue&, const TopologyEdit& edit) const {
  check_vertex_method(edit.new_bodies.bodies(), data_.options);
}

void VertexFollower::follow(const Tissue& tissue, const TissueChange& change) noexcept {
  if (!moves_vertices(data_.options)) {
    return;
  }
  VertexBlocks& blocks = data_.vertex_blocks;
  if (has_coarse_correction(data_.options)) {
    data_.coarse_space.add(change.edit.new_vertices, data_.place_of_vertex);
    data_.coarse_space.resize(data_.particles.size());
  }
  blocks.begin_edit();
  before_growth_.reset();
  has_grown_ = change.adds();
  double longest = 0;  // m, of what is there now
  for (const RestLengthChange& rest : change.edit.rest_lengths) {
    blocks.set_spring_rest(data_.sets.distance_ids.of_edge(rest.edge), rest.rest_length);
    set_limit(tissue, rest.edge);
    longest = std::max(longest, double{rest.rest_length});
  }
  for (const RestVolumeChange& rest : change.edit.rest_volumes) {
    const Material& material = tissue.bodies()[tissue.body_of_tet(rest.tet)].material;
    VertexTet tet = resized(blocks.tet(rest.tet), material, rest.rest_volume);
    set_fibre(data_, rest.tet, tet);
    blocks.set_tet(rest.tet, tet);
    for (const Index edge : tissue.tet_edges()[rest.tet]) {
      set_limit(tissue, edge);
    }
    longest = std::max(longest, edge_of_volume(rest.rest_volume));
  }
  for (const LinkLengthChange& length : change.edit.link_lengths) {
    blocks.set_spring_rest(data_.sets.distance_ids.of_link(length.link), length.rest_length);
    longest = std::max(longest, double{length.rest_length});
  }
  remove(change);
  if (has_grown_ && !grow(tissue, change)) {
    regrow(tissue, change);
  }
  for (const StiffnessChange& stiffness : change.edit.stiffnesses) {
    if (tissue.is_tet_alive(stiffness.tet)) {
      blocks.set_tet(stiffness.tet, vertex_tet(data_, tissue, stiffness.tet));
    }
  }
  // with its hinges, which are pulls or not as it resists stretch
  const auto set_triangle = [&](Index triangle) {
    blocks.set_triangle(triangle, vertex_triangle(data_, tissue, triangle));
    for_each_hinge_of(tissue_data(tissue), tissue.triangles()[triangle], [&](Index hinge) {
      blocks.set_hinge(hinge, vertex_hinge(data_, tissue, hinge));
    });
  };
  for (const RestAreaChange& rest : change.edit.rest_areas) {
    if (tissue.is_triangle_alive(rest.triangle)) {
      set_triangle(rest.triangle);
      const auto& membranes = data_.sets.of<MembraneConstraint>();
      longest = std::max(longest, longest_side(membranes.record(rest.triangle)));
    }
  }
  for (const TriangleStiffnessChange& stiffness : change.edit.triangle_stiffnesses) {
    if (tissue.is_triangle_alive(stiffness.triangle)) {
      set_triangle(stiffness.triangle);
    }
  }
  for (const FibreChange& fibre : change.edit.fibres) {
    if (tissue.is_tet_alive(fibre.tet)) {
      VertexTet tet = blocks.tet(fibre.tet);
      set_fibre(data_, fibre.tet, tet);
      blocks.set_tet(fibre.tet, tet);
    }
  }
  blocks.set_unit(wide_enough(blocks.unit(), longest));
  refresh();
}

// What came and went in one edit, it has never had.
void VertexFollower::remove(const TissueChange& change) {
  VertexBlocks& blocks = data_.vertex_blocks;
  const auto is_known = [](Index id, const auto& known) {
    return id < static_cast<Index>(known.size());
  };
  const auto remove_spring = [&](Index spring) {
    if (is_known(spring, blocks.springs())) {
      blocks.remove_spring(spring);
    }
  };
  for (const Index tet : change.removed_tets) {
    if (is_known(tet, blocks.tets())) {
      blocks.remove_tet(tet);
    }
  }
  for (const Index edge : change.removed_edges) {
    remove_spring(data_.sets.distance_ids.of_edge(edge));
  }
  for (const Index link : change.removed_links) {
    remove_spring(data_.sets.distance_ids.of_link(link));
  }
  for (const Index triangle : change.removed_triangles) {
    if (is_known(triangle, blocks.triangles())) {
      blocks.remove_triangle(triangle);
    }
  }
  for (const Index hinge : change.removed_hinges) {
    if (is_known(hinge, blocks.hinges())) {
      blocks.remove_hinge(hinge);
    }
  }
}

void VertexFollower::set_limit(const Tissue& tissue, Index edge) {
  const VertexSpring spring = edge_spring(data_, tissue, edge);
  const Index distance = data_.sets.distance_ids.of_edge(edge);
  const auto known = static_cast<Index>(data_.vertex_blocks.springs().size());
  if (spring.limit_stiffness > 0 && distance < known) {  // else it is new, and comes with others
    data_.vertex_blocks.set_limit(distance, spring.limit_stiffness, spring.limit);
  }
}

bool VertexFollower::grow(const Tissue& tissue, const TissueChange& change) {
  VertexBlocks& blocks = data_.vertex_blocks;
  const auto place_count = static_cast<Index>(data_.particles.size());
  const Index new_places = place_count - blocks.vertex_count();
  if (new_places > kMostNewVertices * place_count ||
      (data_.sets.has_damping && !blocks.has_damping())) {
    return false;
  }
  blocks.add_vertices(place_count);
  for (Index place = place_count - new_places; place < place_count; ++place) {
    set_free(place);
    data_.log_constraint(PhaseKind::vertex, place);  // also where no block has it
  }
  // what has other vertices now
  for (const ReshapedTet& reshaped : change.reshaped_tets) {
    if (reshaped.tet < change.first_new_tet && tissue.is_tet_alive(reshaped.tet)) {
      VertexTet tet = blocks.tet(reshaped.tet);
      tet.vertices = data_.places_of(tissue.tets()[reshaped.tet]);
      if (tet.vertices != blocks.tet(reshaped.tet).vertices) {
        blocks.set_tet(reshaped.tet, tet);
      }
    }
  }
  const auto set_edge = [&](Index edge) {
    blocks.set_spring(data_.sets.distance_ids.of_edge(edge), edge_spring(data_, tissue, edge));
  };
  std::ranges::for_each(change.moved_edges, set_edge);
  for (const LinkMove& move : change.edit.link_moves) {
    blocks.set_spring(data_.sets.distance_ids.of_link(move.link),
                      link_spring(data_, tissue, move.link));
  }
  for (const TriangleMove& move : change.edit.triangle_moves) {
    blocks.set_triangle(move.triangle, vertex_triangle(data_, tissue, move.triangle));
  }
  for (const Index hinge : change.moved_hinges) {
    blocks.set_hinge(hinge, vertex_hinge(data_, tissue, hinge));
  }
  for (const Index v : change.edit.unfix_vertices) {
    set_free(data_.place_of_vertex[v]);
    for (const Index l : tissue.links_at(v)) {  // which may have phases of its own now
      if (l < change.first_new_link) {
        blocks.set_spring(data_.sets.distance_ids.of_link(l), link_spring(data_, tissue, l));
      }
    }
  }
  // what is new
  std::vector<VertexTet> tets;
  for (Index t = change.first_new_tet; t < static_cast<Index>(tissue.tets().size()); ++t) {
    tets.push_back(vertex_tet(data_, tissue, t));
    blocks.add_tet(tets.back());
  }
  const auto known = static_cast<Index>(blocks.springs().size());
  std::vector<VertexSpring> springs(
      static_cast<std::size_t>(data_.sets.distance_ids.count() - known));
  for (Index e = change.first_new_edge; e < static_cast<Index>(tissue.edges().size()); ++e) {
    springs[data_.sets.distance_ids.of_edge(e) - known] = edge_spring(data_, tissue, e);
  }
  for (Index l = change.first_new_link; l < static_cast<Index>(tissue.links().size()); ++l) {
    springs[data_.sets.distance_ids.of_link(l) - known] = link_spring(data_, tissue, l);
  }
  for (const VertexSpring& spring : springs) {
    blocks.add_spring(spring);
  }
  std::vector<VertexTriangle> triangles;
  for (Index t = change.first_new_triangle; t < static_cast<Index>(tissue.triangles().size());
       ++t) {
    triangles.push_back(vertex_triangle(data_, tissue, t));
    blocks.add_triangle(triangles.back());
  }
  for (Index h = change.first_new_hinge; h < static_cast<Index>(tissue.hinges().size()); ++h) {
    blocks.add_hinge(vertex_hinge(data_, tissue, h));
  }
  const auto free_ends = [&](const auto& elements) {
    for (const auto& element : elements) {
      std::ranges::for_each(element.vertices, [&](Index place) { set_free(place); });
    }
  };
  free_ends(tets);
  free_ends(springs);
  free_ends(triangles);
  blocks.set_unit(wide_enough(blocks.unit(), tissue, change, tets, springs));
  return true;
}

// Of a vertex that has tissue again, too.
void VertexFollower::set_free(Index place) {
  if (data_.particles[place].w > 0) {
    data_.vertex_blocks.set_free(place);
  }
}

void VertexFollower::regrow(const Tissue& tissue, const TissueChange& change) {
  VertexBlocks& blocks = data_.vertex_blocks;
  std::vector<VertexTet> tets(tissue.tets().size());
  for (Index t = 0; t < static_cast<Index>(tets.size()); ++t) {
    if (tissue.is_tet_alive(t)) {
      tets[t] = t < change.first_new_tet ? blocks.tet(t) : vertex_tet(data_, tissue, t);
    }
  }
  VertexBlocks grown = make_vertex_blocks(data_, std::move(tets));
  before_growth_ = std::move(blocks);
  blocks = std::move(grown);
}

void VertexFollower::undo(const Tissue&, const TissueChange&) noexcept {
  if (!moves_vertices(data_.options)) {
    return;
  }
  if (has_coarse_correction(data_.options)) {
    data_.coarse_space.resize(data_.particles.size());
  }
  if (before_growth_) {
    data_.vertex_blocks = std::move(*before_growth_);
  }
  data_.vertex_blocks.undo();
  refresh();  // as of the growth
  before_growth_.reset();
}

void VertexFollower::refresh() {
  VertexBlocks& blocks = data_.vertex_blocks;
  blocks.refresh();
  ++data_.rows_revision;
  const bool are_anew = before_growth_.has_value();
  data_.log_rows(blocks, are_anew);
  if (is_explicit(data_.options)) {
    if (are_anew) {
      data_.stable_substep.measure(data_);
      return;
    }
    if (has_grown_) {
      data_.stable_substep.fit(data_);
    }
    data_.stable_substep.measure(data_, blocks.refreshed());
    data_.log_shares(data_.stable_substep.measured());
  }
}

}  // namespace pbdsurg
