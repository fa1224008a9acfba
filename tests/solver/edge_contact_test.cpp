// SPDX-License-Identifier: Apache-2.0
// Contact where edges cross far from any vertex: of sheets, threads and sharp bodies.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/solver/solver.h"

#include "tests/support/catch.h"
#include "tests/support/free_block.h"
#include "tests/support/meshes.h"
#include "tests/support/solver_cases.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using testing::any_integration;
using testing::any_sweeping_method;
using testing::ContainsSubstring;
using testing::kUsualStep;
using testing::quick_options;

constexpr TissueContact kThinContact{0.5e-3F, 0.3F};
constexpr float kFreeFall = 9.81F;
constexpr double kBead = 1e-4;  // kg

// A strip of two triangles, 40 mm long and 12 mm wide, along the first or the second axis.
BodyId add_strip(Scene& scene, const char* name, int along, double height) {
  constexpr double kLength = 20e-3, kWidth = 6e-3;
  std::vector<Vector3d> points;
  for (const auto& [l, w] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    Vector3d point(0, 0, height);
    point[along] = l * kLength;
    point[1 - along] = w * kWidth;
    points.push_back(point);
  }
  return scene.add_sheet(name, points, std::array<Triangle, 2>{{{0, 1, 2}, {0, 2, 3}}},
                         {.damping = 0.1F});
}

// A closed row of particles, joined by links.
BodyId add_ring(Scene& scene, const char* name, const std::vector<Vector3d>& points) {
  const BodyId ring = scene.add_particles(name, points, kBead);
  const Index first = scene.body(ring).first_vertex;
  const auto count = static_cast<Index>(points.size());
  for (Index i = 0; i < count; ++i) {
    const Index j = (i + 1) % count;
    scene.add_link({first + i, first + j, static_cast<float>((points[i] - points[j]).norm()), {}});
  }
  return ring;
}

// A bar of three cells, likewise, that lies at a height.
BodyId add_bar(Scene& scene, const char* name, int along, double height) {
  constexpr double kCell = 14e-3, kWidth = 10e-3, kCells = 3;
  std::array<Index, 3> cells{1, 1, 1};
  cells[along] = static_cast<Index>(kCells);
  const TetMesh unit = testing::make_box(cells, 1);
  std::vector<Vector3d> points(unit.positions().begin(), unit.positions().end());
  for (Vector3d& x : points) {
    x[along] = kCell * (x[along] - kCells / 2);
    x[1 - along] = kWidth * (x[1 - along] - 0.5);
    x.z() = height + kWidth * x.z();
  }
  const Material stiff{.model = ElasticModel::neo_hookean,
                       .youngs_modulus = 50e3F,
                       .poissons_ratio = 0.4F,
                       .damping = 0.02F};
  return scene.add_body(name, TetMesh(points, {unit.tets().begin(), unit.tets().end()}), stiff);
}

// A bar that stands fast, and another across it.
Scene crossing_bars(double distance) {
  Scene scene;
  scene.set_gravity({0, 0, -kFreeFall});
  scene.fix_where(add_bar(scene, "lower", 0, -10e-3), [](const Vector3d&) { return true; });
  add_bar(scene, "upper", 1, distance);
  return scene;
}

// A strip that stands fast, and another across it.
Scene crossing_strips(double distance, const Vector3f& gravity = {0, 0, -kFreeFall}) {
  Scene scene;
  scene.set_gravity(gravity);
  scene.fix_vertices(add_strip(scene, "lower", 0, 0), std::array{0, 1, 2, 3});
  add_strip(scene, "upper", 1, distance);
  return scene;
}

double weight_of_body(const Solver& solver, Index body) {
  double mass = 0;
  for (const Index v : solver.tissue().vertices_of(body)) {
    mass += solver.tissue().masses()[v];
  }
  return kFreeFall * mass;
}

struct EdgeSums {
  Vector3f force = Vector3f::Zero();                // N, on body 1
  float least = std::numeric_limits<float>::max();  // m
  int edges = 0, vertices = 0;                      // that push
};

