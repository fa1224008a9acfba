// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/contact/contact_probe.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/contact/proximity.h"
#include "pbdsurg/haptics/servo.h"
#include "pbdsurg/tissue/library.h"

#include "tests/haptics/rig.h"
#include "tests/support/catch.h"
#include "tests/support/meshes.h"
#include "tests/support/solver_cases.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;
using testing::kUsualStep;

constexpr float kRadius = 4e-3F;  // m, of a probe's ball
constexpr float kTop = 0.021F;    // m, of the block

ToolPose at(float height) {
  ToolPose pose = ToolPose::Identity();
  pose.translation() = Eigen::Vector3f(0.0151F, height, 0.0149F);
  return pose;
}

// A block of liver of 3 x 2 x 3 cm, fixed below, and a ball above it, whose center is its origin.
class Press {
 public:
  explicit Press(const std::vector<Capsule>& capsules)
      : solver_(block()),
        tool_(solver_.add_tool(capsules, at(kTop + 0.02F))),
        probe_(solver_, std::vector<Index>{0}, std::vector<ToolPoint>{{{0, 0, 0}, kRadius}}) {}

  // Goes to a height above the top, the ball's lowest point's, and rests there.
  ContactPacket packet_at(float height, GraspState grasp = GraspState::open) {
    const float from = solver_.tool_pose(tool_).translation().y(), to = kTop + kRadius + height;
    constexpr int kMoving = 40, kSteps = 120;
    for (int i = 1; i <= kSteps; ++i) {
      const float share = std::min(1.0F, static_cast<float>(i) / kMoving);
      solver_.move_tool(tool_, at(from + share * (to - from)));
      solver_.step(kUsualStep);
    }
    return make_contact_packet(probe_, solver_, tool_, grasp, 1, 0.5);
  }

  Solver& solver() { return solver_; }
  [[nodiscard]] ToolId tool() const { return tool_; }
  ContactProbe& probe() { return probe_; }

 private:
  static Scene block() {
    Scene scene;
    const BodyId liver =
        scene.add_body("liver", testing::make_box({10, 7, 10}, 3e-3), tissues::liver().mechanics);
    scene.fix_where(liver, [](const Eigen::Vector3d& x) { return x.y() < 1e-6; });
    scene.set_gravity({0, 0, 0});
    return scene;
  }

  Solver solver_;
  ToolId tool_;
  ContactProbe probe_;
};

// Removes the tetrahedra with a corner at rest in a column of 5 mm below a point, a layer at a
// time.
Index burn_near(Solver& solver, const Eigen::Vector3f& point) {
  const Tissue& tissue = solver.tissue();
  const std::span<const Eigen::Vector3d> rest = tissue.rest_positions();
  const auto height = [&](Index tet) {
    double top = 0;
    for (const Index corner : tissue.tets()[static_cast<std::size_t>(tet)]) {
      top = std::max(top, rest[static_cast<std::size_t>(corner)].y());
    }
    return top;
  };
  const auto is_near = [&](Index tet) {
    const auto& corners = tissue.tets()[static_cast<std::size_t>(tet)];
    return std::any_of(corners.begin(), corners.end(), [&](Index corner) {
      const Eigen::Vector3d to = rest[static_cast<std::size_t>(corner)] - point.cast<double>();
      return std::hypot(to.x(), to.z()) < 5e-3;
    });
  };
  std::vector<Index> column;
  double top = 0;
  for (Index tet : tissue.tets_of(0)) {
    if (tissue.is_tet_alive(tet) && is_near(tet)) {
      column.push_back(tet);
      top = std::max(top, height(tet));
    }
  }
  std::erase_if(column, [&](Index tet) { return height(tet) < top - 1e-4; });
  solver.tissue().apply({.remove_tets = column});
  return static_cast<Index>(column.size());
}

// N, at the packet's pose and by how much farther up
Eigen::Vector3f felt(const ContactPacket& packet, float higher = 0) {
  ToolPose pose = pose_of(packet);
  pose.translation().y() += higher;
  return plane_force(packet, pose) + (packet.grasp.state == GraspState::held
                                          ? grasp_force(packet.grasp, pose)
                                          : Eigen::Vector3f::Zero());
}

}  // namespace

TEST_CASE("contact probe: stiffness is that of a punch", "[unit]") {
  CHECK(tip_stiffness(2e-3F, 5000, 0) == Approx(20));
  CHECK_THROWS_AS(tip_stiffness(0, 5000, 0.4F), InvalidArgument);
  CHECK_THROWS_AS(tip_stiffness(1e-3F, 5000, 0.5F), InvalidArgument);
}

