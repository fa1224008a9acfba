// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/contact/contact_patch.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "pbdsurg/base/mailbox.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/contact/contact_probe.h"
#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/tissue/library.h"
#include "pbdsurg/views/live_surface.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"
#include "tests/support/solver_cases.h"

namespace pbdsurg {
namespace {

using testing::kUsualStep;

constexpr double kSampleEdge = 3e-3;                 // m
const Eigen::Vector3f kMiddle(0.02F, 0.02F, 0.02F);  // m, of the first block

float random_in(std::uint64_t seed, int index, int axis, float low, float high) {
  return low + (high - low) * static_cast<float>(random_unit(seed, index, axis));
}

Eigen::Vector3f random_vector(std::uint64_t seed, int index, float size) {
  return {random_in(seed, index, 0, -size, size), random_in(seed, index, 1, -size, size),
          random_in(seed, index, 2, -size, size)};
}

ToolPose pose_at(const Eigen::Vector3f& tip, const Eigen::Vector3f& turn) {
  ToolPose pose = ToolPose::Identity();
  pose.translation() = tip;
  pose.linear() = Eigen::AngleAxisf(turn.norm(), turn.normalized()).toRotationMatrix();
  return pose;
}

// Eight balls along a jaw, of which one has a radius of its own.
std::vector<ToolPoint> jaw() {
  std::vector<ToolPoint> points;
  for (int i = 0; i < 8; ++i) {
    points.push_back({{3e-3F * static_cast<float>(i), 0, 0}, i == 3 ? 4e-3F : 2e-3F});
  }
  return points;
}

// Two blocks, of solid tissue and of springs, fixed below, that a ball has dented and from which
// random tetrahedra have gone above: jagged surfaces, holes and islands. Strict, to be the same
// ruin everywhere: in some the surface touches itself so that its nearest point does not tell the
// side.
class Ruin {
 public:
  Ruin() : solver_(blocks(), {.math = MathMode::strict}) {
    for (Index body = 0; body < 2; ++body) {
      surfaces_.push_back(shared_surface(solver_.tissue(), body));
    }
    presser_ =
        solver_.add_tool(std::vector<Capsule>{{{0, 0, 0}, {0, 0, 0}, 8e-3F}}, at_top(20e-3F));
    for (int i = 0; i < 40; ++i) {
      step(at_top(12e-3F - 0.15e-3F * static_cast<float>(i)));
    }
    std::vector<Index> tets;
    for (Index tet = 0; tet < static_cast<Index>(solver_.tissue().tets().size()); ++tet) {
      const Index corner = solver_.tissue().tets()[static_cast<std::size_t>(tet)][0];
      const double height = solver_.tissue().rest_positions()[static_cast<std::size_t>(corner)].z();
      if (height > 30e-3 && random_unit(7, tet, 0) < 0.1) {
        tets.push_back(tet);
      }
    }
    solver_.tissue().apply({.remove_tets = tets});
    step(at_top(6e-3F));
  }

  Solver& solver() { return solver_; }
  void remove_some(std::uint64_t seed, double share) {
    const Tissue& tissue = solver_.tissue();
    std::vector<Index> tets;
    for (Index tet = 0; tet < static_cast<Index>(tissue.tets().size()); ++tet) {
      const Index corner = tissue.tets()[static_cast<std::size_t>(tet)][0];
      const double height = tissue.rest_positions()[static_cast<std::size_t>(corner)].z();
      if (height > 30e-3 && tissue.is_tet_alive(tet) && random_unit(seed, tet, 0) < share) {
        tets.push_back(tet);
      }
    }
    solver_.tissue().apply({.remove_tets = tets});
  }
  [[nodiscard]] const std::vector<std::shared_ptr<const LiveSurface>>& surfaces() const {
    return surfaces_;
  }
  void step(const ToolPose& presser) {
    solver_.move_tool(presser_, presser);
    REQUIRE(solver_.step(kUsualStep).non_finite_vertices == 0);
  }
  static ToolPose at_top(float height) {
    return pose_at(kMiddle + Eigen::Vector3f(0, 0, 0.02F + height), {0, 0, 1e-3F});
  }

