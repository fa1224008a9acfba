// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/thermal/heat_field.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "pbdsurg/core/error.h"
#include "pbdsurg/mesh/topology.h"

namespace pbdsurg {
namespace {

void check_positive(const char* what, double value) {
  if (!(value > 0) || !std::isfinite(value)) {
    throw InvalidArgument(std::string(what) + " is " + std::to_string(value) +
                          "; it must be positive and finite");
  }
}

// Conductance of the six edges of a tetrahedron: -k V grad N_i . grad N_j, W/K.
std::array<double, 6> edge_conductances(std::span<const Eigen::Vector3d> x, const Tet& tet,
                                        double conductivity) {
  const double volume = tet_volume(x, tet);
  std::array<Eigen::Vector3d, 4> gradients;
  for (int i = 0; i < 4; ++i) {
    const auto& [a, b, c] = kTetTriangles[i];
    // inward area vector of the opposite face over three volumes
    gradients[i] = (x[tet[c]] - x[tet[a]]).cross(x[tet[b]] - x[tet[a]]) / (6 * volume);
  }
  std::array<double, 6> result;
  for (std::size_t e = 0; e < 6; ++e) {
    result[e] = -conductivity * volume * gradients[kTetEdges[e][0]].dot(gradients[kTetEdges[e][1]]);
  }
  return result;
}

}  // namespace

HeatField::HeatField(const TetMesh& mesh, const TissueProperties& tissue, const Body& place)
    : tissue_(tissue),
      vertex_ids_{place.first_vertex, mesh.vertex_count()},
      tet_ids_{place.first_tet, mesh.tet_count()},
      rest_positions_(mesh.positions().begin(), mesh.positions().end()),
      tets_(mesh.tets().begin(), mesh.tets().end()),
      edges_(find_edges(tets_)),
      tet_edges_(pbdsurg::find_tet_edges(tets_, edges_)),
      first_corners_(rest_positions_.size(), kInvalidIndex),
      temperatures_(rest_positions_.size(), kBodyTemperature),
      peaks_(temperatures_),
      water_(rest_positions_.size(), 1.0) {
  check_positive("tissue density", tissue.density);
  check_positive("tissue specific heat", tissue.specific_heat);
  check_positive("tissue conductivity", tissue.conductivity);
  if (!(tissue.water_fraction >= 0) || !(tissue.water_fraction <= 1)) {
    throw InvalidArgument("tissue water fraction is " + std::to_string(tissue.water_fraction) +
                          "; it must be in [0, 1]");
  }
  resize(rest_positions_.size(), tets_.size(), edges_.size());
  // backwards: lists ascend, and each tetrahedron goes to their fronts
  for (auto t = static_cast<Index>(tets_.size()) - 1; t >= 0; --t) {
    tet_masses_[t] = tissue.density * tet_volume(rest_positions_, tets_[t]);
    tet_conductances_[t] = edge_conductances(rest_positions_, tets_[t], tissue.conductivity);
    link_tet(t);
  }
  for (std::size_t v = 0; v < capacities_.size(); ++v) {
    sum_vertex(static_cast<Index>(v));
  }
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    sum_edge(static_cast<Index>(e));
  }
}

HeatField::HeatField(const TetMesh& mesh, const TissueProperties& tissue, const Solver& solver,
                     Index body)
    : HeatField(mesh, tissue, solver.body(body)) {
  followed_ = FollowedVersion(solver);
  const Body& place = solver.body(body);
  bool is_whole = mesh.vertex_count() == place.vertex_count && mesh.tet_count() == place.tet_count;
  for (Index t = 0; t < mesh.tet_count() && is_whole; ++t) {
    Tet tet = mesh.tets()[t];
    for (Index& v : tet) {
      v += place.first_vertex;
    }
    is_whole =
        solver.is_tet_alive(place.first_tet + t) && solver.tets()[place.first_tet + t] == tet;
  }
  if (!is_whole) {
    throw InvalidArgument("body '" + place.name +
                          "' is not of the mesh given, or edits have changed it");
  }
}

Index HeatField::SceneIds::find(Index scene_id) const {
  if (scene_id >= first && scene_id < first + count) {
    return scene_id - first;
  }
  const auto found = std::lower_bound(added.begin(), added.end(), scene_id);
  return found != added.end() && *found == scene_id
             ? count + static_cast<Index>(found - added.begin())
             : kInvalidIndex;
}

void HeatField::resize(std::size_t vertex_count, std::size_t tet_count, std::size_t edge_count) {
  rest_positions_.resize(vertex_count);
  first_corners_.resize(vertex_count, kInvalidIndex);
  capacities_.resize(vertex_count);
  temperatures_.resize(vertex_count);
  peaks_.resize(vertex_count);
  water_.resize(vertex_count);
  flows_.resize(vertex_count);
  tets_.resize(tet_count);
  tet_edges_.resize(tet_count);
  tet_conductances_.resize(tet_count);
  tet_masses_.resize(tet_count);
  next_corners_.resize(tet_count);
  edges_.resize(edge_count);
  conductances_.resize(edge_count);
  limited_.resize(edge_count);
}