TEST_CASE("contact probe: tissue is told before touch, and pushes as in the simulation", "[unit]") {
  Press press({{{0, 0, 0}, {0, 0, 0}, kRadius}});
  CHECK(press.packet_at(6e-3F).plane_count == 0);

  const ContactPacket near = press.packet_at(2e-3F);
  REQUIRE(near.plane_count == 1);
  CHECK(is_valid(near));
  CHECK(felt(near).norm() == 0);
  CHECK(felt(near, -1.9e-3F).norm() == 0);
  const Material& liver = tissues::liver().mechanics;
  CHECK(felt(near, -3e-3F).y() ==
        Approx(1e-3F * tip_stiffness(kRadius, liver.youngs_modulus, liver.poissons_ratio))
            .epsilon(0.05));

  const ContactPacket shallow = press.packet_at(-2e-3F), deep = press.packet_at(-4e-3F);
  for (const ContactPacket& packet : {shallow, deep}) {
    CHECK(is_valid(packet));
    CHECK(packet.force[1] > 0.02F);
    CHECK((felt(packet) - vector_of(packet.force)).norm() < 2e-3F);
  }
  CHECK(deep.force == packet_vector(press.solver().tool_force(press.tool())));
  const float secant = (deep.force[1] - shallow.force[1]) / 2e-3F;  // N/m
  // 63.7 and 52.2 N/m: the tool on a coarse mesh, and a punch
  CHECK(secant ==
        Approx(tip_stiffness(kRadius, liver.youngs_modulus, liver.poissons_ratio)).epsilon(0.25));
  CHECK(secant < kLeastStiffness);
}

// Would catch planes where a spring has let the tool be: a hand, which is deeper, would feel too
// much, or nothing once it is out of their reach.
TEST_CASE("contact probe: a hand feels at its place what a tool on a spring feels", "[unit]") {
  Press press({{{0, 0, 0}, {0, 0, 0}, kRadius}});
  Solver& solver = press.solver();
  solver.couple_tool(press.tool(), {.stiffness = 50});
  const ContactPacket packet = press.packet_at(-6e-3F);
  const ToolPose hand = solver.tool_target(press.tool());
  CHECK(solver.tool_displacement(press.tool()).y() > 2e-3F);
  REQUIRE(packet.plane_count > 0);
  CHECK((pose_of(packet).translation() - hand.translation()).norm() < 1e-7F);
  CHECK((plane_force(packet, hand) - solver.tool_force(press.tool())).norm() < 2e-3F);
}

TEST_CASE("contact probe: what is held pulls as in the simulation", "[unit]") {
  Press press({});
  press.packet_at(0.5e-3F);
  const std::vector<Index> held = find_vertices_near(
      press.solver(), 0, press.solver().tool_pose(press.tool()).translation(), 5.5e-3F);
  REQUIRE_FALSE(held.empty());
  press.solver().grasp(press.tool(), held);
  const ContactPacket packet = press.packet_at(4e-3F, GraspState::held);
  CHECK(is_valid(packet));
  CHECK(packet.force[1] < -0.02F);
  CHECK((felt(packet) - vector_of(packet.force)).norm() < 2e-3F);
  press.solver().release(press.tool());
  CHECK(felt(press.packet_at(4e-3F, GraspState::torn)).norm() < 2e-3F);
}

TEST_CASE("contact probe: follows tissue that is burnt or cut away", "[unit]") {
  Press press({});
  CHECK(press.packet_at(1e-3F).plane_count == 1);
  std::vector<Index> tets = press.solver().tissue().tets_of(0);
  press.solver().tissue().apply({.remove_tets = tets});
  CHECK(press.packet_at(1e-3F).plane_count == 0);
}

// The whole loop: a hand, the servo, the solver at 100 Hz, and an edit every tenth of a second.
TEST_CASE("contact probe: force is steady while tissue goes under the tool", "[unit]") {
  Press press({{{0, 0, 0}, {0, 0, 0}, kRadius}});
  Solver& solver = press.solver();
  bool burns = false;
  Index removed = 0;
  int packets = 0;
  const Eigen::Vector3d above = at(kTop + kRadius + 1e-3F).translation().cast<double>();
  testing::Rig rig({.has_hand = true, .position = above}, [&](ContactPacket& packet, double time) {
    solver.move_tool(press.tool(), pose_of(packet));
    if (burns && ++packets % 10 == 0) {
      removed += burn_near(solver, pose_of(packet).translation());
    }
    REQUIRE(solver.step(0.01F).non_finite_vertices == 0);
    packet = make_contact_packet(press.probe(), solver, press.tool(), GraspState::open,
                                 packet.sequence, time);
  });
  rig.delay = 10;
  rig.target = above;
  rig.run(1.3);
  rig.target.y() -= 6e-3;
  rig.run(0.7);
  CHECK(rig.computed.back().y() > 0.1F);
  burns = true;
  rig.run(1);
  CHECK(removed > 50);
  const testing::Steps computed = testing::steps_of(rig.computed);
  CHECK(computed.p999 <= 0.1);
  CHECK(computed.largest <= 0.2);
  CHECK(testing::steps_of(rig.commanded).largest <= 0.2001);
  CHECK(rig.computed.back().y() < 0.1F);  // most of what it pressed is gone
}

