// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/burn_layers.h"

#include <algorithm>

#include "pbdsurg/heat/tissue_color.h"

namespace cholecystectomy {
namespace {

using pbdsurg::Index;

// A strand's 2 mm^2 (kMembraneAreaPerLink) of the some 4 mm^2 that a vertex of the gallbladder
// stands for.
constexpr float kStumpCover = 0.5F;

// [vertex_count of the tissue] where strands hung that heat has parted
std::vector<bool> find_stumps(const Simulation& simulation) {
  const pbdsurg::Tissue& tissue = simulation.solver.tissue();
  std::vector<bool> has_stump(static_cast<std::size_t>(tissue.vertex_count()), false);
  for (const pbdsurg::StrandEvent& event : simulation.connections.events()) {
    if (event.cause == pbdsurg::StrandLoss::removed) {
      has_stump[tissue.links()[event.link].first] = true;
      has_stump[tissue.links()[event.link].second] = true;
    }
  }
  return has_stump;
}

}  // namespace

std::vector<Eigen::Vector4f> burn_layers(const Simulation& simulation) {
  const std::vector<bool> has_stump = find_stumps(simulation);
  const pbdsurg::ColorRule rule = simulation.cautery.field().model().color;
  std::vector<Eigen::Vector4f> layers(has_stump.size(), Eigen::Vector4f::Zero());
  for (const Organ organ : pbdsurg::kOrgans) {
    const pbdsurg::Surface& surface = simulation.surface(organ);
    for (std::size_t i = 0; i < surface.marks().size(); ++i) {
      const Index v = surface.vertices()[i];
      pbdsurg::BurnMarks marks = pbdsurg::burn_marks(surface.marks()[i]);
      double temperature = surface.peak_temperatures()[i];
      if (has_stump[v]) {
        marks.white = std::max(marks.white, kStumpCover);
        marks.brown = std::max(marks.brown, kStumpCover);
        temperature = std::max(temperature, pbdsurg::kBoilingTemperature);
      }
      const pbdsurg::Color layer = pbdsurg::burn_layer(rule, temperature, marks);
      layers[v] = {layer.red, layer.green, layer.blue, layer.alpha};
    }
  }
  return layers;
}

}  // namespace cholecystectomy