// Calls visit(tet) for each live tetrahedron at a vertex.
template <class Visit>
void HeatField::visit_tets(Index vertex, Visit visit) const {
  for (Index corner = first_corners_[vertex]; corner != kInvalidIndex;
       corner = next_corners_[corner / 4][corner % 4]) {
    visit(corner / 4);
  }
}

void HeatField::link_tet(Index tet) noexcept {
  for (Index k = 0; k < 4; ++k) {
    Index* link = &first_corners_[tets_[tet][k]];
    while (*link != kInvalidIndex && *link < 4 * tet) {
      link = &next_corners_[*link / 4][*link % 4];
    }
    next_corners_[tet][k] = *link;
    *link = 4 * tet + k;
  }
}

void HeatField::unlink_tet(Index tet) noexcept {
  for (Index k = 0; k < 4; ++k) {
    Index* link = &first_corners_[tets_[tet][k]];
    while (*link != 4 * tet + k) {
      link = &next_corners_[*link / 4][*link % 4];
    }
    *link = next_corners_[tet][k];
  }
}

// Summed afresh from the live tetrahedra: subtracting would drift, and a vertex or an edge without
// tissue must hold and conduct exactly nothing.
void HeatField::sum_vertex(Index vertex) noexcept {
  double sum = 0;
  visit_tets(vertex, [&](Index t) { sum += tet_masses_[t] * tissue_.specific_heat / 4; });
  capacities_[vertex] = sum;
}

void HeatField::sum_edge(Index edge) noexcept {
  double sum = 0;
  visit_tets(edges_[edge][0], [&](Index t) {
    for (std::size_t k = 0; k < 6; ++k) {
      sum += tet_edges_[t][k] == edge ? tet_conductances_[t][k] : 0;
    }
  });
  conductances_[edge] = std::max(sum, 0.0);
}

void HeatField::sum_tet(Index tet) noexcept {
  for (const Index v : tets_[tet]) {
    sum_vertex(v);
  }
  for (const Index edge : tet_edges_[tet]) {
    sum_edge(edge);
  }
}

// With k_ij >= 0, explicit Euler keeps T_i between its neighbours' when dt sum_j k_ij <= M_i.
void HeatField::bound_step(double dt) {
  if (dt == bounded_dt_) {
    return;
  }
  std::vector<double> sums(capacities_.size(), 0.0);
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    for (const Index v : edges_[e]) {
      sums[v] += conductances_[e];
    }
  }
  double needed = 1;
  for (std::size_t v = 0; v < sums.size(); ++v) {
    if (capacities_[v] > 0) {
      needed = std::max(needed, dt * sums[v] / capacities_[v]);
    }
  }
  substeps_ = static_cast<int>(std::ceil(std::min<double>(needed, kMostSubsteps)));
  const double h = dt / substeps_;
  limited_edge_count_ = 0;
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    double share = 1;
    for (const Index v : edges_[e]) {
      if (h * sums[v] > capacities_[v]) {
        share = std::min(share, capacities_[v] / (h * sums[v]));
      }
    }
    limited_[e] = share * conductances_[e];
    limited_edge_count_ += share < 1;
  }
  bounded_dt_ = dt;
}

// Heat beyond the boiling point turns water to steam before it raises the temperature.
void HeatField::boil(Index vertex) {
  const double excess = temperatures_[vertex] - kBoilingTemperature;
  if (!(excess > 0) || !(water_[vertex] > 0) || !(tissue_.water_fraction > 0)) {
    return;
  }
  const double whole = latent_rise();
  if (excess < water_[vertex] * whole) {
    water_[vertex] -= excess / whole;
    temperatures_[vertex] = kBoilingTemperature;
  } else {
    temperatures_[vertex] -= water_[vertex] * whole;
    water_[vertex] = 0;
  }
}

