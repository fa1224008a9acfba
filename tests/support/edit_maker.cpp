// SPDX-License-Identifier: Apache-2.0
#include "tests/support/edit_maker.h"

#include <algorithm>
#include <array>
#include <utility>

#include "tests/support/cuts.h"
#include "tests/support/inspect.h"
#include "tests/support/random_bodies.h"

namespace pbdsurg::testing {
namespace {

constexpr Stiffness kLink{0.5F, 1e-3F};

}  // namespace

CutPlan make_cut(const Solver& solver, const CutFront& front, Choices& choices) {
  const auto is_alive = [&](Index t) { return solver.tissue().is_tet_alive(t); };
  const std::vector<Index> tets = find_all(solver.tissue().tets().size(), is_alive);
  if (tets.empty()) {
    return {};
  }
  const std::vector<Eigen::Vector3f> x = solver.positions();
  const Tet& tet = solver.tissue().tets()[choices.one_of(tets)];
  const Eigen::Vector3f middle = (x[tet[0]] + x[tet[1]] + x[tet[2]] + x[tet[3]]) / 4;
  const float edge = std::max((x[tet[1]] - x[tet[0]]).norm(), (x[tet[2]] - x[tet[3]]).norm());
  const auto direction = [&] {
    Eigen::Vector3f way;
    for (int axis = 0; axis < 3; ++axis) {
      way[axis] = static_cast<float>(choices.share() - 0.5);
    }
    const float length = edge * static_cast<float>(1 + 3 * choices.share());
    return Eigen::Vector3f(length * (way + Eigen::Vector3f::Constant(1e-3F)).normalized());
  };
  const Eigen::Vector3f along = direction(), way = direction();
  const auto blade_at = [&](const Eigen::Vector3f& center) {
    return BladeEdge{center - along / 2, center + along / 2};
  };
  const std::array instants{blade_at(middle - way / 2), blade_at(middle + way / 2)};
  CutOptions options{
      .style = choices.below(3) == 0 ? CutStyle::along_faces : CutStyle::through_tets,
      .snap = choices.one_of(std::array{0.05F, 0.2F, 0.4F}),
      .front = front};
  return plan_cut(solver, sweep_blade(instants), options);
}

EditMaker::EditMaker(const Solver& solver, Choices& choices, TopologyEdit edit)
    : solver_(solver),
      choices_(choices),
      edit_(std::move(edit)),
      uses_(solver.tissue().tets().size()),
      triangle_uses_(solver.tissue().triangles().size()) {
  for (const Index t : edit_.remove_triangles) {
    triangle_uses_[t] = Use::gone;
  }
  for (const TriangleMove& move : edit_.triangle_moves) {
    triangle_uses_[move.triangle] = Use::moved;
  }
  for (const Index t : edit_.remove_tets) {
    uses_[t] = Use::gone;
  }
  for (const CornerMove& move : edit_.corner_moves) {
    uses_[move.tet] = Use::moved;
  }
  for (const NewTet& tet : edit_.new_tets) {
    uses_[tet.parent] = Use::gone;
  }
}

void EditMaker::add() {
  switch (choices_.below(20)) {
    case 0:
      remove_bodies();
      break;
    case 1:
    case 2:
      add_bodies();
      break;
    case 3:
    case 4:
      remove_links();
      break;
    case 5:
    case 6:
      change_rest_lengths();
      break;
    case 7:
    case 8:
      change_rest_volumes();
      change_rest_areas();
      break;
    case 9:
    case 10:
    case 11:
    case 12:
      part_vertex();
      break;
    case 13:
    case 14:
    case 15:
      split_edge();
      break;
    case 16:
      if (!remove_triangles()) {
        remove_tets();
      }
      break;
    case 17:
      if (!part_sheet()) {
        remove_tets();
      }
      break;
    default:
      remove_tets();
  }
}

std::vector<Index> EditMaker::free_triangles() const {
  return find_all(triangle_uses_.size(), [&](Index t) {
    return solver_.tissue().is_triangle_alive(t) && triangle_uses_[t] == Use::none;
  });
}

// @return  whether there are any
bool EditMaker::remove_triangles() {
  const std::vector<Index> triangles = free_triangles();
  if (triangles.empty()) {
    return false;
  }
  for (const Index t : pick_some(triangles, 4, choices_)) {
    edit_.remove_triangles.push_back(t);
    triangle_uses_[t] = Use::gone;
  }
  return true;
}

// What is around a vertex of a sheet stays, or goes with a copy of it.
// @return  whether there is any
bool EditMaker::part_sheet() {
  const std::vector<Index> triangles = free_triangles();
  if (triangles.empty()) {
    return false;
  }
  const Index vertex = solver_.tissue().triangles()[choices_.one_of(triangles)][choices_.below(3)];
  Index copy = kInvalidIndex;
  for (const Index t : triangles) {
    const Triangle& corners = solver_.tissue().triangles()[t];
    if (std::ranges::find(corners, vertex) == corners.end() || choices_.below(2) == 0) {
      continue;
    }
    if (copy == kInvalidIndex) {
      copy = add_vertex(vertex, vertex, 0);
    }
    edit_.triangle_moves.push_back({t, vertex, copy});
    triangle_uses_[t] = Use::moved;
  }
  return true;
}

std::vector<Index> EditMaker::free_tets() const {
  return find_all(uses_.size(), [&](Index t) {
    return solver_.tissue().is_tet_alive(t) && uses_[t] == Use::none;
  });
}

std::vector<Index> EditMaker::tets_at(Index vertex) const {
  return find_all(uses_.size(), [&](Index t) {
    return solver_.tissue().is_tet_alive(t) && has_corner(solver_.tissue().tets()[t], vertex);
  });
}

bool EditMaker::is_link_free(Index link) const {
  return solver_.tissue().is_link_alive(link) &&
         std::ranges::count(edit_.remove_links, link) == 0 &&
         std::ranges::count(edit_.link_moves, link, &LinkMove::link) == 0;
}

Index EditMaker::add_vertex(Index first, Index second, float share) {
  edit_.new_vertices.push_back({first, second, share});
  return solver_.vertex_count() + static_cast<Index>(edit_.new_vertices.size()) - 1;
}

// A few, or all around a vertex.
void EditMaker::remove_tets() {
  std::vector<Index> tets = free_tets();
  if (tets.empty()) {
    return;
  }
  if (choices_.below(3) == 0) {
    const Index vertex = solver_.tissue().tets()[choices_.one_of(tets)][choices_.below(4)];
    std::erase_if(tets, [&](Index t) { return !has_corner(solver_.tissue().tets()[t], vertex); });
  } else {
    tets = pick_some(std::move(tets), 6, choices_);
  }
  for (const Index t : tets) {
    edit_.remove_tets.push_back(t);
    uses_[t] = Use::gone;
  }
}

void EditMaker::remove_links() {
  const auto is_free = [&](Index l) { return is_link_free(l); };
  for (const Index l : pick_some(find_all(solver_.tissue().links().size(), is_free), 3, choices_)) {
    edit_.remove_links.push_back(l);
  }
}

void EditMaker::change_rest_lengths() {
  const SolverData& data = inspect(solver_);
  const auto is_spring = [&](Index e) {
    return data.sets.of<DistanceConstraint>().is_alive(data.sets.distance_ids.of_edge(e));
  };
  edit_.rest_lengths.clear();
  for (const Index e : pick_some(find_all(data.tissue->edges().size(), is_spring), 5, choices_)) {
    const float factor = 0.8F + 0.1F * static_cast<float>(choices_.below(5));
    edit_.rest_lengths.push_back({e, factor * solver_.rest_length(e)});
  }
}

void EditMaker::change_rest_volumes() {
  const SolverData& data = inspect(solver_);
  const auto has_volume = [&](Index t) {
    return data.sets.of<VolumeConstraint>().is_alive(t) ||
           data.sets.of<NeoHookeanConstraint>().is_alive(t);
  };
  edit_.rest_volumes.clear();
  for (const Index t : pick_some(find_all(data.tissue->tets().size(), has_volume), 5, choices_)) {
    const float factor = 0.8F + 0.1F * static_cast<float>(choices_.below(5));
    edit_.rest_volumes.push_back({t, factor * solver_.rest_volume(t)});
  }
}

void EditMaker::change_rest_areas() {
  const auto is_alive = [&](Index t) { return solver_.tissue().is_triangle_alive(t); };
  const std::vector<Index> triangles = find_all(triangle_uses_.size(), is_alive);
  if (triangles.empty()) {
    return;
  }
  edit_.rest_areas.clear();
  for (const Index t : pick_some(triangles, 5, choices_)) {
    const float factor = 0.8F + 0.1F * static_cast<float>(choices_.below(5));
    edit_.rest_areas.push_back({t, factor * solver_.rest_area(t)});
  }
}

// What is around a vertex goes with it or with one of a few copies, links there, too.
void EditMaker::part_vertex() {
  std::vector<Index> tets = free_tets();
  if (tets.empty()) {
    return;
  }
  const Index vertex = solver_.tissue().tets()[choices_.one_of(tets)][choices_.below(4)];
  std::array<Index, 3> holders{vertex, kInvalidIndex, kInvalidIndex};
  const Index holder_count = 2 + choices_.below(2);
  for (const Index t : tets_at(vertex)) {
    const auto is_this = [&](const CornerMove& move) {
      return move.tet == t && move.from == vertex;
    };
    const Index holder = choices_.below(holder_count);
    if (holder == 0 || uses_[t] == Use::gone || std::ranges::any_of(edit_.corner_moves, is_this)) {
      continue;
    }
    if (holders[holder] == kInvalidIndex) {
      holders[holder] = add_vertex(vertex, vertex, 0);
    }
    edit_.corner_moves.push_back({t, vertex, holders[holder]});
    uses_[t] = Use::moved;
  }
  for (Index l = 0; l < static_cast<Index>(solver_.tissue().links().size()); ++l) {
    const Link& link = solver_.tissue().links()[l];
    if (is_link_free(l) && (link.first == vertex || link.second == vertex)) {
      const Index holder = choices_.below(holder_count);
      if (holder > 0 && holders[holder] != kInvalidIndex) {
        edit_.link_moves.push_back({l, vertex, holders[holder]});
      }
    }
  }
}

// All tetrahedra around an edge are bisected, and sometimes part there.
void EditMaker::split_edge() {
  const std::vector<Index> tets = free_tets();
  if (tets.empty()) {
    return;
  }
  const Tet& tet = solver_.tissue().tets()[choices_.one_of(tets)];
  const auto [i, j] = choices_.one_of(kTetEdges);
  const Index a = tet[i], b = tet[j];
  std::vector<Index> ring = tets_at(a);
  std::erase_if(ring, [&](Index t) { return !has_corner(solver_.tissue().tets()[t], b); });
  if (std::ranges::any_of(ring, [&](Index t) { return uses_[t] != Use::none; })) {
    return;
  }
  const float share = choices_.one_of(std::array{0.1F, 0.3F, 0.5F, 0.6F, 0.9F});
  const Index near_a = add_vertex(a, b, share);
  const Index near_b = choices_.below(3) == 0 ? add_vertex(a, b, share) : near_a;
  for (const Index t : ring) {
    for (const auto& [gone, middle] : {std::pair(b, near_a), std::pair(a, near_b)}) {
      NewTet part{t, solver_.tissue().tets()[t]};
      std::ranges::replace(part.vertices, gone, middle);
      edit_.new_tets.push_back(part);
    }
    uses_[t] = Use::gone;
  }
}

void EditMaker::add_bodies() {
  if (edit_.new_bodies.bodies().empty()) {
    edit_.new_bodies = make_bodies(solver_, choices_);
  }
}

// Of which the edit has taken nothing.
void EditMaker::remove_bodies() {
  const auto is_free = [&](Index b) {
    if (!solver_.tissue().is_body_alive(b) || std::ranges::count(edit_.remove_bodies, b) > 0) {
      return false;
    }
    for (std::size_t t = 0; t < uses_.size(); ++t) {
      if (uses_[t] != Use::none && solver_.tissue().body_of_tet(static_cast<Index>(t)) == b) {
        return false;
      }
    }
    for (std::size_t t = 0; t < triangle_uses_.size(); ++t) {
      if (triangle_uses_[t] != Use::none &&
          solver_.tissue().body_of_triangle(static_cast<Index>(t)) == b) {
        return false;
      }
    }
    return true;
  };
  for (const Index b :
       pick_some(find_all(solver_.tissue().bodies().size(), is_free), 2, choices_)) {
    edit_.remove_bodies.push_back(b);
    for (std::size_t t = 0; t < uses_.size(); ++t) {
      if (solver_.tissue().body_of_tet(static_cast<Index>(t)) == b) {
        uses_[t] = Use::gone;
      }
    }
    for (std::size_t t = 0; t < triangle_uses_.size(); ++t) {
      if (solver_.tissue().body_of_triangle(static_cast<Index>(t)) == b) {
        triangle_uses_[t] = Use::gone;
      }
    }
  }
}

// Between what has tissue whatever the edit does, or comes with it.
// With tissue that the edit does not touch.
std::vector<Index> EditMaker::lasting_vertices() const {
  std::vector<Index> vertices = find_all(static_cast<std::size_t>(solver_.vertex_count()),
                                         [&](Index v) { return solver_.tissue().has_tissue(v); });
  std::vector<bool> may_stop(static_cast<std::size_t>(solver_.vertex_count()));
  for (std::size_t t = 0; t < uses_.size(); ++t) {
    for (const Index v : solver_.tissue().tets()[t]) {
      may_stop[v] = may_stop[v] || uses_[t] != Use::none;
    }
  }
  for (std::size_t t = 0; t < triangle_uses_.size(); ++t) {
    for (const Index v : solver_.tissue().triangles()[t]) {
      may_stop[v] = may_stop[v] || triangle_uses_[t] != Use::none;
    }
  }
  std::erase_if(vertices, [&](Index v) {
    return may_stop[v] ||
           std::ranges::count(edit_.remove_bodies, solver_.tissue().body_of_vertex(v)) > 0;
  });
  return vertices;
}

void EditMaker::fix_some() {
  if (choices_.below(3) > 0) {
    return;
  }
  for (const Index v : pick_some(lasting_vertices(), 6, choices_)) {
    (solver_.tissue().is_fixed(v) ? edit_.unfix_vertices : edit_.fix_vertices).push_back(v);
  }
  std::vector<Index> solids = free_tets();
  std::erase_if(solids, [&](Index t) {
    const Body& body = solver_.tissue().bodies()[solver_.tissue().body_of_tet(t)];
    return body.material.model != ElasticModel::neo_hookean;
  });
  for (const Index t : pick_some(solids, 5, choices_)) {
    edit_.stiffnesses.push_back({t, 0.5F * static_cast<float>(1 + choices_.below(5))});
  }
  if (has_fibres(solver_.tissue())) {
    for (const Index t : pick_some(std::move(solids), 5, choices_)) {
      edit_.fibres.push_back({t, make_fibre(choices_)});
    }
  }
  const auto has_triangle = [&](Index t) { return solver_.tissue().is_triangle_alive(t); };
  const std::vector<Index> triangles = find_all(triangle_uses_.size(), has_triangle);
  if (!triangles.empty()) {
    for (const Index t : pick_some(triangles, 5, choices_)) {
      edit_.triangle_stiffnesses.push_back({t, 0.5F * static_cast<float>(1 + choices_.below(5))});
    }
  }
  const auto is_free = [&](Index l) { return is_link_free(l); };
  for (const Index l : pick_some(find_all(solver_.tissue().links().size(), is_free), 3, choices_)) {
    edit_.link_lengths.push_back({l, 1e-3F * static_cast<float>(choices_.below(4))});
  }
}

void EditMaker::add_links() {
  std::vector<Index> ends = lasting_vertices();
  const Index first_new = solver_.vertex_count();
  const Index first_of_bodies = first_new + static_cast<Index>(edit_.new_vertices.size());
  for (Index v = first_new; v < first_of_bodies; ++v) {
    ends.push_back(v);
  }
  for (const Index v : vertices_with_tissue(edit_.new_bodies)) {
    ends.push_back(first_of_bodies + v);
  }
  for (Index count = choices_.below(3); count >= 0; --count) {
    const std::vector<Index> pair = pick_some(ends, 2, choices_);
    if (pair.size() == 2) {
      Stiffness stiffness = kLink;
      if (choices_.below(2) == 0) {
        stiffness.compliance = 0;
      }
      edit_.new_links.push_back({pair[0], pair[1], 2e-3F, stiffness});
    }
  }
}

}  // namespace pbdsurg::testing