 private:
  static Scene blocks() {
    const TetMesh block = testing::make_box({13, 13, 13}, kSampleEdge, 0.1);
    std::vector<Eigen::Vector3d> beside(block.positions().begin(), block.positions().end());
    for (Eigen::Vector3d& x : beside) {
      x.x() += 0.045;
    }
    const TetMesh other(beside, {block.tets().begin(), block.tets().end()});
    Scene scene;
    scene.add_body("liver", block, tissues::liver().mechanics);
    scene.add_body("sponge", other, springs(other, tissues::liver().mechanics));
    scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.z() < kSampleEdge / 2; });
    scene.fix_where(1, [](const Eigen::Vector3d& x) { return x.z() < kSampleEdge / 2; });
    return scene;
  }
  Solver solver_;
  std::vector<std::shared_ptr<const LiveSurface>> surfaces_;
  ToolId presser_;
};

// All triangles, of a size with which none is left out, however far.
void take_all(Ruin& ruin, ContactPatch& patch) {
  for (PatchPoint& point : patch.points) {
    point.reach = std::numeric_limits<float>::infinity();
  }
  const std::vector<Eigen::Vector3f> positions = ruin.solver().positions();
  patch.triangles.clear();
  for (const std::shared_ptr<const LiveSurface>& surface : ruin.surfaces()) {
    const Material& material = ruin.solver().tissue().body(surface->body()).material;
    const bool is_solid = material.model == ElasticModel::neo_hookean;
    for (const Triangle& triangle : surface->triangles()) {
      if (triangle != LiveSurface::kEmptyTriangle) {
        patch.triangles.push_back(
            {{positions[triangle[0]], positions[triangle[1]], positions[triangle[2]]},
             1e3F,
             is_solid ? material.youngs_modulus : 0,
             material.poissons_ratio});
      }
    }
  }
}

bool is_same(const ContactPacket& a, const ContactPacket& b) {
  bool same = a.sequence == b.sequence && a.time == b.time && a.position == b.position &&
              a.rotation == b.rotation && a.force == b.force && a.torque == b.torque &&
              a.plane_count == b.plane_count && a.grasp.state == b.grasp.state;
  for (std::uint32_t i = 0; i < a.plane_count && same; ++i) {
    const ContactPlane &p = a.planes[i], &q = b.planes[i];
    same = p.point == q.point && p.normal == q.normal && p.offset == q.offset &&
           p.stiffness == q.stiffness;
  }
  return same;
}

// How many poses are of which kind, so that no kind is missing.
struct Kinds {
  int without = 0, some = 0, all = 0, deep = 0;

  void count(const ContactPatch& patch, const ContactPacket& packet) {
    const std::uint32_t planes = packet.plane_count;
    (planes == 0 ? without : planes < patch.points.size() ? some : all) += 1;
    deep += std::ranges::any_of(patch.points,
                                [](const PatchPoint& point) {
                                  return point.reach > point.ball.radius + ContactPatch::kReach +
                                                           ContactPatch::kMargin;
                                })
                ? 1
                : 0;
  }
};

}  // namespace