// Beyond an acute edge one of its two triangles faces away: by that one alone, a tool there would
// be deep in the tissue. A tetrahedron has acute edges alone.
TEST_CASE("contact probe: a sharp edge is not felt from afar", "[unit]") {
  constexpr double kEdge = 10e-3;  // m
  Scene scene;
  scene.add_body("splinter",
                 TetMesh({{0, 0, 0}, {kEdge, 0, 0}, {0, kEdge, 0}, {0, 0, kEdge}}, {{0, 1, 2, 3}}),
                 tissues::liver().mechanics);
  Solver solver(scene);
  const ToolId tool = solver.add_tool({}, at(0));
  ContactProbe probe(solver, std::vector<Index>{0}, std::vector<ToolPoint>{{{0, 0, 0}, kRadius}});
  constexpr int kDirections = 500;
  for (int i = 0; i < kDirections; ++i) {
    Eigen::Vector3f direction;
    for (int axis = 0; axis < 3; ++axis) {
      direction[axis] = static_cast<float>(2 * random_unit(3, i, axis) - 1);
    }
    ToolPose pose = ToolPose::Identity();
    pose.translation() = Eigen::Vector3f::Constant(2e-3F) + 0.04F * direction.normalized();
    solver.move_tool(tool, pose);
    solver.step(1e-6F);
    CAPTURE(direction.transpose());
    CHECK(make_contact_packet(probe, solver, tool, GraspState::open, 1, 0).plane_count == 0);
  }
}

TEST_CASE("contact probe: refuses what it cannot watch", "[unit]") {
  Press press({});
  const std::vector<Index> bodies{0}, none{1};
  const std::vector<ToolPoint> fine{{{0, 0, 0}, kRadius}}, flat{{{0, 0, 0}, 0}}, many(9, fine[0]);
  CHECK_THROWS_AS(ContactProbe(press.solver(), none, fine), InvalidArgument);
  CHECK_THROWS_AS(ContactProbe(press.solver(), bodies, flat), InvalidArgument);
  CHECK_THROWS_AS(ContactProbe(press.solver(), bodies, many), InvalidArgument);

  Solver& solver = press.solver();
  ContactProbe& probe = press.probe();
  const ToolId tool = press.tool();
  ContactPatch patch;
  const auto collect = [&](ToolId which, std::uint64_t sequence, double time) {
    probe.collect_patch(solver, which, GraspState::open, sequence, time, patch);
  };
  CHECK_NOTHROW(collect(tool, 1, 0));
  CHECK_THROWS_AS(collect(ToolId(7), 1, 0), InvalidArgument);
  CHECK_THROWS_AS(collect(tool, 0, 0), InvalidArgument);
  CHECK_THROWS_AS(collect(tool, 1, std::nan("")), InvalidArgument);
  Press other({});
  CHECK_THROWS_AS(probe.collect_patch(other.solver(), other.tool(), GraspState::open, 1, 0, patch),
                  InvalidArgument);

  const std::vector<Eigen::Vector3f> positions(3, Eigen::Vector3f::Zero());
  const auto collect_from = [&](const std::vector<Triangle>& triangles, std::size_t count) {
    const std::vector<TouchedSurface> surfaces(count, {triangles, positions});
    probe.collect_patch(surfaces, solver, tool, GraspState::open, 1, 0, patch);
  };
  CHECK_NOTHROW(collect_from({{0, 1, 2}, {0, 0, 0}}, 1));
  CHECK_THROWS_WITH(collect_from({{0, 1, 2}, {0, 1, 3}}, 1), ContainsSubstring("triangle 1"));
  CHECK_THROWS_AS(collect_from({{-1, 1, 2}}, 1), InvalidArgument);
  CHECK_THROWS_AS(collect_from({}, 0), InvalidArgument);
  CHECK_THROWS_AS(collect_from({}, 2), InvalidArgument);
}

}  // namespace pbdsurg
