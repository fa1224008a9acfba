// SPDX-License-Identifier: Apache-2.0
// Bodies that meet each other on a device: strict has the bits of the serial backend.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "pbdsurg/cuda/device.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/cuda/strict_pair.h"
#include "tests/support/catch.h"
#include "tests/support/free_block.h"
#include "tests/support/meshes.h"
#include "tests/support/soft_block.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using testing::placed_box;
using testing::StrictPair;

constexpr float kStep = 5e-3F;
constexpr TissueContact kContact{0.5e-3F, 0.2F};
constexpr double kEdge = 5e-3;  // m
constexpr Material kSoft{.model = ElasticModel::neo_hookean,
                         .youngs_modulus = 3e3F,
                         .poissons_ratio = 0.4F,
                         .damping = 0.01F};

Eigen::Affine3d at(const Vector3d& x) {
  return Eigen::Affine3d(Eigen::Translation3d(x));
}

// A block that stands fast, and another above it with other edges, which hangs by its upper face if
// it is no free one.
Scene make_stack(bool is_free, const SolverOptions& options, float gravity = 30) {
  Material soft = kSoft, firm = kSoft;
  firm.youngs_modulus = 50e3F;  // so that the table does not sink away
  if (options.method == SolverMethod::explicit_steps) {
    soft.damping = firm.damping = 0;
  }
  constexpr double kGap = 0.4e-3, kUpperEdge = 4e-3;
  Scene scene;
  scene.set_gravity({0, 0, -gravity});
  scene.fix_where(scene.add_body("table", placed_box({6, 6, 3}, kEdge, at({0, 0, 0})), firm),
                  [](const Vector3d& x) { return x.z() < 1e-9; });
  const BodyId upper = scene.add_body(
      "block", placed_box({5, 5, 2}, kUpperEdge, at({5.3e-3, 4.1e-3, 3 * kEdge + kGap})), soft);
  if (!is_free) {
    scene.fix_where(
        upper, [](const Vector3d& x) { return x.z() > 3 * kEdge + kGap + 2 * kUpperEdge - 1e-9; });
  }
  return scene;
}

// A strip of two triangles that stands fast; across it another, which one corner holds.
Scene crossing_strips() {
  constexpr double kLength = 20e-3, kWidth = 6e-3;
  Scene scene;
  scene.set_gravity({0, 0, -9.81F});
  for (const int along : {0, 1}) {
    std::vector<Vector3d> points;
    for (const auto& [l, w] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
      Vector3d point(0, 0, along * 0.6e-3);
      point[along] = l * kLength;
      point[1 - along] = w * kWidth;
      points.push_back(point);
    }
    const BodyId strip =
        scene.add_sheet(along == 0 ? "lower" : "upper", points,
                        std::array<Triangle, 2>{{{0, 1, 2}, {0, 2, 3}}}, {.damping = 0.1F});
    if (along == 0) {
      scene.fix_vertices(strip, std::array{0, 1, 2, 3});
    } else {
      scene.fix_vertices(strip, std::array{0});
    }
  }
  return scene;
}

// A row of particles that falls across a block; its first one hangs.
Scene thread_on_block() {
  Scene scene;
  scene.set_gravity({0, 0, -9.81F});
  scene.fix_where(scene.add_body("block", placed_box({3, 3, 2}, kEdge, at({0, 0, 0})), kSoft),
                  [](const Vector3d& x) { return x.z() < 1e-9; });
  std::vector<Vector3d> points;
  for (int i = 0; i < 12; ++i) {
    points.emplace_back(-5e-3 + 2.1e-3 * i, 6.3e-3, 2 * kEdge + 0.7e-3);
  }
  const BodyId thread = scene.add_particles("thread", points, 1e-4);
  const Index first = scene.body(thread).first_vertex;
  for (Index i = 0; i + 1 < 12; ++i) {
    scene.add_link({first + i, first + i + 1, 2.1e-3F, {}});
  }
  scene.fix_vertices(thread, std::array{0});
  return scene;
}

void check_same_touches(const StrictPair& pair, Index copy = 0) {
  const std::vector<BodyContact> expected = pair.serial.body_contacts(copy);
  const std::vector<BodyContact> found = pair.device.body_contacts(copy);
  REQUIRE(found.size() == expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    INFO("contact " << i);
    CHECK(found[i].vertices == expected[i].vertices);
    CHECK(found[i].weights == expected[i].weights);
    CHECK(found[i].first == expected[i].first);
    CHECK(found[i].normal == expected[i].normal);
    CHECK(found[i].distance == expected[i].distance);
    CHECK(found[i].force == expected[i].force);
  }
}

