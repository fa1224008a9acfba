// SPDX-License-Identifier: Apache-2.0
// A cautery whose heat is on a device that fails.
#include <memory>

#include "pbdsurg/base/error.h"
#include "pbdsurg/surgery/cautery.h"
#include "pbdsurg/tissue/library.h"

#include "lib/base/executor_state.h"
#include "lib/heat/device_system.h"
#include "tests/support/catch.h"
#include "tests/support/meshes.h"

namespace pbdsurg {
namespace {

bool is_lost = false;

// Leaves increments at zero, whatever is to be solved.
class Idle final : public DeviceSystem {
 public:
  bool set_rows(const SystemRows&, std::span<const Tet>) override { return true; }
  void set_conductances(std::span<const std::array<double, 6>>) override {}
  LinearSolveReport solve(const DeviceSolve&, std::span<double>) override {
    if (is_lost) {
      throw Error("the device is lost");
    }
    return {};
  }
};

class IdleDevice final : public Device, public FieldDevice {
 public:
  [[nodiscard]] const std::string& name() const noexcept override { return name_; }
  [[nodiscard]] std::unique_ptr<DeviceSystem> make_system() override {
    return std::make_unique<Idle>();
  }

 private:
  std::string name_ = "idle";
};

}  // namespace

// Would catch heat of a substep that failed, which the next update delivers although the generator
// is off.
TEST_CASE("cautery: what a failed substep left undelivered stays so", "[unit]") {
  constexpr double kEdge = 1e-3;  // m
  const TetMesh mesh = testing::make_box({8, 8, 4}, kEdge);
  Scene scene;
  scene.add_body("fat", mesh);
  Solver solver(scene);
  const ThermalBody body{0, tissues::fat().heat};
  CauteryOptions options;
  options.heat.executor =
      Executor(std::make_shared<ExecutorState>(std::make_shared<IdleDevice>(), Executor()));
  options.heat.device_rows = 0;
  options.potential.executor = executor::serial();
  Cautery cautery(solver.tissue(), std::span(&body, 1), options);
  const Eigen::Vector3f tip(4e-3F, 4e-3F, 4.2e-3F);
  const Electrode electrode{tip, tip};

  is_lost = true;
  CHECK_THROWS_WITH(cautery.update(solver, electrode, cut_settings(30), 2e-3),
                    "the device is lost");
  is_lost = false;
  CHECK(cautery.field().ledger().in == 0);
  CHECK(cautery.update(solver, electrode, {}, 2e-3).energy == 0);
  CHECK(cautery.field().ledger().in == 0);
  CHECK(cautery.update(solver, electrode, cut_settings(30), 2e-3).energy > 0);
}

}  // namespace pbdsurg