void HeatField::step(double dt, std::span<const HeatSource> sources) {
  check_positive("dt", dt);
  for (const HeatSource& source : sources) {
    if (source.vertex < 0 || source.vertex >= static_cast<Index>(temperatures_.size())) {
      throw InvalidArgument("heat source at vertex " + std::to_string(source.vertex) +
                            "; ids must be in [0, " + std::to_string(temperatures_.size()) + ")");
    }
    if (!(source.power >= 0) || !std::isfinite(source.power)) {
      throw InvalidArgument("heat source at vertex " + std::to_string(source.vertex) +
                            " has a power of " + std::to_string(source.power) +
                            " W; it must be >= 0 and finite");
    }
  }
  bound_step(dt);
  const double h = dt / substeps_;
  for (int substep = 0; substep < substeps_; ++substep) {
    std::fill(flows_.begin(), flows_.end(), 0.0);
    for (std::size_t e = 0; e < edges_.size(); ++e) {
      const auto [a, b] = edges_[e];
      const double flow = limited_[e] * (temperatures_[b] - temperatures_[a]);
      flows_[a] += flow;
      flows_[b] -= flow;
    }
    for (const HeatSource& source : sources) {
      if (has_tissue(source.vertex)) {
        flows_[source.vertex] += source.power;
        in_ += h * source.power;
      }
    }
    for (std::size_t v = 0; v < flows_.size(); ++v) {
      if (capacities_[v] > 0) {
        temperatures_[v] += h * flows_[v] / capacities_[v];
        boil(static_cast<Index>(v));
        peaks_[v] = std::max(peaks_[v], temperatures_[v]);
      }
    }
  }
  has_stepped_ = true;
}

// How much warmer the heat that boils all water would make the tissue, K: latent and sensible heat
// scale with the same mass.
double HeatField::latent_rise() const noexcept {
  return tissue_.water_fraction * kLatentHeatOfWater / tissue_.specific_heat;
}

HeatLedger HeatField::ledger() const noexcept {
  HeatLedger ledger{.in = in_, .removed = removed_};
  for (std::size_t v = 0; v < capacities_.size(); ++v) {
    ledger.sensible += capacities_[v] * (temperatures_[v] - kBodyTemperature);
    ledger.latent += capacities_[v] * (1 - water_[v]) * latent_rise();
  }
  return ledger;
}

int HeatField::boiling_vertices(Index tet) const {
  return static_cast<int>(
      std::count_if(tets_[tet].begin(), tets_[tet].end(), [&](Index v) { return has_boiled(v); }));
}

// Above body temperature, that of boiled-off water included, J.
double HeatField::heat_of(Index tet) const noexcept {
  double heat = 0;
  for (const Index v : tets_[tet]) {
    heat += tet_masses_[tet] * tissue_.specific_heat / 4 *
            (temperatures_[v] - kBodyTemperature + (1 - water_[v]) * latent_rise());
  }
  return heat;
}

void HeatField::add_vertex(Index scene_vertex, Index first, Index second, double share) {
  const std::size_t added = temperatures_.size();
  vertex_ids_.added.push_back(scene_vertex);
  resize(added + 1, tets_.size(), edges_.size());
  const auto between = [&](auto& values) {
    values[added] = std::lerp(values[first], values[second], share);  // never beyond either
  };
  rest_positions_[added] =
      first == second
          ? rest_positions_[first]
          : Eigen::Vector3d((1 - share) * rest_positions_[first] + share * rest_positions_[second]);
  between(temperatures_);
  between(peaks_);
  between(water_);
}

Index HeatField::find_or_add_edge(Index a, Index b) {
  const Edge wanted{std::min(a, b), std::max(a, b)};
  Index found = kInvalidIndex;
  visit_tets(a, [&](Index t) {
    for (const Index edge : tet_edges_[t]) {
      found = edges_[edge] == wanted ? edge : found;
    }
  });
  if (found == kInvalidIndex) {
    found = static_cast<Index>(edges_.size());
    resize(temperatures_.size(), tets_.size(), edges_.size() + 1);
    edges_.back() = wanted;
  }
  return found;
}

void HeatField::find_tet_edges(Index tet) {
  for (std::size_t k = 0; k < 6; ++k) {
    const auto [a, b] = kTetEdges[k];
    tet_edges_[tet][k] = find_or_add_edge(tets_[tet][a], tets_[tet][b]);
  }
}

void HeatField::add_tet(Index scene_tet, const Tet& vertices) {
  const auto added = static_cast<Index>(tets_.size());
  tet_ids_.added.push_back(scene_tet);
  resize(temperatures_.size(), tets_.size() + 1, edges_.size());
  tets_[added] = vertices;
  tet_masses_[added] = tissue_.density * tet_volume(rest_positions_, vertices);
  tet_conductances_[added] = edge_conductances(rest_positions_, vertices, tissue_.conductivity);
  find_tet_edges(added);
  link_tet(added);
}

void HeatField::replace_corner(Index tet, Index from, Index to) noexcept {
  unlink_tet(tet);
  std::replace(tets_[tet].begin(), tets_[tet].end(), from, to);
  link_tet(tet);
}

void HeatField::validate(const Solver& solver, const TopologyEdit&) const {
  followed_.check(solver, "a heat field");
}

