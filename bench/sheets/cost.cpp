// SPDX-License-Identifier: Apache-2.0
#include "bench/sheets/cost.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/solver/solver.h"

#include "bench/support/timing.h"
#include "tests/support/meshes.h"
#include "tests/support/sheet_meshes.h"

namespace pbdsurg::bench {
namespace {

constexpr double kEdge = 2.5e-3;  // m
constexpr float kStep = 1e-3F;    // s
constexpr int kFewSweeps = 4, kMoreSweeps = 20;
constexpr int kRounds = 25;

const SheetMaterial kMembrane{.thickness = 5e-4F, .youngs_modulus = 60e3F, .poissons_ratio = 0.45F};

// Moved from its rest shape, so that no constraint has nothing to do.
Solver make_solver(const Scene& scene, SolverOptions options, int sweeps) {
  options.substeps = 1;
  options.iterations = sweeps;
  options.coarse_correction = CoarseCorrection::off;  // which has no sheets
  Solver solver(scene, options);
  std::vector<Eigen::Vector3f> start;
  for (std::size_t v = 0; v < scene.positions().size(); ++v) {
    const Eigen::Vector3d way(random_unit(1, v, 0), random_unit(1, v, 1), random_unit(1, v, 2));
    start.emplace_back((scene.positions()[v] + 0.05 * kEdge * way).cast<float>());
  }
  solver.write_positions(start);
  return solver;
}

// A sweep's time by two solvers that differ in their number alone.
class Subject {
 public:
  Subject(const Scene& scene, std::size_t elements, const SolverOptions& options)
      : elements_(elements),
        few_(make_solver(scene, options, kFewSweeps)),
        many_(make_solver(scene, options, kFewSweeps + kMoreSweeps)) {}

  // ns, of an element
  double time_sweep() {
    const double few = time_of([&] { few_.step(kStep); });
    const double many = time_of([&] { many_.step(kStep); });
    return 1e6 * (many - few) / (kMoreSweeps * static_cast<double>(elements_));
  }

 private:
  std::size_t elements_;
  Solver few_, many_;
};

Subject make_tetrahedra(const SolverOptions& options) {
  const TetMesh mesh = testing::make_box({16, 16, 15}, kEdge, 0.1);
  Scene scene;
  scene.add_body("block", mesh, {.youngs_modulus = 60e3F});
  return {scene, mesh.tets().size(), options};
}

Subject make_subject(const std::vector<Eigen::Vector3d>& positions,
                     const std::vector<Triangle>& triangles, const SolverOptions& options,
                     float damping = 0) {
  SheetMaterial material = kMembrane;
  material.damping = damping;
  Scene scene;
  scene.add_sheet("sheet", positions, triangles, material);
  return {scene, triangles.size(), options};
}

// All faces of a block of tetrahedra. Of these, only its edges outside have two triangles.
Subject make_foam(const SolverOptions& options) {
  const TetMesh mesh = testing::make_box({12, 12, 13}, kEdge, 0.1);
  std::set<Triangle> faces;
  for (const Tet& tet : mesh.tets()) {
    for (std::size_t left_out = 0; left_out < 4; ++left_out) {
      Triangle face{tet[(left_out + 1) % 4], tet[(left_out + 2) % 4], tet[(left_out + 3) % 4]};
      std::ranges::sort(face);
      faces.insert(face);
    }
  }
  return make_subject({mesh.positions().begin(), mesh.positions().end()},
                      {faces.begin(), faces.end()}, options);
}

const testing::SheetMesh& flat_mesh() {
  static const testing::SheetMesh mesh = testing::make_sheet({108, 108}, kEdge, 0.1);
  return mesh;
}

Subject make_flat(const SolverOptions& options, float damping = 0) {
  return make_subject(flat_mesh().positions, flat_mesh().triangles, options, damping);
}

// A third of a tube.
Subject make_bent(const SolverOptions& options) {
  constexpr double kRadius = 0.12;  // m
  std::vector<Eigen::Vector3d> positions = flat_mesh().positions;
  for (Eigen::Vector3d& x : positions) {
    const double angle = x.x() / kRadius;
    x = {kRadius * std::sin(angle), x.y(), kRadius * (1 - std::cos(angle))};
  }
  return make_subject(positions, flat_mesh().triangles, options);
}

}  // namespace

SheetCost sheet_cost(const SolverOptions& options) {
  constexpr float kFriction = 1e-3F;  // s, that of tissues::membrane()
  std::array<Subject, 5> subjects{make_tetrahedra(options), make_flat(options), make_bent(options),
                                  make_flat(options, kFriction), make_foam(options)};
  std::array<std::vector<double>, 5> times;
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t i = 0; i < subjects.size(); ++i) {
      times[i].push_back(subjects[i].time_sweep());
    }
  }
  const auto in_tetrahedra = [&](std::size_t i) { return median_ratio(times[i], times[0]); };
  return {median(times[0]), in_tetrahedra(1), in_tetrahedra(2), in_tetrahedra(3), in_tetrahedra(4)};
}

}  // namespace pbdsurg::bench