EdgeSums edge_sums(const Solver& solver) {
  EdgeSums sums;
  for (const BodyContact& contact : solver.body_contacts()) {
    sums.force += contact.first == 1 ? contact.force : Vector3f(-contact.force);
    if (contact.force.norm() > 0) {
      sums.least = std::min(sums.least, contact.distance);
      (contact.first_count == 2 ? sums.edges : sums.vertices) += 1;
    }
  }
  return sums;
}

// Of the weight of a thread that lies or hangs. Vertex blocks stretch rigid links, and it jumps on
// them; by BDF2 contacts tell what they do before threads ease off.
double largest_error(SolverMethod method, TimeIntegration integration) {
  if (method == SolverMethod::projection) {
    return 0.02;
  }
  return integration == TimeIntegration::bdf2 ? 0.4 : 0.08;
}

struct MotionOfAll {
  Vector3d linear = Vector3d::Zero(), angular = Vector3d::Zero();
};

MotionOfAll motion_of_all(const Solver& solver) {
  const std::vector<Vector3f> x = solver.positions(), v = solver.velocities();
  MotionOfAll sum;
  for (Index i = 0; i < solver.vertex_count(); ++i) {
    const double m = solver.tissue().masses()[i];
    sum.linear += m * v[i].cast<double>();
    sum.angular += m * x[i].cast<double>().cross(v[i].cast<double>());
  }
  return sum;
}

}  // namespace

// Would catch edges that pass each other where no vertex is near, or bear another weight.
TEST_CASE("edge contact: a strip or a bar falls across another and rests there", "[validation]") {
  const SolverMethod method = any_sweeping_method();
  const TimeIntegration integration = any_integration();
  const bool is_strip = GENERATE(true, false);
  CAPTURE(static_cast<int>(method), static_cast<int>(integration), is_strip);
  Solver solver(is_strip ? crossing_strips(1.5e-3) : crossing_bars(1.5e-3),
                quick_options(method, integration));
  solver.set_body_contact(0, 1, kThinContact);

  float force = 0;
  constexpr int kSteps = 400, kMean = 100;
  for (int i = 0; i < kSteps; ++i) {
    REQUIRE(solver.step(kUsualStep).non_finite_vertices == 0);
    force += i < kSteps - kMean ? 0 : edge_sums(solver).force.z() / kMean;
  }

  const EdgeSums sums = edge_sums(solver);
  CAPTURE(sums.least, sums.edges, sums.vertices);
  CHECK(sums.edges >= 3);
  CHECK(sums.vertices == 0);
  CHECK(std::abs(force / weight_of_body(solver, 1) - 1) < 0.01);
  CHECK(sums.least > 0.95F * kThinContact.thickness);
  const std::vector<Vector3f> x = solver.positions();
  for (const Index v : solver.tissue().vertices_of(1)) {
    CHECK(x[v].z() > (is_strip ? 0 : -1e-3F));  // bars hang down
  }
}