void HeatField::apply(const Solver& solver, const TopologyEdit& edit,
                      const EditResult& result) noexcept {
  followed_.apply(result);
  removed_before_ = removed_;
  vertices_before_ = vertex_ids_.size();
  tets_before_ = tet_ids_.size();
  edges_before_ = edges_.size();
  moved_edges_.clear();
  has_stepped_ = false;
  for (std::size_t i = 0; i < edit.new_vertices.size(); ++i) {
    const NewVertex& added = edit.new_vertices[i];
    const Index first = find_vertex(added.first);
    if (first != kInvalidIndex) {
      add_vertex(result.first_new_vertex + static_cast<Index>(i), first, find_vertex(added.second),
                 added.share);
    }
  }
  for (std::size_t i = 0; i < result.tets.size(); ++i) {
    const Index t = find_tet(result.tets[i]);
    if (t != kInvalidIndex) {
      // the heat of parents, which follow what was asked for, stays with their children
      const bool is_asked_for =
          i < edit.remove_tets.size() || std::ranges::any_of(edit.remove_bodies, [&](Index body) {
            return solver.body_of_tet(result.tets[i]) == body;
          });
      removed_ += is_asked_for ? heat_of(t) : 0;
      unlink_tet(t);
      bounded_dt_ = 0;
    }
  }
  for (const CornerMove& move : edit.corner_moves) {
    const Index t = find_tet(move.tet);
    if (t != kInvalidIndex) {
      moved_edges_.push_back(tet_edges_[t]);
      replace_corner(t, find_vertex(move.from), find_vertex(move.to));
      bounded_dt_ = 0;
    }
  }
  for (const CornerMove& move : edit.corner_moves) {
    const Index t = find_tet(move.tet);
    if (t != kInvalidIndex) {
      find_tet_edges(t);
    }
  }
  for (std::size_t i = 0; i < edit.new_tets.size(); ++i) {
    const NewTet& added = edit.new_tets[i];
    if (find_tet(added.parent) != kInvalidIndex) {
      Tet vertices;
      std::transform(added.vertices.begin(), added.vertices.end(), vertices.begin(),
                     [&](Index v) { return find_vertex(v); });
      add_tet(result.first_new_tet + static_cast<Index>(i), vertices);
    }
  }

  for (const Index id : result.tets) {
    const Index t = find_tet(id);
    if (t != kInvalidIndex) {
      sum_tet(t);
    }
  }
  for (const std::array<Index, 6>& left : moved_edges_) {
    for (const Index edge : left) {
      sum_edge(edge);
      sum_vertex(edges_[edge][0]);
      sum_vertex(edges_[edge][1]);
    }
  }
  for (const CornerMove& move : edit.corner_moves) {
    const Index t = find_tet(move.tet);
    if (t != kInvalidIndex) {
      sum_tet(t);
    }
  }
  for (std::size_t i = 0; i < edit.new_tets.size(); ++i) {
    const Index t = find_tet(result.first_new_tet + static_cast<Index>(i));
    if (t != kInvalidIndex) {
      sum_tet(t);
    }
  }
}

void HeatField::undo(const Solver&, const TopologyEdit& edit, const EditResult& result) noexcept {
  followed_.undo();
  const HeatLedger before = has_stepped_ ? ledger() : HeatLedger{};
  for (std::size_t i = 0; i < edit.new_tets.size(); ++i) {
    const Index t = find_tet(result.first_new_tet + static_cast<Index>(i));
    if (t != kInvalidIndex) {
      unlink_tet(t);
    }
  }
  std::size_t moved = moved_edges_.size();
  for (auto move = edit.corner_moves.rbegin(); move != edit.corner_moves.rend(); ++move) {
    const Index t = find_tet(move->tet);
    if (t != kInvalidIndex) {
      replace_corner(t, find_vertex(move->to), find_vertex(move->from));
      tet_edges_[t] = moved_edges_[--moved];
      bounded_dt_ = 0;
    }
  }
  for (const Index id : result.tets) {
    const Index t = find_tet(id);
    if (t != kInvalidIndex) {
      link_tet(t);
      bounded_dt_ = 0;
    }
  }
  vertex_ids_.added.resize(vertices_before_ - static_cast<std::size_t>(vertex_ids_.count));
  tet_ids_.added.resize(tets_before_ - static_cast<std::size_t>(tet_ids_.count));
  resize(vertices_before_, tets_before_, edges_before_);

  for (const Index id : result.tets) {
    const Index t = find_tet(id);
    if (t != kInvalidIndex) {
      sum_tet(t);
    }
  }
  for (const CornerMove& move : edit.corner_moves) {
    const Index t = find_tet(move.tet);
    if (t != kInvalidIndex) {
      sum_tet(t);
    }
  }
  if (has_stepped_) {
    const HeatLedger after = ledger();
    removed_ -= after.sensible - before.sensible + after.latent - before.latent;
  } else {
    removed_ = removed_before_;
  }
}

}  // namespace pbdsurg
