// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/scene_feed.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>

#include "pbdsurg/surgery/cut.h"

#include "tests/play/session_fixture.h"
#include "tests/support/catch.h"

namespace cholecystectomy {
namespace {

// Parts the liver halfway down at a share of its length.
void cut_liver(Simulation& simulation, float share) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& x : simulation.surface(Organ::liver).positions()) {
    box.extend(x);
  }
  const float x = box.min().x() + share * box.sizes().x();
  const auto edge = [&](float z) {
    return pbdsurg::BladeEdge{{x, box.min().y() - 0.01F, z}, {x, box.max().y() + 0.01F, z}};
  };
  const auto blade =
      pbdsurg::sweep_blade(std::array{edge(box.max().z() + 0.01F), edge(box.center().z())});
  simulation.world.edit(pbdsurg::plan_cut(simulation.solver, blade).edit);
}

// Of skin at rest, m^2.
double skin_area(const SceneFeed& feed, const Simulation& simulation) {
  const pbdsurg::Surface& surface = simulation.surface(Organ::liver);
  double area = 0;
  for (const auto& [a, b, c] : surface.triangles()) {
    if (a != b &&
        feed.skin().has({surface.vertices()[a], surface.vertices()[b], surface.vertices()[c]})) {
      const auto at = [&](pbdsurg::Index v) -> Eigen::Vector3d {
        return surface.rest_positions()[v].cast<double>();
      };
      area += 0.5 * (at(b) - at(a)).cross(at(c) - at(a)).norm();
    }
  }
  return area;
}

}  // namespace

// Would catch a record of the skin that still follows the tissue before an undo, or that takes
// faces which a cut had bared for skin.
TEST_CASE("scene feed: skin stays skin over an undo between cuts", "[session]") {
  const LoadedScene& loaded = LoadedScene::get();
  StageTimes times;
  auto before = std::make_unique<Simulation>(
      loaded.scene, solver_options(pbdsurg::executor::threads(), false), std::nullopt, times);
  SceneFeed feed(*before, loaded.anatomy.anatomy.abdominal_wall, 1);
  const double area = skin_area(feed, *before);
  before->world.record();
  cut_liver(*before, 0.3F);
  before->advance({});
  CHECK(std::abs(skin_area(feed, *before) - area) < 1e-4 * area);
  const SimulationState state = before->save();
  const SkinRecord skin = feed.skin();
  cut_liver(*before, 0.7F);  // what the undo takes back

  Simulation after(loaded.scene, state, times);
  feed.begin_anew(after, skin);
  before.reset();
  CHECK(std::abs(skin_area(feed, after) - area) < 1e-4 * area);
  SceneState shown;
  feed.fill(shown, {});
  const Seen seen{0, shown.generation, shown.triangle_versions, shown.burn_versions,
                  shown.vertex_counts};
  cut_liver(after, 0.5F);
  after.advance({});
  CHECK(std::abs(skin_area(feed, after) - area) < 1e-4 * area);
  feed.fill(shown, seen);  // the vertices that the cut has made
  CHECK(shown.whole.empty());
  const pbdsurg::Surface& liver = after.surface(Organ::liver);
  CHECK(shown.changes[1].new_rest_positions.size() ==
        liver.vertices().size() - seen.vertex_counts[1]);
  CHECK(shown.changes[1].new_rest_positions.size() > 20);
  feed.fill(shown, {});
  CHECK(shown.changes[1].new_rest_positions.empty());
  CHECK(shown.whole.size() == kOrganCount + 1);
  CHECK(std::ranges::count(shown.whole[1].is_inner, 1) > 20);
}

}  // namespace cholecystectomy