// Would catch a thread that passes between the vertices of a block, whose links are longer than
// its edges, or one that is pushed out of it sideways.
TEST_CASE("edge contact: a thread lies across a block", "[validation]") {
  const SolverMethod method = any_sweeping_method();
  const TimeIntegration integration = any_integration();
  const double length = GENERATE(2e-3, 9e-3);  // m, of a link
  CAPTURE(static_cast<int>(method), static_cast<int>(integration), length);
  constexpr double kEdge = 3e-3, kSlanted = 0.4e-3;
  Scene scene;
  scene.set_gravity({0, 0, -kFreeFall});
  const BodyId block = scene.add_body("block", testing::make_box({2, 4, 2}, kEdge));
  std::vector<Index> all(static_cast<std::size_t>(scene.vertex_count()));
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i] = static_cast<Index>(i);
  }
  scene.fix_vertices(block, all);
  std::vector<Vector3d> points;
  const int half = static_cast<int>(std::lround(13.5e-3 / length - 0.5));
  for (int i = -half; i <= half + 1; ++i) {
    points.emplace_back(kEdge + length * (i - 0.5), 2 * kEdge + kSlanted, 2 * kEdge + 1.5e-3);
  }
  const BodyId thread = scene.add_particles("thread", points, kBead);
  const Index first = scene.body(thread).first_vertex;
  for (Index i = 0; i + 1 < static_cast<Index>(points.size()); ++i) {
    scene.add_link({first + i, first + i + 1, static_cast<float>(length), {}});
  }
  Solver solver(scene, quick_options(method, integration));
  solver.set_body_contact(0, 1, kThinContact);

  Vector3f force = Vector3f::Zero();
  constexpr int kSteps = 600, kMean = 200;
  for (int i = 0; i < kSteps; ++i) {
    REQUIRE(solver.step(kUsualStep).non_finite_vertices == 0);
    force += i < kSteps - kMean ? Vector3f::Zero() : Vector3f(edge_sums(solver).force / kMean);
  }

  const std::vector<Vector3f> x = solver.positions();
  const Vector3f middle =
      (x[first + half] + x[first + half + 1]) / 2;  // of the link above the block
  CAPTURE(force, weight_of_body(solver, 1), middle, edge_sums(solver).edges,
          edge_sums(solver).vertices);
  CHECK(std::abs(force.z() / weight_of_body(solver, 1) - 1) < largest_error(method, integration));
  CHECK(middle.z() > 2 * kEdge + 0.9F * kThinContact.thickness);
  CHECK(middle.z() < 2 * kEdge + 2 * kThinContact.thickness);
}

// Would catch links that pass through links: a ring of six hangs in another, which stands fast.
TEST_CASE("edge contact: a ring hangs in a ring", "[validation]") {
  const SolverMethod method = any_sweeping_method();
  const TimeIntegration integration = any_integration();
  CAPTURE(static_cast<int>(method), static_cast<int>(integration));
  Scene scene;
  scene.set_gravity({0, 0, -kFreeFall});
  constexpr int kCount = 6;
  constexpr double kRadius = 12e-3, kInside = 2e-3;
  const double reach = kRadius * std::cos(std::numbers::pi / kCount);  // of the middle of a link
  std::vector<Vector3d> upper, lower;
  for (int i = 0; i < kCount; ++i) {
    const double angle = 2 * std::numbers::pi * (i + 0.5) / kCount;
    const double across = kRadius * std::sin(angle), up = kRadius * std::cos(angle);
    upper.emplace_back(across, 0, up);
    lower.emplace_back(0, across, up - 2 * reach + kInside);
  }
  scene.fix_vertices(add_ring(scene, "upper", upper), std::array{0, 1, 2, 3, 4, 5});
  add_ring(scene, "lower", lower);
  Solver solver(scene, quick_options(method, integration));
  solver.set_body_contact(0, 1, kThinContact);

  Vector3f force = Vector3f::Zero();
  constexpr int kSteps = 1000, kMean = 400;
  for (int i = 0; i < kSteps; ++i) {
    REQUIRE(solver.step(kUsualStep).non_finite_vertices == 0);
    force += i < kSteps - kMean ? Vector3f::Zero() : Vector3f(edge_sums(solver).force / kMean);
  }

  const EdgeSums sums = edge_sums(solver);
  CAPTURE(force, weight_of_body(solver, 1), sums.least, sums.edges, sums.vertices);
  CHECK(std::abs(force.z() / weight_of_body(solver, 1) - 1) < largest_error(method, integration));
  for (const Vector3f& x : solver.positions()) {
    CHECK(x.norm() < 5 * kRadius);
  }
}

