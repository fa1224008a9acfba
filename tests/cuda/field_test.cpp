// SPDX-License-Identifier: Apache-2.0
// Heat and potential on a device, against the CPU.
#include <thread>

#include "pbdsurg/cuda/device.h"

#include "tests/support/field_backend_cases.h"

namespace pbdsurg {

using testing::Approx;

// Would catch whatever the kernel does otherwise than LocalSystem, with one block and with sixteen,
// in the shared memory of blocks.
TEST_CASE("cuda fields: a potential is what the CPU finds", "[device]") {
  const Index size = GENERATE(8, 14, 26);
  testing::check_potentials({size, size, size / 2 + 2}, cuda::device());
}

// The region is all of 36,000 vertices: what blocks store does not fit into their shared memory.
TEST_CASE("cuda fields: a region too large for shared memory has the same potential", "[device]") {
  const TetMesh shape = testing::make_box({44, 44, 17}, 1e-3, 0.1);
  double conductances[2];
  for (const bool is_on_device : {false, true}) {
    testing::Conductor at(
        shape, [](const auto& x) { return x.x() < 1e-4; },
        [](const auto& x) { return x.x() > 43.9e-3; }, 0.3,
        {.tolerance = 1e-10,
         .most_iterations = 2000,
         .executor = is_on_device ? cuda::device() : Executor()});
    for (std::size_t t = 0; t < at.conductivities.size(); t += 3) {
      at.conductivities[t] *= 0.5;
    }
    const PotentialReport& report = at.solve();
    CHECK(report.has_converged);
    CHECK(report.is_on_device == is_on_device);
    conductances[is_on_device] = report.conductance;
  }
  CHECK(conductances[1] == Approx(conductances[0]).epsilon(1e-8));
}

TEST_CASE("cuda fields: temperatures are what the CPU finds", "[device]") {
  testing::check_temperatures({6, 5, 4}, cuda::device());
  testing::check_temperatures({16, 15, 8}, cuda::device());
}

// A disk on a half-space, as tests/heat/potential_field_test.cpp. Would catch a wrong region
// where both backends have the same.
TEST_CASE("cuda fields: a contact has nearly a disk's resistance", "[device]") {
  constexpr double kEdge = 1e-3;
  const TetMesh shape = testing::make_box({44, 44, 22}, kEdge);
  const ThermalMesh mesh(shape, tissues::liver().heat);
  PotentialField field(mesh, {.executor = cuda::device()});
  const Eigen::Vector3d middle(22 * kEdge, 22 * kEdge, 22 * kEdge);
  field.set_patch(testing::patch_where(mesh,
                                       [&](const Eigen::Vector3d& x) {
                                         return x.z() > 21.9 * kEdge &&
                                                (x - middle).norm() < 2.001 * kEdge;
                                       }),
                  std::numbers::pi * 4 * kEdge * kEdge);
  const PotentialReport& report = field.solve(std::vector<double>(shape.tets().size(), 0.3));
  CHECK(report.has_converged);
  CHECK(report.conductance ==
        Approx(2 * std::numbers::pi * 0.3 * 2 * kEdge / std::atan(10.0)).epsilon(0.08));
  CHECK(testing::sum(field.element_heat()) == Approx(report.conductance).epsilon(1e-12));
}

// Would catch anything that fields share.
TEST_CASE("cuda fields: fields of several threads do not disturb each other", "[device]") {
  const PotentialOptions options{.executor = cuda::device(), .device_rows = 0};
  const testing::Found alone = testing::burn_block({14, 12, 8}, options);
  std::vector<testing::Found> found(3);
  {
    std::vector<std::jthread> threads;
    for (testing::Found& one : found) {
      threads.emplace_back([&] { one = testing::burn_block({14, 12, 8}, options); });
    }
  }
  for (const testing::Found& one : found) {
    CHECK(one.potentials == alone.potentials);
    CHECK(one.tet_heat == alone.tet_heat);
  }
}

}  // namespace pbdsurg
