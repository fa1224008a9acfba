// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <vector>

#include "tests/support/allocation_count.h"
#include "tests/support/catch.h"
#include "tests/support/meshes.h"
#include "tests/support/potential_cases.h"

namespace pbdsurg {

using testing::allocation_count;

// Would catch buffers that are not kept: of patches, conductivities, regions and lost contacts.
TEST_CASE("potential: a contact that goes around allocates nothing the second time", "[unit]") {
  constexpr double kEdge = 1e-3;
  const TetMesh shape = testing::make_box({16, 16, 8}, kEdge);
  const ThermalMesh mesh(shape, tissues::liver().heat);
  std::vector<double> conductivities(shape.tets().size(), 0.3);
  PotentialField field(mesh, {.executor = executor::threads(2)});
  std::vector<std::vector<PatchVertex>> patches;
  for (int frame = 0; frame < 24; ++frame) {
    const double turn = 0.26 * frame;
    const Eigen::Vector3d at((8 + 5 * std::cos(turn)) * kEdge, (8 + 5 * std::sin(turn)) * kEdge,
                             8 * kEdge);
    patches.push_back(testing::patch_where(
        mesh, [&](const Eigen::Vector3d& x) { return (x - at).norm() < 1.2 * kEdge; }));
  }
  patches[7].clear();
  long before = 0, after = 0;
  int right = 0;
  for (int round = 0; round < 3; ++round) {
    before = allocation_count;
    for (const std::vector<PatchVertex>& patch : patches) {
      field.set_patch(patch, 1e-6);
      for (std::size_t t = round; t < conductivities.size(); t += 3) {
        conductivities[t] = conductivities[t] > 0.2 ? 0.15 : 0.3;
      }
      right += field.solve(conductivities).is_closed == !patch.empty() ? 1 : 0;
    }
    after = allocation_count;
  }
  CHECK(after == before);
  CHECK(right == 3 * static_cast<int>(patches.size()));
}

}  // namespace pbdsurg