// Would catch a push that acts on one of two edges more than on the other, or beside their
// crossing.
TEST_CASE("edge contact: links that collide keep their momentum", "[validation]") {
  const SolverMethod method = any_sweeping_method();
  CAPTURE(static_cast<int>(method));
  Scene scene;
  scene.set_gravity(Vector3f::Zero());
  scene.add_particles("lower", std::vector<Vector3d>{{-6e-3, 0, 0}, {10e-3, 0, 0}}, kBead);
  scene.add_particles("upper", std::vector<Vector3d>{{0, -8e-3, 1e-3}, {1e-3, 9e-3, 1.2e-3}},
                      2 * kBead);
  scene.add_link({0, 1, 16e-3F, {}});
  scene.add_link({2, 3, static_cast<float>(Vector3d(1e-3, 17e-3, 0.2e-3).norm()), {}});
  Solver solver(scene, quick_options(method));
  solver.set_body_contact(0, 1, {kThinContact.thickness, 0});
  Snapshot moving = solver.snapshot();
  moving.velocities[2] = moving.velocities[3] = {0, 0, -0.05F};
  solver.restore(moving);
  const MotionOfAll before = motion_of_all(solver);

  int edges = 0, others = 0;  // near each other; a push of one substep is told by few steps
  for (int i = 0; i < 40; ++i) {
    solver.step(kUsualStep);
    for (const BodyContact& contact : solver.body_contacts()) {
      (contact.first_count == 2 ? edges : others) += 1;
    }
  }

  const MotionOfAll after = motion_of_all(solver);
  CAPTURE(before.linear.z(), (after.linear - before.linear).norm(), before.angular.norm(),
          (after.angular - before.angular).norm());
  CHECK(edges > 0);
  CHECK(others == 0);
  CHECK(solver.velocities()[2].z() > -0.04F);
  CHECK(solver.velocities()[0].z() < -0.01F);
  CHECK((after.linear - before.linear).norm() < 1e-4 * before.linear.norm());
  CHECK((after.angular - before.angular).norm() < 1e-3 * 2 * kBead * 0.05 * 20e-3);
}

// Would catch an order of edges, or of their sweeps, that hangs on threads.
TEST_CASE("edge contact: the same bits on any number of threads") {
  const SolverMethod method = any_sweeping_method();
  CAPTURE(static_cast<int>(method));
  const auto hash_of = [&](const Executor& executor) {
    SolverOptions options = quick_options(method, {}, executor);
    options.math = MathMode::strict;
    Solver solver(crossing_strips(0.6e-3), options);
    solver.set_body_contact(0, 1, kThinContact);
    for (int i = 0; i < 40; ++i) {
      solver.step(kUsualStep);
    }
    CHECK(edge_sums(solver).edges > 0);
    return solver.state_hash();
  };
  const std::uint64_t serial = hash_of(executor::serial());
  for (const int threads : {1, 2, 4}) {
    CHECK(hash_of(executor::threads(threads)) == serial);
  }
}

// Would catch a snapshot or a compaction that leaves out edges, or turns them around: a strip that
// was removed before gives all others new places.
TEST_CASE("edge contact: steps go on after a snapshot and a compaction as without them") {
  const SolverMethod method = any_sweeping_method();
  CAPTURE(static_cast<int>(method));
  Solver solver(crossing_strips(0.6e-3), quick_options(method));
  solver.set_body_contact(0, 1, kThinContact);
  const auto step = [](Solver& each, int count) {
    for (int i = 0; i < count; ++i) {
      each.step(kUsualStep);
    }
  };
  step(solver, 40);
  REQUIRE(edge_sums(solver).edges > 0);
  const Snapshot snapshot = solver.snapshot();
  CHECK(snapshot.body_contacts.size() == solver.body_contacts().size());
  step(solver, 30);
  const std::uint64_t hash = solver.state_hash();
  solver.restore(snapshot);
  step(solver, 30);
  CHECK(solver.state_hash() == hash);

  const float height = solver.positions()[4].z();
  Compaction compaction(solver);
  compaction.build();
  compaction.finish(solver);
  step(solver, 30);
  CHECK(edge_sums(solver).edges > 0);
  CHECK(std::abs(solver.positions()[4].z() - height) < 0.02e-3F);

  Snapshot twice = solver.snapshot();
  twice.body_contacts.push_back(twice.body_contacts[0]);
  auto& [first, second, end] = twice.body_contacts.back().edges;
  std::swap(second, end);
  CHECK_THROWS_WITH(solver.restore(twice), ContainsSubstring("two contacts of edge"));
  const auto refuses = [&](const auto& spoil, const char* why) {
    Snapshot bad = solver.snapshot();
    spoil(bad.body_contacts[0]);
    CHECK_THROWS_WITH(solver.restore(bad), ContainsSubstring(why));
  };
  refuses([](SnapshotBodyContact& contact) { contact.edges[2] = 8; }, "vertex 8");
  refuses([](SnapshotBodyContact& contact) { contact.edges[0] = kInvalidIndex; }, "vertex -1");
  refuses([](SnapshotBodyContact& contact) { contact.edges[1] = contact.vertex; }, "four ends");
  refuses([](SnapshotBodyContact& contact) { contact.body = 1; }, "body 1");
}

