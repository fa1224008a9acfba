// SPDX-License-Identifier: Apache-2.0
#include "lib/surgery/heat_changes.h"

#include <algorithm>
#include <array>
#include <tuple>
#include <utility>

#include "pbdsurg/heat/tissue_state.h"
#include "pbdsurg/mesh/topology.h"

#include "lib/surgery/element_ids.h"
#include "lib/surgery/element_means.h"
#include "lib/tissue/renumber.h"
#include "lib/tissue/sheet.h"

namespace pbdsurg {
namespace {

// Rest values follow the state in steps of one percent, so that an edit a step stays small.
constexpr float kLeastChange = 0.01F;
// Stiffness in steps of ten percent, as it is known less well and felt less.
constexpr float kLeastStiffening = 0.1F;

// Vertices with more collagen than this, and with all their water, have not shrunk by a step.
constexpr double kUnmarkedCollagen = 0.97;
// Those of which more lives have not stiffened by a step.
constexpr double kUnmarkedSurvival = 0.99;

// HeatField::has_boiled() of a vertex that is known to be there.
bool has_boiled(const HeatField& field, Index vertex) {
  return field.peak_temperatures()[vertex] >= kBoilingTemperature;
}

// J to warm an element from body temperature and boil it dry.
double drying_energy(const HeatField& field, Index element) {
  const ThermalMesh& mesh = field.mesh();
  const ThermalProperties& tissue = mesh.tissues()[mesh.tissue_of_element(element)];
  const double latent =
      field.model().has_latent_heat ? tissue.water_fraction * kLatentHeatOfWater : 0;
  return tissue.density * mesh.volume(element) *
         (tissue.specific_heat * (kBoilingTemperature - kBodyTemperature) + latent);
}

}  // namespace

HeatState heat_state(const HeatField& field, Index element) {
  const auto boiled = std::ranges::count_if(field.mesh().corners(element),
                                            [&](Index v) { return has_boiled(field, v); });
  return heat_state(field.model().removal, static_cast<int>(boiled), mean_water(field, element),
                    field.model().dry_water, corner_count(element));
}

HeatChanges::HeatChanges(const HeatField& field, const CauteryOptions& options)
    : stiffens_(std::ranges::any_of(
          field.mesh().tissues(),
          [](const ThermalProperties& tissue) { return tissue.coagulated_stiffness > 1; })),
      tearing_rate_(options.tearing_rate),
      tearing_loss_(options.tearing_loss),
      boiled_shrinkage_(options.boiled_shrinkage),
      shrink_limit_(static_cast<std::size_t>(options.shrink_limit)) {
  follow(field);
}

void HeatChanges::collect(const Solver& solver, const HeatField& field, double dt, double energy,
                          TopologyEdit& edit) {
  find_marked(field);
  find_due(field, dt);
  for (const Index v : field.active_vertices()) {
    seen_water_[v] = field.water()[v];
  }
  take_due(field, energy, edit);
  shrink(solver, field, edit);
  if (stiffens_) {
    stiffen(solver, field, edit);
  }
}

bool HeatChanges::is_marked(const HeatField& field, Index vertex) const {
  return has_boiled(field, vertex) || field.collagen()[vertex] < kUnmarkedCollagen ||
         (stiffens_ && field.survival()[vertex] < kUnmarkedSurvival);
}

void HeatChanges::find_marked(const HeatField& field) {
  ++round_;
  marked_.clear();
  const auto add = [&](Index e) {
    if (seen_[e] != round_ && field.mesh().is_alive(e)) {
      seen_[e] = round_;
      marked_.push_back(e);
    }
  };
  for (const Index v : field.active_vertices()) {
    if (is_marked(field, v)) {
      field.mesh().for_each_element(v, add);
    }
  }
  for (const DueElement& pending : pending_) {
    add(pending.element);
  }
  std::sort(marked_.begin(), marked_.end());
}

// Whether steam tears an element, now or when it was last due.
bool HeatChanges::is_tearing(const HeatField& field, Index element, double water, double dt) const {
  double boiled_off = 0;  // of the element's water
  for (const Index v : field.mesh().corners(element)) {
    boiled_off += (seen_water_[v] - field.water()[v]) / corner_count(element);
  }
  if (boiled_off > 0 && boiled_off >= tearing_rate_ * dt && water <= 1 - tearing_loss_) {
    return true;
  }
  const DueElement* pending = find_pending(element);
  return pending != nullptr && pending->is_torn;
}

void HeatChanges::find_due(const HeatField& field, double dt) {
  due_.clear();
  for (const Index e : marked_) {
    const double water = mean_water(field, e);
    if (heat_state(field, e) == HeatState::vaporised) {
      due_.push_back({e, water, false});
    } else if (is_tearing(field, e, water, dt)) {
      due_.push_back({e, water, true});
    }
  }
}

// What is dry goes first, the driest of all before the others.
void HeatChanges::take_due(const HeatField& field, double energy, TopologyEdit& edit) {
  std::sort(due_.begin(), due_.end(), [](const Due& a, const Due& b) {
    return std::tie(a.is_torn, a.water, a.element) < std::tie(b.is_torn, b.water, b.element);
  });
  due_energy_ = due_volume_ = 0;
  torn_ = 0;
  std::size_t taken = 0;
  for (; taken < due_.size(); ++taken) {
    const auto [element, water, is_torn] = due_[taken];
    const double needed = drying_energy(field, element);
    // what boiled off in tissue that is left will be needed once that is dry
    const double reserved = is_torn ? field.ledger().latent : 0;
    if (spent_ + due_energy_ + needed > energy - reserved) {
      break;
    }
    due_energy_ += needed;
    due_volume_ += field.mesh().volume(element);
    torn_ += is_torn ? 1 : 0;
    if (is_triangle(element)) {
      edit.remove_triangles.push_back(triangle_of_element(element));
    } else {
      edit.remove_tets.push_back(element);
    }
    seen_[element] = 0;  // it shrinks no more
  }
  remember(field, taken);
  std::ranges::sort(edit.remove_tets);
  std::ranges::sort(edit.remove_triangles);
}

// What to look at next time, of which the first were taken. Those that have gone stay until others
// are taken, for the last edit may be undone.
void HeatChanges::remember(const HeatField& field, std::size_t taken) {
  const auto dropped = std::remove_if(
      due_.begin() + static_cast<std::ptrdiff_t>(taken), due_.end(),
      [&](const Due& due) { return due.is_torn && find_pending(due.element) == nullptr; });
  due_.erase(dropped, due_.end());  // what boils on tears later
  deferred_count_ = static_cast<Index>(due_.size() - taken);
  std::erase_if(pending_,
                [&](const DueElement& p) { return taken > 0 || field.mesh().is_alive(p.element); });
  for (const Due& due : due_) {
    pending_.push_back({due.element, due.is_torn});
  }
  std::ranges::sort(pending_, {}, &DueElement::element);
}

const DueElement* HeatChanges::find_pending(Index element) const {
  const auto found = std::ranges::lower_bound(pending_, element, {}, &DueElement::element);
  return found != pending_.end() && found->element == element ? &*found : nullptr;
}

// How long what was 1 m between two vertices of a tissue is now.
double HeatChanges::shrunk(const HeatField& field, Index first, Index second) const {
  const double collagen = (field.collagen()[first] + field.collagen()[second]) / 2;
  if (field.model().removal == RemovalRule::boiled_vertices) {
    return has_boiled(field, first) && has_boiled(field, second)
               ? 1 - boiled_shrinkage_ * (1 - collagen)
               : 1;
  }
  const ThermalMesh& mesh = field.mesh();
  return shrunk_length(mesh.tissues()[mesh.tissue_of_vertex(first)],
                       (field.water()[first] + field.water()[second]) / 2, collagen);
}

// Of what changes, no more than the limit; ascending.
void HeatChanges::keep_farthest() {
  if (shrink_limit_ == 0 || due_changes_.size() <= shrink_limit_) {
    return;
  }
  const auto last = due_changes_.begin() + static_cast<std::ptrdiff_t>(shrink_limit_);
  std::nth_element(due_changes_.begin(), last, due_changes_.end(),
                   [](const Change& a, const Change& b) {
                     return std::tie(a.behind, a.id) < std::tie(b.behind, b.id);
                   });
  due_changes_.erase(last, due_changes_.end());
  std::ranges::sort(due_changes_, {}, &Change::id);
}

// Of elements; both ascend.
template <class OfTet, class OfTriangle>
void HeatChanges::add_due(std::vector<OfTet>& of_tets, std::vector<OfTriangle>& of_triangles) {
  keep_farthest();
  for (const Change& due : due_changes_) {
    if (is_triangle(due.id)) {
      of_triangles.push_back({triangle_of_element(due.id), due.value});
    } else {
      of_tets.push_back({due.id, due.value});
    }
  }
  std::ranges::sort(of_triangles, {}, &OfTriangle::triangle);
}

void HeatChanges::shrink_triangle(const Solver& solver, const HeatField& field, Index triangle) {
  const Triangle& corners = solver.tissue().triangles()[triangle];
  double length = 0;  // relative
  for (std::size_t i = 0; i < 3; ++i) {
    length += shrunk(field, corners[i], corners[(i + 1) % 3]) / 3;
  }
  const double whole = triangle_area(field.mesh().rest_positions(), corners);
  const auto area = static_cast<float>(whole * length * length);
  const float now = solver.rest_area(triangle);
  if (area < (1 - kLeastChange) * now) {
    due_changes_.push_back({element_of_triangle(triangle), area, area / now});
  }
}

void HeatChanges::shrink(const Solver& solver, const HeatField& field, TopologyEdit& edit) {
  const ThermalMesh& mesh = field.mesh();
  edges_.clear();
  due_changes_.clear();
  for (const Index t : marked_) {
    if (seen_[t] != round_) {
      continue;
    }
    if (is_triangle(t)) {
      shrink_triangle(solver, field, triangle_of_element(t));
      continue;
    }
    const Material& material = solver.tissue().body(solver.tissue().body_of_tet(t)).material;
    const bool is_neo_hookean = material.model == ElasticModel::neo_hookean;
    std::array<double, 6> lengths;  // relative
    double factor = 0;
    for (std::size_t e = 0; e < kTetEdges.size(); ++e) {
      const auto [a, b] = kTetEdges[e];
      lengths[e] = shrunk(field, mesh.tets()[t][a], mesh.tets()[t][b]);
      factor += lengths[e] / 6;
    }
    if (is_neo_hookean || material.has_volume_constraints) {
      const auto volume = static_cast<float>(mesh.volume(t) * factor * factor * factor);
      const float now = solver.rest_volume(t);
      if (volume < (1 - kLeastChange) * now) {
        due_changes_.push_back({t, volume, volume / now});
      }
    }
    for (std::size_t e = 0; e < kTetEdges.size() && !is_neo_hookean; ++e) {
      if (lengths[e] < 1) {
        edges_.push_back(solver.tissue().tet_edges(t)[e]);
      }
    }
  }
  add_due(edit.rest_volumes, edit.rest_areas);
  due_changes_.clear();
  std::sort(edges_.begin(), edges_.end());
  edges_.erase(std::unique(edges_.begin(), edges_.end()), edges_.end());
  for (const Index e : edges_) {
    const auto [a, b] = solver.tissue().edges()[e];
    const double rest_length = (mesh.rest_positions()[a] - mesh.rest_positions()[b]).norm();
    const auto length = static_cast<float>(rest_length * shrunk(field, a, b));
    const float now = solver.rest_length(e);
    if (length < (1 - kLeastChange) * now) {
      due_changes_.push_back({e, length, length / now});
    }
  }
  keep_farthest();
  for (const Change& edge : due_changes_) {
    edit.rest_lengths.push_back({edge.id, edge.value});
  }
}

// What was stiffer before stays as it is.
void HeatChanges::stiffen(const Solver& solver, const HeatField& field, TopologyEdit& edit) {
  const ThermalMesh& mesh = field.mesh();
  const Tissue& tissue = solver.tissue();
  due_changes_.clear();
  for (const Index e : marked_) {
    if (seen_[e] != round_ ||
        (!is_triangle(e) &&
         tissue.body(tissue.body_of_tet(e)).material.model != ElasticModel::neo_hookean)) {
      continue;
    }
    const auto factor = static_cast<float>(
        stiffened(mesh.tissues()[mesh.tissue_of_element(e)], mean_survival(field, e)));
    const float now =
        is_triangle(e) ? tissue.triangle_stiffness(triangle_of_element(e)) : tissue.stiffness(e);
    if (factor >= (1 + kLeastStiffening) * now) {
      due_changes_.push_back({e, factor, now / factor});
    }
  }
  add_due(edit.stiffnesses, edit.triangle_stiffnesses);
}

void HeatChanges::follow(const HeatField& field) noexcept {
  spent_before_ = spent_;
  const auto vertices = static_cast<std::size_t>(field.mesh().vertex_count());
  for (std::size_t v = seen_water_.size(); v < vertices; ++v) {
    seen_water_.push_back(field.water()[v]);
  }
  seen_.resize(field.mesh().tet_count(), field.mesh().triangle_count());
}

void HeatChanges::renumber(const HeatField& field, const Renumbering& ids) {
  renumber_values(seen_water_, ids.vertices, static_cast<std::size_t>(field.mesh().vertex_count()));
  seen_.assign(field.mesh().tet_count(), field.mesh().triangle_count(), 0);
  for (DueElement& pending : pending_) {
    pending.element = new_element(pending.element, ids);
  }
  std::erase_if(pending_, [](const DueElement& p) { return p.element == kInvalidIndex; });
  std::ranges::sort(pending_, {}, &DueElement::element);
}

void HeatChanges::restore(const HeatField& field, double spent,
                          std::vector<DueElement> pending) noexcept {
  spent_ = spent;
  // an undo of the last edit still gives energy back
  spent_before_ = std::min(spent_before_, spent);
  pending_ = std::move(pending);
  seen_water_.assign(field.water().begin(), field.water().end());
}

void HeatChanges::undo(const HeatField& field) noexcept {
  spent_ = spent_before_;
  seen_water_.resize(static_cast<std::size_t>(field.mesh().vertex_count()));
  seen_.resize(field.mesh().tet_count(), field.mesh().triangle_count());
  std::erase_if(pending_,
                [&](const DueElement& p) { return p.element >= field.mesh().tet_count(); });
}

}  // namespace pbdsurg
