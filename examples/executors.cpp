// SPDX-License-Identifier: Apache-2.0
// Steps one scene by one thread, by two, by as many as pay, and on a GPU where there is one.
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <vector>

#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/library.h"
#ifdef HAS_CUDA  // set by this program's build where it links pbdsurg::cuda
#include "pbdsurg/cuda/device.h"
#endif

namespace {

using pbdsurg::Executor;

std::uint64_t run(const pbdsurg::Scene& scene, const Executor& executor, pbdsurg::MathMode math) {
  pbdsurg::SolverOptions options;
  options.executor = executor;
  options.math = math;
  options.composition = pbdsurg::PlanComposition::separate;  // the default differs on a GPU
  pbdsurg::Solver solver(scene, options);
  const auto start = std::chrono::steady_clock::now();
  constexpr int kSteps = 20;
  for (int step = 0; step < kSteps; ++step) {
    solver.step(5e-3F);  // s
  }
  const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - start;
  std::printf("%5.2f ms a step by %s\n", time.count() / kSteps, solver.backend_name());
  return solver.state_hash();
}

}  // namespace

int main() try {
  pbdsurg::TetrahedralizeOptions options;
  options.spacing = 8e-3;  // m
  const pbdsurg::ImplicitShape box =
      pbdsurg::rounded_box_shape({0, 0, 0}, {0.06, 0.03, 0.03}, 4e-3);
  pbdsurg::Scene scene;
  const pbdsurg::BodyId liver = scene.add_body("liver", pbdsurg::tetrahedralize(box, options).mesh,
                                               pbdsurg::tissues::liver().mechanics);
  scene.fix_where(liver, [](const Eigen::Vector3d& x) { return x.x() < -0.055; });

  std::vector<Executor> executors{pbdsurg::executor::serial(), pbdsurg::executor::threads(2),
                                  pbdsurg::executor::threads()};
#ifdef HAS_CUDA
  executors.push_back(pbdsurg::cuda::best());  // threads where there is no GPU
#endif
  // strict arithmetic: the serial bits, whoever works
  bool is_same = true;
  std::uint64_t serial = 0;
  for (const Executor& executor : executors) {
    const std::uint64_t hash = run(scene, executor, pbdsurg::MathMode::strict);
    serial = executor == executors[0] ? hash : serial;
    is_same = is_same && hash == serial;
  }
  std::printf("strict: %s\n", is_same ? "the same bits" : "other bits");

  // fast arithmetic, the default: the same bits for any number of threads
  const std::uint64_t two = run(scene, executors[1], pbdsurg::MathMode::fast);
  const bool is_repeated = run(scene, executors[2], pbdsurg::MathMode::fast) == two;
  std::printf("fast: %s\n", is_repeated ? "the same bits" : "other bits");
  return is_same && is_repeated ? 0 : 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "executors: %s\n", error.what());
  return 2;
}