// Would catch an outside that hangs on ids where tetrahedra share an edge alone, as after a cut: a
// thread beside it would be pulled into the tissue, and thrown out on the other side.
TEST_CASE("edge contact: a thread beside an edge where tissue touches itself stays there") {
  const bool is_turned = GENERATE(false, true), is_swapped = GENERATE(false, true);
  const double side = GENERATE(1, -1);
  CAPTURE(is_turned, is_swapped, side);
  constexpr double kAlong = 5e-3, kOut = 5.2e-3, kUp = 3e-3, kAway = 0.7e-3;
  const double right = is_turned ? -kOut : kOut, up = is_swapped ? -kUp : kUp;
  const std::vector<Vector3d> corners{{0, -kAlong, 0}, {0, kAlong, 0},  {right, 0, up},
                                      {right, 0, -up}, {-right, 0, up}, {-right, 0, -up}};
  const auto oriented = [&](Tet tet) {
    const auto from = [&](int k) { return corners[tet[k]] - corners[tet[0]]; };
    if (from(1).cross(from(2)).dot(from(3)) < 0) {
      std::swap(tet[2], tet[3]);
    }
    return tet;
  };
  Scene scene;
  scene.set_gravity(Vector3f::Zero());
  scene.fix_where(
      scene.add_body("bow", TetMesh(corners, {oriented({0, 1, 2, 3}), oriented({0, 1, 4, 5})})),
      [](const Vector3d&) { return true; });
  const double height = side * kAway;
  const BodyId thread = scene.add_particles(
      "thread", std::vector<Vector3d>{{-0.8e-3, -4e-3, height}, {0.8e-3, 4e-3, height}}, kBead);
  const Index first = scene.body(thread).first_vertex;
  scene.add_link({first, first + 1, static_cast<float>(Vector3d(1.6e-3, 8e-3, 0).norm()), {}});
  Solver solver(scene);
  solver.set_body_contact(0, 1, kThinContact);
  for (int i = 0; i < 20; ++i) {
    solver.step(kUsualStep);
  }
  for (const Index end : {first, first + 1}) {
    CHECK(static_cast<double>(solver.positions()[end].z()) * side > 0.9 * kAway);
    CHECK(solver.velocities()[end].norm() < 0.05F);  // it was too near
  }
}