std::size_t pushing(const Solver& solver, int first_count) {
  return static_cast<std::size_t>(
      std::ranges::count_if(solver.body_contacts(), [&](const BodyContact& contact) {
        return contact.first_count == first_count && contact.force.norm() > 0;
      }));
}

void meet(StrictPair& pair, Index first = 0, Index second = 1) {
  pair.both([&](Solver& solver) { solver.set_body_contact(first, second, kContact); });
}

std::size_t step(StrictPair& pair, int steps, int first_count = 1) {
  std::size_t most = 0;
  for (int i = 0; i < steps; ++i) {
    CAPTURE(i);
    pair.step_and_compare(kStep);
    check_same_touches(pair);
    most = std::max(most, pushing(pair.serial, first_count));
  }
  return most;
}

SolverOptions implicit_options() {
  return GENERATE(SolverOptions{.method = SolverMethod::projection,
                                .substeps = 4,
                                .iterations = 4,
                                .integration = TimeIntegration::implicit_euler},
                  SolverOptions{.method = SolverMethod::projection,
                                .substeps = 4,
                                .iterations = 2,
                                .integration = TimeIntegration::bdf2},
                  SolverOptions{.method = SolverMethod::vertex_block,
                                .substeps = 1,
                                .iterations = 10,
                                .integration = TimeIntegration::implicit_euler},
                  SolverOptions{.method = SolverMethod::vertex_block},
                  SolverOptions{.method = SolverMethod::vertex_block,
                                .substeps = 2,
                                .iterations = 4,
                                .integration = TimeIntegration::bdf2});
}

SolverOptions any_options() {
  return GENERATE(0, 1) == 0 ? implicit_options()
                             : SolverOptions{.method = SolverMethod::explicit_steps};
}

}  // namespace

// Would catch vertices and edges that a kernel misses or meets twice, another nearest triangle or
// side, another order of contacts or of holds at a vertex, and forces that are not the host's.
TEST_CASE("cuda bodies: a block that hangs on another has the serial bits", "[device]") {
  const SolverOptions options = any_options();
  CAPTURE(static_cast<int>(options.method), static_cast<int>(options.integration));
  StrictPair pair(make_stack(false, options), options, DeviceStrategy::automatic);
  meet(pair);
  CHECK(step(pair, 30) > 20);
}

TEST_CASE("cuda bodies: a free block that falls on another has the serial bits", "[device]") {
  const SolverOptions options = any_options();
  CAPTURE(static_cast<int>(options.method), static_cast<int>(options.integration));
  StrictPair pair(make_stack(true, options), options, DeviceStrategy::automatic);
  meet(pair);
  CHECK(step(pair, 30) > 5);
}

TEST_CASE("cuda bodies: strips that cross have the serial bits", "[device]") {
  const SolverOptions options = implicit_options();
  CAPTURE(static_cast<int>(options.method), static_cast<int>(options.integration));
  StrictPair pair(crossing_strips(), options, DeviceStrategy::automatic);
  meet(pair);
  CHECK(step(pair, 40, 2) > 0);
}

TEST_CASE("cuda bodies: a thread on a block has the serial bits", "[device]") {
  const SolverOptions options = implicit_options();
  CAPTURE(static_cast<int>(options.method), static_cast<int>(options.integration));
  StrictPair pair(thread_on_block(), options, DeviceStrategy::automatic);
  meet(pair);
  CHECK(step(pair, 40) > 2);
}

// Would catch pieces that touch each other and do not move at once, or in another order; and
// momentum that they do not keep together.
TEST_CASE("cuda bodies: free blocks that lie on each other have the serial bits", "[device]") {
  const SolverOptions options = implicit_options();
  CAPTURE(static_cast<int>(options.method), static_cast<int>(options.integration));
  constexpr double kGap = 0.4e-3, kHeight = 2 * 4e-3 + kGap;
  Scene scene = make_stack(true, options, 10);
  for (const double x : {5e-3, 16e-3}) {  // two that stand on the upper one
    scene.add_body(x < 10e-3 ? "left" : "right",
                   placed_box({2, 3, 2}, 3.7e-3, at({x, 6e-3, 3 * kEdge + kGap + kHeight})), kSoft);
  }
  StrictPair pair(scene, options, DeviceStrategy::automatic);
  meet(pair, 0, 1);
  meet(pair, 1, 2);
  meet(pair, 1, 3);
  const Capsule ball{{0, 0, 0}, {0, 0, 0}, 4e-3F};
  ToolId pusher{};
  pair.both([&](Solver& solver) {
    pusher = solver.add_tool({&ball, 1}, testing::at({8e-3F, 11e-3F, 36e-3F}),
                             {ContactFeatures::all, 0.2F});
  });
  for (int i = 1; i <= 40; ++i) {  // pushes, goes on along, lifts
    CAPTURE(i);
    const float t = static_cast<float>(i) / 40;
    pair.both([&](Solver& solver) {
      solver.move_tool(pusher,
                       testing::at({8e-3F + 4e-3F * t, 11e-3F, 36e-3F - 6e-3F * std::sin(3 * t)}));
    });
    pair.step_and_compare(kStep);
    check_same_touches(pair);
    CHECK(pair.device.tool_force(pusher) == pair.serial.tool_force(pusher));
  }
}

