// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/contact/contact_probe.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "lib/base/check.h"
#include "lib/contact/near_triangles.h"
#include "lib/contact/triangle_cull.h"

namespace pbdsurg {
namespace {

constexpr float kAll = std::numeric_limits<float>::infinity();  // m: surfaces are whole

// Whether jaws lost in the last step what they held. The force of that step was theirs: of jaws
// that are open it would push.
bool has_lost_grip(const Solver& solver, ToolId tool) {
  const std::vector<ToolId> lost = solver.lost_grips();
  return std::ranges::find(lost, tool) != lost.end();
}

}  // namespace

struct ContactProbe::Data {
  static constexpr const char* kWho = "a contact probe";

  explicit Data(const Tissue& tissue, std::span<const Index> bodies)
      : near(tissue, bodies, kFastestTissue) {}

  NearTriangles near;
  std::vector<ToolPoint> points;
  ContactPatch patch;                     // of make_contact_packet()
  Eigen::Vector3f displacement{0, 0, 0};  // m, of the tool, if a spring holds it

  // scratch
  std::vector<ToolPoint> balls;
  std::vector<float> whole;  // [point] m, see TriangleCull::find()
  std::vector<CulledSurface> culled;
  TriangleCull cull;

  void begin(const Solver& solver, ToolId tool, GraspState grasp, std::uint64_t sequence,
             double time, ContactPatch& into);
  void end(ContactPatch& into);
};

// Refuses what is wrong, and says what is not triangles.
void ContactProbe::Data::begin(const Solver& solver, ToolId tool, GraspState grasp,
                               std::uint64_t sequence, double time, ContactPatch& into) {
  if (sequence == 0) {
    throw InvalidArgument("the sequence of a contact patch is 0; it must be positive");
  }
  check(std::isfinite(time), "the time of a contact patch", time, "finite");
  near.check_tissue(solver.tissue());
  displacement = solver.tool_displacement(tool);
  into.pose = solver.tool_pose(tool);
  into.force = solver.tool_force(tool);
  into.sequence = sequence;
  into.time = time;
  into.grasp = grasp;
  if (grasp != GraspState::held && has_lost_grip(solver, tool)) {
    into.force.setZero();
  }
  into.slip_limit = solver.slip_limit(tool);
  balls.assign(points.begin(), points.end());
  for (ToolPoint& ball : balls) {
    ball.center = into.pose * ball.center;
  }
  culled.clear();
}

// Takes of the triangles found what matters.
void ContactProbe::Data::end(ContactPatch& into) {
  cull.tighten(ContactPatch::kMargin);
  into.points.clear();
  for (std::size_t i = 0; i < points.size(); ++i) {
    into.points.push_back({points[i], cull.reaches()[i]});
  }
  into.triangles.assign(cull.triangles().begin(), cull.triangles().end());
  // a hand is where the tool is to be, and feels there what the tool feels
  into.pose.pretranslate(-displacement);
  for (PatchTriangle& triangle : into.triangles) {
    for (Eigen::Vector3f& corner : triangle.corners) {
      corner -= displacement;
    }
  }
}

ContactProbe::ContactProbe(const Solver& solver, std::span<const Index> bodies,
                           std::span<const ToolPoint> points)
    : data_(std::make_unique<Data>(solver.tissue(), bodies)) {
  if (points.size() > ContactPacket::kLargestPlaneCount) {
    throw InvalidArgument("a contact probe has " + std::to_string(points.size()) +
                          " points; a packet has planes for " +
                          std::to_string(ContactPacket::kLargestPlaneCount));
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].center.allFinite() || !(points[i].radius > 0) ||
        !std::isfinite(points[i].radius)) {
      throw InvalidArgument("point " + std::to_string(i) + " of a contact probe has a radius of " +
                            std::to_string(points[i].radius) +
                            " m; center and radius must be finite, the radius positive");
    }
  }
  data_->points.assign(points.begin(), points.end());
}
ContactProbe::~ContactProbe() = default;
ContactProbe::ContactProbe(ContactProbe&&) noexcept = default;
ContactProbe& ContactProbe::operator=(ContactProbe&&) noexcept = default;

void ContactProbe::collect_patch(const Solver& solver, ToolId tool, GraspState grasp,
                                 std::uint64_t sequence, double time, ContactPatch& patch) {
  Data& data = *data_;
  data.begin(solver, tool, grasp, sequence, time, patch);
  data.near.update(solver, data.balls, time);
  data.near.add_near(solver.tissue(), data.culled);
  data.cull.find(data.culled, data.balls, data.near.reaches(), ContactPatch::kMargin);
  data.near.note_reaches(data.cull.reaches());
  data.end(patch);
}

void ContactProbe::collect_patch(std::span<const TouchedSurface> surfaces, const Solver& solver,
                                 ToolId tool, GraspState grasp, std::uint64_t sequence, double time,
                                 ContactPatch& patch) {
  Data& data = *data_;
  if (surfaces.size() != data.near.body_count()) {
    throw InvalidArgument("there are " + std::to_string(surfaces.size()) + " surfaces for " +
                          std::to_string(data.near.body_count()) + " bodies; one each");
  }
  data.begin(solver, tool, grasp, sequence, time, patch);
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    data.culled.push_back(
        data.near.culled(solver.tissue(), i, surfaces[i].triangles, surfaces[i].positions));
  }
  data.whole.assign(data.points.size(), kAll);
  data.cull.find(data.culled, data.balls, data.whole, ContactPatch::kMargin);
  data.end(patch);
}

ContactPacket make_contact_packet(ContactProbe& probe, const Solver& solver, ToolId tool,
                                  GraspState grasp, std::uint64_t sequence, double time) {
  ContactPatch& patch = probe.data_->patch;
  probe.collect_patch(solver, tool, grasp, sequence, time, patch);
  return make_contact_packet(patch);
}

}  // namespace pbdsurg