// Would catch a hook that passes between the particles of a thread: it takes a slack one up at the
// middle of a link.
TEST_CASE("edge contact: a hook lifts a thread", "[validation]") {
  const SolverMethod method = any_sweeping_method();
  const TimeIntegration integration = any_integration();
  CAPTURE(static_cast<int>(method), static_cast<int>(integration));
  constexpr double kHalf = 18e-3, kLink = 10e-3;  // m, between ends that are held, and of a link
  constexpr float kRadius = 0.5e-3F;
  const double depth = std::sqrt(4 * kLink * kLink - kHalf * kHalf);
  Scene scene;
  scene.set_gravity({0, -kFreeFall, 0});
  const BodyId thread = scene.add_particles("thread",
                                            std::vector<Vector3d>{{-kHalf, 0, 0},
                                                                  {-kHalf / 2, -depth / 2, 0},
                                                                  {0, -depth, 0},
                                                                  {kHalf / 2, -depth / 2, 0},
                                                                  {kHalf, 0, 0}},
                                            kBead);
  scene.fix_vertices(thread, std::array{0, 4});
  for (Index i = 0; i < 4; ++i) {
    scene.add_link({i, i + 1, static_cast<float>(kLink), {}});
  }
  Solver solver(scene, quick_options(method, integration));
  const auto x = static_cast<float>(kHalf / 4);
  const float from = static_cast<float>(-0.75 * depth) - 2 * kRadius;
  const Capsule hook{{x, from, -5e-3F}, {x, from, 5e-3F}, kRadius};
  const ToolId tool = solver.add_tool({&hook, 1}, ToolPose::Identity());
  solver.step(kUsualStep);
  CHECK(solver.tool_force(tool).norm() == 0);

  constexpr int kSteps = 240;
  constexpr float kRise = 8e-3F;
  ToolPose pose = ToolPose::Identity();
  float force = 0;
  for (int i = 1; i <= 2 * kSteps; ++i) {
    pose.translation().y() = kRise * std::min(1.0F, static_cast<float>(i) / kSteps);
    solver.move_tool(tool, pose);
    REQUIRE(solver.step(kUsualStep).non_finite_vertices == 0);
    force -= i < 2 * kSteps - 100 ? 0 : solver.tool_force(tool).y() / 101;
  }

  const std::vector<Vector3f> at = solver.positions();
  float above = 1;  // of the thread over the hook's axis
  for (Index i = 0; i < 4; ++i) {
    const Vector3f along = at[i + 1] - at[i];
    const Vector3f axis(x, from + kRise, at[i].z());
    const float share = std::clamp((axis - at[i]).dot(along) / along.squaredNorm(), 0.0F, 1.0F);
    above = std::min(above, (at[i] + share * along - axis).norm());
  }
  CAPTURE(force, above, at[2], at[3]);
  CHECK(force > 0.5F * kFreeFall * static_cast<float>(kBead));
  CHECK(above > 0.95F * kRadius);
  CHECK(std::max(at[2].y(), at[3].y()) > from + kRise - kRadius);
}

// Would catch what is sewn together pushing itself apart, and a thread that parts jumping.
TEST_CASE("edge contact: a thread meets no tissue that it is tied to") {
  const SolverMethod method = any_sweeping_method();
  CAPTURE(static_cast<int>(method));
  Scene scene;
  scene.set_gravity(Vector3f::Zero());
  const BodyId block = scene.add_body("block", testing::make_box({3, 3, 1}, 4e-3));
  scene.fix_where(block, [](const Vector3d& x) { return x.z() < 1e-9; });
  const auto nearest = [&](const Vector3d& x) {
    Index best = 0;
    for (Index v = 0; v < scene.body(block).vertex_count; ++v) {
      best = (scene.positions()[v] - x).norm() < (scene.positions()[best] - x).norm() ? v : best;
    }
    return best;
  };
  const Vector3d at(4e-3, 4e-3, 4e-3);
  const Index stitched = nearest(at);
  const BodyId thread = scene.add_particles(
      "thread", std::vector<Vector3d>{at + Vector3d(0, 0, 0.1e-3), at + Vector3d(0, 1e-3, 0.1e-3)},
      kBead);
  const Index first = scene.body(thread).first_vertex;
  scene.add_link({first, first + 1, 1e-3F, {}});
  const Index stitch = scene.add_link({stitched, first, 0.1e-3F, {}});
  Solver solver(scene, quick_options(method));
  solver.set_body_contact(0, 1, kThinContact);
  for (int i = 0; i < 20; ++i) {
    solver.step(kUsualStep);
  }
  CHECK(solver.body_contacts().empty());

  solver.tissue().apply({.remove_links = {stitch}});
  float fastest = 0;
  for (int i = 0; i < 40; ++i) {
    solver.step(kUsualStep);
    for (const Vector3f& v : solver.velocities()) {
      fastest = std::max(fastest, v.norm());
    }
  }
  CHECK(fastest < 0.1F);
  CHECK(edge_sums(solver).least > 0.9F * kThinContact.thickness);
  CHECK(solver.positions()[first].z() > 4e-3F + 0.9F * kThinContact.thickness);
}

}  // namespace pbdsurg
