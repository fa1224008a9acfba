// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/burn_layers.h"

#include <algorithm>

#include "pbdsurg/heat/tissue_color.h"

namespace cholecystectomy {
namespace {

using pbdsurg::Index;
using pbdsurg::SlotRange;

// A strand's 2 mm^2 (kMembraneAreaPerLink) of the some 4 mm^2 that a vertex of the gallbladder
// stands for.
constexpr float kStumpCover = 0.5F;

}  // namespace

BurnLayers::BurnLayers(const Simulation& simulation) : simulation_(simulation) {
  for (OfOrgan& organ : organs_) {
    organ.changes.reserve(simulation.solver.tissue().vertex_count());
  }
}

void BurnLayers::update() {
  const pbdsurg::Tissue& tissue = simulation_.solver.tissue();
  layers_.resize(static_cast<std::size_t>(tissue.vertex_count()), Eigen::Vector4f::Zero());
  has_stump_.resize(layers_.size());
  const auto& events = simulation_.connections.events();
  for (; seen_events_ < events.size(); ++seen_events_) {
    if (events[seen_events_].cause == pbdsurg::StrandLoss::removed) {
      const pbdsurg::Link& link = tissue.links()[events[seen_events_].link];
      add_stump(link.first);
      add_stump(link.second);
    }
  }
  for (const Organ organ : pbdsurg::kOrgans) {
    const pbdsurg::Surface& surface = simulation_.surface(organ);
    OfOrgan& own = organs_[static_cast<std::size_t>(organ)];
    surface.collect_mark_changes(own.seen_marks, ranges_);
    own.seen_marks = surface.marks_version();
    for (const SlotRange& range : ranges_) {
      for (Index place = range.first; place < range.end; ++place) {
        find_layer(organ, place);
      }
    }
  }
}

void BurnLayers::collect_changes(Organ organ, std::uint64_t since,
                                 std::vector<SlotRange>& ranges) const {
  const auto count = static_cast<Index>(simulation_.surface(organ).vertices().size());
  of(organ).changes.collect(since, count, ranges);
}

void BurnLayers::add_stump(Index vertex) {
  if (has_stump_[vertex]) {
    return;
  }
  has_stump_[vertex] = true;
  for (const Organ organ : pbdsurg::kOrgans) {
    const auto vertices = simulation_.surface(organ).vertices();
    const auto found = std::ranges::lower_bound(vertices, vertex);
    if (found != vertices.end() && *found == vertex) {
      find_layer(organ, static_cast<Index>(found - vertices.begin()));
    }
  }
}

void BurnLayers::find_layer(Organ organ, Index place) {
  const pbdsurg::Surface& surface = simulation_.surface(organ);
  if (place >= static_cast<Index>(surface.marks().size())) {
    return;  // nothing heats this organ
  }
  const Index vertex = surface.vertices()[place];
  pbdsurg::BurnMarks marks = pbdsurg::burn_marks(surface.marks()[place]);
  double temperature = surface.peak_temperatures()[place];
  if (has_stump_[vertex]) {
    marks.white = std::max(marks.white, kStumpCover);
    marks.brown = std::max(marks.brown, kStumpCover);
    temperature = std::max(temperature, pbdsurg::kBoilingTemperature);
  }
  const pbdsurg::Color color =
      pbdsurg::burn_layer(simulation_.cautery.field().model().color, temperature, marks);
  const Eigen::Vector4f layer(color.red, color.green, color.blue, color.alpha);
  if (layers_[vertex] != layer) {
    layers_[vertex] = layer;
    organs_[static_cast<std::size_t>(organ)].changes.note(place);
  }
}

}  // namespace cholecystectomy
