// SPDX-License-Identifier: Apache-2.0
// How fields use a device, with one that the host stands in for; tests/cuda/field_test.cpp asks a
// real one.
#include "lib/heat/device_system.h"

#include <new>
#include <string>
#include <utility>

#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/topology.h"

#include "lib/base/executor_state.h"
#include "tests/support/field_backend_cases.h"
#include "tests/support/heat_tissues.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::kLiver;

int solutions_until_failure = -1;  // none, if negative
bool is_memory_short = false;
int made_count = 0;

// Does on the host what DeviceSystem says.
class StandIn final : public DeviceSystem {
 public:
  bool set_rows(const SystemRows& rows, std::span<const Tet> corners) override {
    corners_.assign(corners.begin(), corners.end());
    system_.set_rows(rows.row_count(), corners);
    if (!rows.groups.empty()) {
      system_.set_groups(rows.groups);
    }
    return true;
  }

  void set_conductances(std::span<const std::array<double, 6>> conductances) override {
    if (std::exchange(is_memory_short, false)) {
      throw std::bad_alloc();
    }
    conductances_.assign(conductances.begin(), conductances.end());
  }

  LinearSolveReport solve(const DeviceSolve& input, std::span<double> x) override {
    if (solutions_until_failure-- == 0) {
      throw Error("the device is lost");
    }
    std::vector<std::array<double, 6>> scaled = conductances_;
    for (std::size_t t = 0; t < scaled.size(); ++t) {
      for (double& value : scaled[t]) {
        value *= input.scales.empty() ? 1 : input.scales[t];
      }
    }
    system_.set_couplings(scaled);
    std::vector<double> added(input.added.begin(), input.added.end());
    std::vector<double> b(input.b.begin(), input.b.end());
    for (std::size_t row = 0; row < added.size() && input.is_relative; ++row) {
      const double sum = system_.coupling_sum(static_cast<Index>(row));
      added[row] *= sum;
      b[row] *= sum;
    }
    system_.set_added(added);
    const LinearSolveReport report = system_.solve(b, x, input.options);
    if (!input.tet_heat.empty()) {
      for (std::size_t t = 0; t < scaled.size(); ++t) {
        input.tet_heat[t] = 0;
        for (std::size_t k = 0; k < 6; ++k) {
          const double drop = x[corners_[t][kTetEdges[k][0]]] - x[corners_[t][kTetEdges[k][1]]];
          input.tet_heat[t] += scaled[t][k] * drop * drop;
        }
      }
      system_.sum_at_corners(input.tet_heat, input.row_heat);
      for (std::size_t row = 0; row < b.size(); ++row) {
        input.row_heat[row] = input.row_heat[row] / 4 + b[row] * (1 - x[row]) * (1 - x[row]);
      }
    }
    return report;
  }

 private:
  LocalSystem system_;
  std::vector<Tet> corners_;
  std::vector<std::array<double, 6>> conductances_;
};

class FieldDeviceOfTest final : public Device, public FieldDevice {
 public:
  [[nodiscard]] const std::string& name() const noexcept override { return name_; }
  [[nodiscard]] std::unique_ptr<DeviceSystem> make_system() override {
    ++made_count;
    if (refuses) {
      throw BackendUnavailable("no memory, the test says");
    }
    return std::make_unique<StandIn>();
  }

  bool refuses = false;

 private:
  std::string name_ = "stand-in";
};

Executor stand_in() {
  solutions_until_failure = -1;
  return Executor(
      std::make_shared<ExecutorState>(std::make_shared<FieldDeviceOfTest>(), Executor()));
}

}  // namespace

// Would catch a table of edges that does not fit kTetEdges.
TEST_CASE("device system: edges of corners are those of the tetrahedron", "[unit]") {
  for (int corner = 0; corner < 4; ++corner) {
    for (int k = 0; k < 3; ++k) {
      const int other = k < corner ? k : k + 1;
      CHECK(kTetEdges[edge_of_corner(corner, k)] ==
            std::array<int, 2>{std::min(corner, other), std::max(corner, other)});
    }
  }
}

// Would catch a region, conductances, contacts or a start that the device does not hear of, and
// heat that is left from before.
TEST_CASE("device system: a potential is what the CPU finds", "[unit]") {
  const Executor device = stand_in();
  const Index size = GENERATE(8, 14, 26);
  testing::check_potentials({size, size, size / 2 + 2}, stand_in());
}

TEST_CASE("device system: temperatures are what the CPU finds", "[unit]") {
  const Executor device = stand_in();
  testing::check_temperatures({6, 5, 4}, stand_in());
  testing::check_temperatures({16, 15, 8}, stand_in());
}

