// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/cuda/device.h"

#include "tests/support/catch.h"
#include "tests/world/slab_world.h"

namespace pbdsurg {

using testing::kDt;
using testing::slab;

namespace {

// A slab that is burnt, of which even the first system would be large enough for a device.
struct Burning {
  explicit Burning(const Executor& executor)
      : world({.method = SolverMethod::vertex_block,
               .damping = 20,
               .executor = executor,
               .math = MathMode::strict}) {
    body = world.add_body("slab", slab(0, {12, 12, 4}), tissues::liver());
    world.fix(body, [](const Eigen::Vector3d& x) { return x.z() < 1e-3; });
    const ToolId hook = world.add_tool({}, testing::at({12e-3F, 12e-3F, 8.2e-3F}));
    CauteryOptions options;
    options.heat.device_rows = 0;
    burner = world.add_cautery(hook, {body}, options);
    world.energise(burner, cut_settings(50));
  }

  World world;
  BodyId body{};
  CauteryId burner{};
};

}  // namespace

// Would catch heat and potential that a device solves in strict mode, whose bits are another's.
TEST_CASE("cuda world: a strict one burns with the bits of a host", "[device]") {
  Burning device(cuda::device()), host(executor::serial());
  for (int step = 0; step < 60; ++step) {
    device.world.step(kDt);
    host.world.step(kDt);
    REQUIRE(device.world.solver().state_hash() == host.world.solver().state_hash());
  }
  const HeatField &one = device.world.cautery(device.burner).field(),
                  &other = host.world.cautery(host.burner).field();
  CHECK(other.ledger().in > 5);
  CHECK(std::ranges::equal(one.temperatures(), other.temperatures()));
  CHECK(std::ranges::equal(one.water(), other.water()));
}

}  // namespace pbdsurg
