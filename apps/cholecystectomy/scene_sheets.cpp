// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/scene_sheets.h"

#include <cstddef>

#include "pbdsurg/tissue/library.h"

namespace cholecystectomy {
namespace {

using pbdsurg::Index;

// Between mottles, on average.
Eigen::Vector3f color_of(const pbdsurg::TissueLook& look) {
  return (look.color + look.mottle) / 2;
}

std::vector<SheetLink> links_of(const SurgicalScene& scene) {
  const auto positions = scene.scene.positions();
  std::vector<SheetLink> links;
  for (const JoinedPair& joint : scene.joined) {
    const Eigen::Vector3f first = color_of(tissue_of(joint.first).look);
    const Eigen::Vector3f second = color_of(tissue_of(joint.second).look);
    for (Index i = 0; i < joint.link_count; ++i) {
      const pbdsurg::Link& link = scene.scene.links()[links.size()];
      links.push_back({positions[link.first].cast<float>(), positions[link.second].cast<float>(),
                       first, second});
    }
  }
  return links;
}

}  // namespace

SceneSheets::SceneSheets(const SurgicalScene& scene)
    : sheets_(links_of(scene), scene.sheets, color_of(pbdsurg::tissues::membrane().look)) {}

void SceneSheets::update(const Simulation& simulation, std::span<const Eigen::Vector4f> burns) {
  const pbdsurg::Solver& solver = simulation.solver;
  const auto positions = solver.positions();
  const auto links = solver.tissue().links();
  states_.clear();
  for (Index l = 0; l < static_cast<Index>(links.size()); ++l) {
    const pbdsurg::Link& link = links[l];
    states_.push_back({positions[link.first], positions[link.second], burns[link.first],
                       burns[link.second], solver.tissue().is_link_alive(l)});
  }
  sheets_.update(states_);
}

}  // namespace cholecystectomy