// Would catch a device that is asked for a handful of rows, or never.
TEST_CASE("device system: small systems stay on the host", "[unit]") {
  const Executor device = stand_in();
  const auto is_on_device = [](std::array<Index, 3> cells, const PotentialOptions& options) {
    return testing::burn_block(cells, options).reports.front().is_on_device;
  };
  CHECK_FALSE(is_on_device({5, 5, 4}, {.executor = device}));
  CHECK(is_on_device({18, 18, 12}, {.executor = device}));
  CHECK(is_on_device({5, 5, 4}, {.executor = device, .device_rows = 0}));
  CHECK_FALSE(is_on_device({18, 18, 12}, {}));
}

// Would catch devices that are opened and never used, and a wish that is heard late.
TEST_CASE("device system: a field has one when it needs it", "[unit]") {
  const Executor device = stand_in();
  const TetMesh shape = testing::make_box({15, 15, 7}, 1e-3);  // more rows than a device is worth
  const std::vector<HeatSource> sources{{40, 3}};
  made_count = 0;
  HeatField field(shape, kLiver, {}, {.executor = device});
  const PotentialField potential(field);
  CHECK_FALSE(field.step(1e-3, sources).is_on_device);
  CHECK(made_count == 0);

  HeatField whole(shape, kLiver, {}, {.active_rise = 0, .executor = device});
  CHECK(whole.step(1e-3, sources).is_on_device);
  CHECK(whole.step(1e-3, sources).is_on_device);
  CHECK(made_count == 1);
  HeatField copy = whole;
  CHECK(made_count == 1);
  CHECK(copy.step(1e-3, sources).is_on_device);
  CHECK(made_count == 2);
}

// Would catch a device that is left out without a word, and one that ends a program that could go
// on without.
TEST_CASE("device system: a device that refuses says why, or the host works instead", "[unit]") {
  const TetMesh shape = testing::make_box({3, 3, 3}, 1e-3);
  const std::vector<HeatSource> sources{{5, 3}};
  const auto device = std::make_shared<FieldDeviceOfTest>();
  device->refuses = true;
  const auto field_on = [&](const Executor& instead) {
    const Executor executor(std::make_shared<ExecutorState>(device, instead));
    return HeatField(shape, kLiver, {}, {.active_rise = 0, .executor = executor, .device_rows = 0});
  };
  HeatField strict = field_on({});
  CHECK_THROWS_AS(strict.step(1e-3, sources), BackendUnavailable);
  CHECK_THROWS_WITH(strict.step(1e-3, sources), testing::ContainsSubstring("no memory"));
  HeatField careful = field_on(executor::threads());
  made_count = 0;
  CHECK_FALSE(careful.step(1e-3, sources).is_on_device);
  CHECK_FALSE(careful.step(1e-3, sources).is_on_device);
  CHECK(made_count == 1);
  CHECK_THROWS_WITH(HeatField(shape, kLiver, {}, {.device_rows = -1}),
                    testing::ContainsSubstring("device_rows"));
}

// Would catch heat without a solution, a step half taken, and a device that is asked no more.
TEST_CASE("device system: where the device fails, nothing is heated and all can go on", "[unit]") {
  const Executor device = stand_in();
  const TetMesh shape = testing::make_box({6, 6, 5}, 1e-3);
  testing::Conductor at(
      shape, [](const auto& x) { return x.x() < 1e-4; },
      [](const auto& x) { return x.x() > 5.9e-3; }, 0.3, {.executor = device, .device_rows = 0});
  is_memory_short = true;
  CHECK_THROWS_AS(at.solve(), std::bad_alloc);
  const double whole = at.solve().conductance;
  CHECK(whole == Approx(0.3 * 6e-3 * 5e-3 / 6e-3).epsilon(1e-3));
  at.conductivities[0] *= 2;
  solutions_until_failure = 0;
  CHECK_THROWS_WITH(at.solve(), "the device is lost");
  CHECK(at.field.report().conductance == 0);
  CHECK_FALSE(at.field.report().is_closed);
  CHECK(at.field.vertex_heat().empty());
  CHECK(at.solve().conductance == Approx(whole).epsilon(0.05));

  HeatField field(shape, kLiver, {}, {.executor = device, .device_rows = 0});
  const std::vector<HeatSource> sources{{40, 3}};
  is_memory_short = true;
  CHECK_THROWS_AS(field.step(1e-3, sources), std::bad_alloc);
  CHECK(field.step(1e-3, sources).hottest > kBodyTemperature + 1e-3);
  const std::vector<double> before(field.temperatures().begin(), field.temperatures().end());
  solutions_until_failure = 0;
  CHECK_THROWS_AS(field.step(1e-3, sources), Error);
  CHECK(std::equal(before.begin(), before.end(), field.temperatures().begin()));
  CHECK(field.step(1e-3, sources).accepted);
}

}  // namespace pbdsurg