// Would catch more contacts than a block of a kernel has threads for, of which each is gone through
// where it lies.
TEST_CASE("cuda bodies: hundreds of contacts have the serial bits", "[device]") {
  const SolverOptions options = implicit_options();
  CAPTURE(static_cast<int>(options.method), static_cast<int>(options.integration));
  constexpr double kTableEdge = 2e-3, kUpperEdge = 1.9e-3;
  Scene scene;
  scene.set_gravity({0, 0, -30});
  scene.fix_where(
      scene.add_body("table", placed_box({18, 18, 1}, kTableEdge, at({0, 0, 0})), kSoft),
      [](const Vector3d& x) { return x.z() < 1e-9; });
  scene.add_body("plate",
                 placed_box({18, 18, 1}, kUpperEdge, at({0.8e-3, 0.7e-3, kTableEdge + 0.4e-3})),
                 kSoft);
  StrictPair pair(scene, options, DeviceStrategy::automatic);
  meet(pair);
  CHECK(step(pair, 6) > 512);
}

// Would catch neighbours that meet, and parts of a body that pass through each other.
TEST_CASE("cuda bodies: a body that meets itself has the serial bits", "[device]") {
  const SolverOptions options = implicit_options();
  CAPTURE(static_cast<int>(options.method), static_cast<int>(options.integration));
  constexpr double kCell = 4e-3;
  const TetMesh box = testing::make_box({5, 2, 5}, kCell);
  std::vector<Tet> tets;
  for (const Tet& tet : box.tets()) {
    Vector3d center = Vector3d::Zero();
    for (const Index v : tet) {
      center += box.positions()[v] / 4;
    }
    if (center.z() < kCell || center.x() < 2 * kCell || center.x() > 3 * kCell) {
      tets.push_back(tet);
    }
  }
  Scene scene;
  scene.fix_where(
      scene.add_body("U", TetMesh({box.positions().begin(), box.positions().end()}, tets), kSoft),
      [](const Vector3d& x) { return x.z() < 1e-9; });
  std::vector<Index> pushed;
  std::vector<Vector3f> forces;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    const Vector3d& x = scene.positions()[v];
    if (x.z() > 5 * kCell - 1e-9 && (x.x() < 1e-9 || x.x() > 5 * kCell - 1e-9)) {
      pushed.push_back(v);
      forces.emplace_back(x.x() < 1e-9 ? 3e-3F : -3e-3F, 0, 0);
    }
  }
  StrictPair pair(scene, options, DeviceStrategy::automatic);
  meet(pair, 0, 0);
  pair.both([&](Solver& solver) { solver.set_forces(pushed, forces); });
  CHECK(step(pair, 60) > 1);
}

// Would catch surfaces that a device searches as they were before an edit, contacts that it goes on
// from after one, room that it does not make, and pairs that come and go.
TEST_CASE("cuda bodies: edits of bodies in contact keep the serial bits", "[device]") {
  const SolverOptions options = any_options();
  CAPTURE(static_cast<int>(options.method), static_cast<int>(options.integration));
  StrictPair pair(make_stack(false, options), options, DeviceStrategy::automatic);
  meet(pair);
  for (int i = 1; i <= 36; ++i) {
    CAPTURE(i);
    pair.both([&](Solver& solver) {
      if (i == 8) {  // of both surfaces
        TopologyEdit edit;
        for (Index t = 0; t < 60; ++t) {
          edit.remove_tets.push_back(solver.tissue().tets_of(0)[648 - 1 - 7 * t]);
        }
        for (Index t = 0; t < 20; ++t) {
          edit.remove_tets.push_back(solver.tissue().tets_of(1)[11 * t]);
        }
        std::ranges::sort(edit.remove_tets);
        solver.tissue().apply(edit);
      } else if (i == 14) {
        solver.tissue().undo();
      } else if (i == 18) {
        solver.clear_body_contact(0, 1);
      } else if (i == 22) {
        solver.set_body_contact(0, 1, {0.8e-3F, 0});
      } else if (i == 28) {
        solver.set_body_contact(1, 1, kContact);
      }
    });
    pair.step_and_compare(kStep);
    check_same_touches(pair);
  }
}

