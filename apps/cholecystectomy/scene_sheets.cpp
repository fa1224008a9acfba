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

}  // namespace

std::vector<SceneSheets::Bundle> SceneSheets::bundles_of(const SurgicalScene& scene) {
  const auto links = scene.scene.links();
  std::vector<Bundle> bundles;
  Index next = 0;
  for (const JoinedPair& joint : scene.joined) {
    for (const Index first = next; next < first + joint.link_count; ++next) {
      if (next > first && links[next].first == links[next - 1].first) {
        ++bundles.back().link_count;
      } else {
        bundles.push_back({next, 1});
      }
    }
  }
  return bundles;
}

MembraneSheets SceneSheets::make_sheets(const SurgicalScene& scene,
                                        const std::vector<Bundle>& bundles) {
  const auto positions = scene.scene.positions();
  const auto links = scene.scene.links();
  std::vector<SheetLink> sheet_links;
  std::vector<Index> bundle_of;  // [link]
  std::size_t joint = 0;
  Index joint_end = scene.joined.empty() ? 0 : scene.joined.front().link_count;
  for (std::size_t b = 0; b < bundles.size(); ++b) {
    const auto [first_link, count] = bundles[b];
    while (first_link >= joint_end) {
      joint_end += scene.joined[++joint].link_count;
    }
    Eigen::Vector3d second = Eigen::Vector3d::Zero();
    for (Index l = first_link; l < first_link + count; ++l) {
      second += positions[links[l].second] / count;
      bundle_of.push_back(static_cast<Index>(b));
    }
    sheet_links.push_back({positions[links[first_link].first].cast<float>(), second.cast<float>(),
                           color_of(tissue_of(scene.joined[joint].first).look),
                           color_of(tissue_of(scene.joined[joint].second).look)});
  }
  std::vector<pbdsurg::Triangle> triangles;
  for (const auto& [a, b, c] : scene.sheets) {
    triangles.push_back({bundle_of[a], bundle_of[b], bundle_of[c]});
  }
  return {sheet_links, triangles, color_of(pbdsurg::tissues::membrane().look)};
}

SceneSheets::SceneSheets(const SurgicalScene& scene)
    : bundles_(bundles_of(scene)), sheets_(make_sheets(scene, bundles_)) {}

void SceneSheets::update(const Simulation& simulation, std::span<const Eigen::Vector4f> burns) {
  const pbdsurg::Solver& solver = simulation.solver;
  const auto positions = solver.positions();
  const auto links = solver.tissue().links();
  states_.clear();
  for (const auto& [first_link, count] : bundles_) {
    const Index vertex = links[first_link].first;
    SheetLinkState state;
    state.first = positions[vertex];
    state.first_burn = burns[vertex];
    state.second.setZero();
    Index alive = 0;
    for (Index l = first_link; l < first_link + count; ++l) {
      if (solver.tissue().is_link_alive(l)) {
        state.second += positions[links[l].second];
        if (alive++ == 0 || burns[links[l].second].w() > state.second_burn.w()) {
          state.second_burn = burns[links[l].second];
        }
      }
    }
    state.is_alive = alive > 0;
    state.second /= static_cast<float>(alive > 0 ? alive : 1);
    states_.push_back(state);
  }
  sheets_.update(states_);
}

}  // namespace cholecystectomy
