// SPDX-License-Identifier: Apache-2.0
#include "bench/convergence/methods.h"

#include "pbdsurg/solver/solver.h"

#include "bench/convergence/jacobi.h"

namespace pbdsurg::bench {
namespace {

class SolverStepper : public Stepper {
 public:
  SolverStepper(const Scene& scene, const SolverOptions& options) : solver_(scene, options) {}
  void write_positions(const std::vector<Eigen::Vector3f>& positions) override {
    solver_.write_positions(positions);
  }
  void step(float dt) override { solver_.step(dt); }
  [[nodiscard]] std::vector<Eigen::Vector3f> positions() const override {
    return solver_.positions();
  }

 private:
  Solver solver_;
};

class JacobiStepper : public Stepper {
 public:
  explicit JacobiStepper(const JacobiLoop& loop) : loop_(loop) {}
  void write_positions(const std::vector<Eigen::Vector3f>& positions) override {
    loop_.write_positions(positions);
  }
  void step(float dt) override { loop_.step(dt); }
  [[nodiscard]] std::vector<Eigen::Vector3f> positions() const override {
    return loop_.positions();
  }

 private:
  JacobiLoop loop_;
};

constexpr float kOverRelaxation = 1.7F;  // 1.3 and 1.5 take longer to 1 %

}  // namespace

std::vector<Method> make_methods(const Cantilever& bar, float damping, int threads) {
  const auto solver = [&](SolverMethod method, float over_relaxation = 1) {
    SolverOptions options;
    options.method = method;
    options.over_relaxation = over_relaxation;
    options.damping = damping;
    options.executor = executor::threads(threads);
    if (method == SolverMethod::projection) {
      options.composition = PlanComposition::nested;  // with the fewest waits
    }
    return [&bar, options](const Setting& setting) mutable -> std::unique_ptr<Stepper> {
      options.substeps = setting.substeps;
      options.iterations = setting.iterations;
      return std::make_unique<SolverStepper>(bar.scene, options);
    };
  };
  const auto jacobi = [&](JacobiSum sum) {
    return [&bar, sum, damping](const Setting& setting) -> std::unique_ptr<Stepper> {
      return std::make_unique<JacobiStepper>(
          JacobiLoop(bar, sum, setting.substeps, setting.iterations, damping));
    };
  };
  const std::vector<Setting> block_settings{{1, 1}, {1, 2}, {1, 3}, {1, 5}, {1, 10}, {1, 30},
                                            {2, 1}, {2, 3}, {3, 2}, {5, 1}, {10, 1}, {30, 1}};
  const std::vector<Setting> relaxed_settings{{1, 3}, {1, 5}, {1, 7}, {1, 10}, {2, 3}, {3, 2}};
  const std::vector<Setting> rival_settings{{1, 30}, {30, 1}};
  return {
      {"sweeps", threads, {{1, 30}}, false, solver(SolverMethod::projection)},
      {"small_steps", threads, {{30, 1}}, true, solver(SolverMethod::projection)},
      {"vertex_block", threads, block_settings, false, solver(SolverMethod::vertex_block)},
      {"relaxed_block", threads, relaxed_settings, false,
       solver(SolverMethod::vertex_block, kOverRelaxation)},
      {"jacobi_mean", 1, rival_settings, true, jacobi(JacobiSum::averaged)},
      {"jacobi_sum", 1, rival_settings, true, jacobi(JacobiSum::plain)},
  };
}

}  // namespace pbdsurg::bench