// Would catch copies that share contacts, and a state that is written without them; and a device
// that drops others than a host.
TEST_CASE("cuda bodies: copies, snapshots and a small capacity keep the serial bits", "[device]") {
  SolverOptions options = implicit_options();
  options.copies = 2;
  options.contact_capacity = GENERATE(4096, 9);
  StrictPair pair(make_stack(false, options), options, DeviceStrategy::automatic);
  meet(pair);
  pair.both([](Solver& solver) {  // on the second alone
    solver.set_forces(std::array{solver.vertex_count() - 1, solver.vertex_count() - 60},
                      std::array{Vector3f(0.01F, 0, -0.02F), Vector3f(0, 0.01F, -0.02F)}, 1);
  });
  Snapshot serial, device;
  for (int i = 1; i <= 24; ++i) {
    CAPTURE(i);
    if (i == 8) {
      serial = pair.serial.snapshot();
      device = pair.device.snapshot();
    } else if (i == 16) {
      pair.serial.restore(serial);
      pair.device.restore(device);
    }
    pair.step_and_compare(kStep);
    for (const Index copy : {0, 1}) {
      check_same_touches(pair, copy);
    }
    CHECK(pair.device.last_report().dropped_contacts == pair.serial.last_report().dropped_contacts);
  }
}

// Would catch jaws that let what other bodies push follow them.
TEST_CASE("cuda bodies: jaws that slip beside another body have the serial bits", "[device]") {
  const SolverOptions options = implicit_options();
  CAPTURE(static_cast<int>(options.method), static_cast<int>(options.integration));
  StrictPair pair(make_stack(true, options), options, DeviceStrategy::automatic);
  meet(pair);
  // of the lower corner of the block, which lies on the table, and of what is above it
  std::vector<TissuePoint> points;
  const Vector3d corner(5.3e-3, 4.1e-3, 3 * kEdge + 0.4e-3);
  const Index first = pair.serial.tissue().body(1).first_vertex;
  for (Index v = first; v < pair.serial.vertex_count(); ++v) {
    if ((pair.serial.tissue().rest_positions()[v] - corner).norm() < 9e-3) {
      points.push_back({{v, kInvalidIndex, kInvalidIndex}, {1, 0, 0}});
    }
  }
  Grip grip{.clamp_force = 0.004F, .friction = 0.5F};
  grip.pad.half_length = grip.pad.half_width = 20e-3F;
  ToolId jaws{};
  pair.both([&](Solver& solver) {
    jaws = solver.add_tool({}, testing::at(corner.cast<float>()));
    solver.grasp(jaws, points, grip);
  });
  bool has_slipped = false;
  for (int i = 1; i <= 40; ++i) {
    CAPTURE(i);
    const Vector3f way(0.1e-3F * static_cast<float>(i), 0, 0);
    pair.both(
        [&](Solver& solver) { solver.move_tool(jaws, testing::at(corner.cast<float>() + way)); });
    pair.step_and_compare(kStep);
    check_same_touches(pair);
    CHECK(pair.device.tool_grip(jaws).pull == pair.serial.tool_grip(jaws).pull);
    has_slipped |= pair.serial.tool_grip(jaws).state == GripState::slipping;
  }
  CHECK(has_slipped);
}

// Would catch fast kernels that are another computation, and contacts that are told with positions
// of before the step.
TEST_CASE("cuda bodies: fast kernels feel what the serial backend feels", "[device]") {
  struct Told {
    Vector3f force = Vector3f::Zero();
    float least = 1;  // m
  };
  const auto told_by = [](const Executor& executor) {
    SolverOptions options;
    options.executor = executor;
    Solver solver(make_stack(false, options), options);
    solver.set_body_contact(0, 1, kContact);
    Told told;
    for (int i = 0; i < 100; ++i) {
      solver.step(kStep);
    }
    for (const BodyContact& contact : solver.body_contacts()) {
      told.force += contact.first == 1 ? contact.force : Vector3f(-contact.force);
      told.least = std::min(told.least, contact.distance);
    }
    return told;
  };
  const Told expected = told_by(executor::serial()), found = told_by(cuda::device());
  CHECK(expected.force.z() > 1e-3F);
  CHECK((found.force - expected.force).norm() < 0.01F * expected.force.norm());
  CHECK(std::abs(found.least - expected.least) < 0.02F * kContact.thickness);
}

}  // namespace pbdsurg