// Would catch a margin that is too small, an order of triangles that is another, a deep point whose
// nearest triangle is left out, positions that are old, ids and edits that are followed late, and
// triangles that are looked at too late, or forgotten, where the tool wanders for long.
TEST_CASE("contact patch: a packet has the bits of a search through all triangles",
          "[validation]") {
  constexpr int kPoses = 400;
  const int stay = GENERATE(4, 25);
  Ruin ruin;
  Solver& solver = ruin.solver();
  const std::vector<Index> bodies{0, 1};
  const std::vector<ToolPoint> points = jaw();
  ContactProbe reading(solver, bodies, points), given(solver, bodies, points);
  const ToolId tool = solver.add_tool({}, ToolPose::Identity());
  ContactPatch read, of_surfaces, all;
  Kinds kinds;
  int looked_elsewhere = 0, without_plane = 0;
  double kept = 0;
  ToolPose pose = ToolPose::Identity();
  for (int i = 0; i < kPoses; ++i) {
    if (i % stay == 0) {  // elsewhere; in between it moves a little
      pose = pose_at(kMiddle + Eigen::Vector3f(0.02F, 0, 0) + random_vector(1, i, 0.03F),
                     random_vector(2, i, 3));
    } else {
      pose.translation() += random_vector(3, i, 0.5e-3F);
    }
    solver.move_tool(tool, pose);
    ruin.step(Ruin::at_top(6e-3F + 0.5e-3F * std::sin(0.1F * static_cast<float>(i))));
    if (i % 7 == 3) {
      ruin.remove_some(10 + i, 0.03);
    } else if (i % 14 == 5 || i == 105) {
      solver.tissue().undo();
    } else if (i == 104) {
      Scene more;
      more.add_body("more", testing::make_box({1, 1, 1}, kSampleEdge));
      solver.tissue().apply({.new_bodies = more});
    } else if (i == 202) {
      Compaction compaction(solver);
      compaction.build();
      static_cast<void>(compaction.finish(solver));
    }
    const double time = 1e-3 * i;
    const auto sequence = static_cast<std::uint64_t>(i) + 1;
    reading.collect_patch(solver, tool, GraspState::open, sequence, time, read);
    const std::vector<Eigen::Vector3f> positions = solver.positions();
    const std::vector<TouchedSurface> surfaces{{ruin.surfaces()[0]->triangles(), positions},
                                               {ruin.surfaces()[1]->triangles(), positions}};
    given.collect_patch(surfaces, solver, tool, GraspState::open, sequence, time, of_surfaces);
    all = read;
    take_all(ruin, all);
    kept += static_cast<double>(read.triangles.size()) / static_cast<double>(all.triangles.size());

    const ContactPacket expected = make_contact_packet(all);
    kinds.count(read, expected);
    CAPTURE(i);
    CHECK(is_same(make_contact_packet(read), expected));
    CHECK(is_same(make_contact_packet(of_surfaces), expected));
    // at poses that the tool may have reached by now
    for (int k = 0; k < 3; ++k) {
      ToolPose where = pose;
      where.translation() +=
          0.99F * ContactPatch::kMargin * random_vector(4 + k, i, 1).normalized();
      const ContactPacket there = make_contact_packet(all, where);
      looked_elsewhere += is_same(there, expected) ? 0 : 1;
      const ContactPacket of_read = make_contact_packet(read, where);
      CHECK(is_same(make_contact_packet(of_surfaces, where), of_read));
      // Beside one body, a move may take a point deep into another that overlaps it: what is near
      // there is not in the patch, so that point has no plane before the next.
      if (of_read.plane_count < there.plane_count) {
        ++without_plane;
      } else {
        CHECK(is_same(of_read, there));
      }
    }
  }
  CAPTURE(kinds.without, kinds.some, kinds.all, kinds.deep, looked_elsewhere, kept / kPoses);
  CHECK(kinds.without > kPoses / 20);
  CHECK(kinds.some > kPoses / 10);
  CHECK(kinds.all > kPoses / 10);
  CHECK(kinds.deep > kPoses / 40);
  CHECK(looked_elsewhere > kPoses);
  CHECK(without_plane <= 3);
  CHECK(kept / kPoses < 0.1);
}

// A ball on one block, another in the gap to the next, which is farther from all that is near the
// first than it can feel. Would catch that one taken for deep in tissue, as the edge of what is
// near may face away.
TEST_CASE("contact patch: what is near one point tells nothing of another", "[unit]") {
  constexpr float kWide = 30e-3F;
  const TetMesh block = testing::make_box({10, 10, 10}, kSampleEdge);
  std::vector<Eigen::Vector3d> beside(block.positions().begin(), block.positions().end());
  for (Eigen::Vector3d& x : beside) {
    x.x() += 4.0 * double{kWide};
  }
  Scene scene;
  scene.add_body("one", block);
  scene.add_body("next", TetMesh(beside, {block.tets().begin(), block.tets().end()}));
  Solver solver(scene);
  const ToolId tool = solver.add_tool({}, pose_at({4e-3F, 15e-3F, kWide + 3e-3F}, {0, 0, 1e-3F}));
  const std::vector<ToolPoint> points{{{0, 0, 0}, 4e-3F}, {{71e-3F, 0, -15e-3F}, 4e-3F}};
  ContactProbe probe(solver, std::vector<Index>{0, 1}, points);
  for (std::uint64_t step = 1; step < 4; ++step) {  // all, then what is near
    const ContactPacket packet = make_contact_packet(probe, solver, tool, GraspState::open, step,
                                                     1e-3 * static_cast<double>(step));
    CAPTURE(step);
    REQUIRE(packet.plane_count == 1);
    CHECK(packet.planes[0].normal[2] > 0.99F);
  }
}

