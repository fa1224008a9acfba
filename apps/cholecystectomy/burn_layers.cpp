// SPDX-License-Identifier: Apache-2.0
#include "burn_layers.h"

#include <algorithm>

#include "pbdsurg/thermal/tissue_color.h"

namespace cholecystectomy {
namespace {

using pbdsurg::Index;

// A strand's 2 mm^2 (kMembraneAreaPerLink) of the some 4 mm^2 that a vertex of the gallbladder
// stands for.
constexpr float kStumpCover = 0.5F;

}  // namespace

void BurnLayers::update(const Simulation& simulation) {
  const pbdsurg::HeatField& field = simulation.cautery.field();
  if (maps_.empty()) {
    for (const Organ organ : kBurnable) {
      const pbdsurg::Body& body = simulation.solver.bodies()[body_of(organ)];
      maps_.push_back({&simulation.surfaces[body_of(organ)], body.first_vertex,
                       body.first_vertex + body.vertex_count});
    }
    layers_.assign(field.temperatures().size(), Eigen::Vector4f::Zero());
    has_stump_.assign(field.temperatures().size(), 0);
  }
  // what has gone to rest in the step was warm before it
  const auto warm = field.active_vertices();
  changed_.insert(changed_.end(), warm.begin(), warm.end());
  const pbdsurg::SurfaceFields fields{field.peak_temperatures(), field.survival(), field.water(),
                                      field.charred()};
  for (OrganMap& organ : maps_) {
    organ.map.update(*organ.surface, fields, changed_);
    organ.map.collect_changes(organ.seen, ranges_, 1);
    organ.seen = organ.map.version();
    for (const auto [first, end] : ranges_) {
      for (Index v = std::max(first, organ.first); v < std::min(end, organ.end); ++v) {
        color(organ, v, field.model().color);
      }
    }
  }
  changed_.assign(warm.begin(), warm.end());
  add_stumps(simulation);
}

void BurnLayers::add_stumps(const Simulation& simulation) {
  const auto events = simulation.connections.events();
  seen_events_ =
      std::min(seen_events_, events.size());  // an undo takes its events back, not its stumps
  for (; seen_events_ < events.size(); ++seen_events_) {
    if (events[seen_events_].cause != pbdsurg::StrandLoss::removed) {
      continue;
    }
    const pbdsurg::Link& link = simulation.solver.links()[events[seen_events_].link];
    for (const Index v : {link.first, link.second}) {
      has_stump_[v] = 1;
      for (const OrganMap& organ : maps_) {
        if (v >= organ.first && v < organ.end) {
          color(organ, v, simulation.cautery.field().model().color);
        }
      }
    }
  }
}

void BurnLayers::color(const OrganMap& organ, Index vertex, pbdsurg::ColorRule rule) {
  pbdsurg::BurnMarks marks = pbdsurg::burn_marks(organ.map.marks()[vertex]);
  double temperature = organ.map.temperatures()[vertex];
  if (has_stump_[vertex] != 0) {
    marks.white = std::max(marks.white, kStumpCover);
    marks.brown = std::max(marks.brown, kStumpCover);
    temperature = std::max(temperature, pbdsurg::kBoilingTemperature);
  }
  const pbdsurg::Color layer = pbdsurg::burn_layer(rule, temperature, marks);
  layers_[vertex] = {layer.red, layer.green, layer.blue, layer.alpha};
}

std::span<const Eigen::Vector4f> BurnLayers::of(const pbdsurg::Body& body) const {
  return std::span(layers_).subspan(static_cast<std::size_t>(body.first_vertex),
                                    static_cast<std::size_t>(body.vertex_count));
}

}  // namespace cholecystectomy