// Would catch a patch that looks at the solver later, and a packet that depends on when it is made.
TEST_CASE("contact patch: another thread makes the packets of the simulation's", "[unit]") {
  constexpr std::uint64_t kSteps = 100;
  Ruin ruin;
  Solver& solver = ruin.solver();
  ContactProbe probe(solver, std::vector<Index>{0, 1}, jaw());
  const ToolId tool = solver.add_tool({}, Ruin::at_top(6e-3F));
  Mailbox<ContactPatch> patches;
  std::vector<ContactPacket> expected, made;
  std::atomic<bool> is_over{false};
  std::thread contact([&] {
    while (true) {
      const bool is_last = is_over;
      if (patches.take() > 0) {
        made.push_back(make_contact_packet(patches.value()));
      } else if (is_last) {
        return;
      }
    }
  });
  for (std::uint64_t step = 1; step <= kSteps; ++step) {
    solver.move_tool(tool, Ruin::at_top(6e-3F - 20e-6F * static_cast<float>(step)));
    ruin.step(Ruin::at_top(6e-3F));
    const double time = double{kUsualStep} * static_cast<double>(step);
    probe.collect_patch(solver, tool, GraspState::open, step, time, patches.draft());
    patches.publish();
    expected.push_back(make_contact_packet(probe, solver, tool, GraspState::open, step, time));
  }
  is_over = true;
  contact.join();
  REQUIRE_FALSE(made.empty());
  CHECK(made.back().sequence == kSteps);
  for (const ContactPacket& packet : made) {
    CHECK(packet.plane_count > 0);
    CHECK(is_same(packet, expected.at(packet.sequence - 1)));
  }
}

// A roof, whose ridge the tool has crossed since the step; farther away, or nowhere, the step
// counts.
TEST_CASE("contact patch: planes are those where the tool is by now, with the step's force",
          "[unit]") {
  constexpr float kHalf = 0.02F, kRadius = 2e-3F;
  const Eigen::Vector3f ridge(0, 0, 0), left(-kHalf, 0, -kHalf), right(kHalf, 0, -kHalf);
  const Eigen::Vector3f along(0, kHalf, 0);
  ContactPatch patch;
  patch.sequence = 1;
  patch.pose.translation() = Eigen::Vector3f(-0.9e-3F, 0, 0);
  patch.force = {-0.03F, 0, 0.03F};
  patch.points = {{{{0, 0, 0}, kRadius}, 10e-3F}};
  for (const auto& [eave, side] : {std::pair(left, -1.0F), std::pair(right, 1.0F)}) {
    const Eigen::Vector3f before = ridge + side * along, behind = ridge - side * along;
    patch.triangles.push_back({{before, behind, eave}, 3 * kHalf, 5000, 0.45F});
  }
  const auto normal_at = [&](float x) {
    ToolPose where = patch.pose;
    where.translation().x() = x;
    const ContactPacket packet = make_contact_packet(patch, where);
    REQUIRE(packet.plane_count > 0);
    CHECK(is_valid(packet));
    CHECK(pose_of(packet).isApprox(patch.pose));
    CHECK((plane_force(packet, patch.pose) - patch.force).norm() < 1e-4F);
    return vector_of(packet.planes[0].normal);
  };
  CHECK(normal_at(-0.9e-3F).x() < 0);
  CHECK(normal_at(0.9e-3F).x() > 0);
  CHECK(normal_at(-0.9e-3F + 1.1F * ContactPatch::kMargin).x() < 0);
  CHECK(normal_at(std::numeric_limits<float>::quiet_NaN()).x() < 0);
}

TEST_CASE("contact patch: refuses more points than a packet has planes", "[unit]") {
  ContactPatch patch;
  patch.points.resize(9, {{{0, 0, 0}, 1e-3F}, 1e-3F});
  CHECK_THROWS_AS(make_contact_packet(patch), InvalidArgument);
}

}  // namespace pbdsurg
