// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/haptics/contact_packet.h"

#include <Eigen/Eigenvalues>
#include <limits>

#include "pbdsurg/base/random.h"

#include "tests/support/catch.h"

namespace pbdsurg {
namespace {

using testing::Approx;

Eigen::Isometry3f sample_pose() {
  Eigen::Isometry3f pose = Eigen::Isometry3f::Identity();
  pose.rotate(Eigen::AngleAxisf(0.7F, Eigen::Vector3f(1, 2, 3).normalized()));
  pose.translation() = Eigen::Vector3f(0.1F, -0.2F, 0.3F);
  return pose;
}

// A packet of planes through the tool's points, at gaps.
ContactPacket packet_of(std::initializer_list<std::pair<Eigen::Vector3f, float>> planes) {
  ContactPacket packet;
  packet.sequence = 1;
  set_pose(packet, sample_pose());
  for (const auto& [normal, gap] : planes) {
    ContactPlane& plane = packet.planes[packet.plane_count++];
    plane.point = {1e-3F * static_cast<float>(packet.plane_count), 0, 2e-3F};
    plane.normal = packet_vector(normal.normalized());
    plane.offset = normal.normalized().dot(pose_of(packet) * vector_of(plane.point)) - gap;
  }
  return packet;
}

}  // namespace

TEST_CASE("contact packet: the largest eigenvalue is Eigen's", "[unit]") {
  for (std::uint64_t i = 0; i < 1000; ++i) {
    Eigen::Matrix3f root;
    for (std::uint64_t k = 0; k < 9; ++k) {
      root.data()[k] = static_cast<float>(20 * random_unit(7, i, k) - 10);
    }
    root.col(2) *= i % 2 == 0 ? 0.0F : 1.0F;
    const Eigen::Matrix3f matrix = root * root.transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver(matrix);
    REQUIRE(largest_eigenvalue(matrix) == Approx(solver.eigenvalues()[2]).epsilon(1e-5));
  }
  CHECK(largest_eigenvalue(Eigen::Matrix3f::Zero()) == 0);
  CHECK(largest_eigenvalue(180 * Eigen::Matrix3f::Identity()) == Approx(180));
}

TEST_CASE("contact packet: a fitted packet pushes as the simulation does", "[unit]") {
  const auto check_fit = [](ContactPacket packet, const Eigen::Vector3f& force) {
    packet.force = packet_vector(force);
    fit_to_force(packet, 120);
    CHECK(is_valid(packet));
    const Eigen::Vector3f felt = packet.grasp.state == GraspState::held
                                     ? grasp_force(packet.grasp, pose_of(packet))
                                     : plane_force(packet, pose_of(packet));
    CHECK((felt - force).norm() < 2e-3F);
    CHECK(largest_eigenvalue(summed_stiffness(packet)) == Approx(120).epsilon(1e-3));
    return packet;
  };
  const Eigen::Vector3f up(0, 1, 0), left(-1, 0.2F, 0.1F), slope(0.3F, 1, 0);
  check_fit(packet_of({{up, 0}}), {0, 0.7F, 0});
  check_fit(packet_of({{up, 0}, {slope, 0}, {left, 0}}), {-0.2F, 0.9F, 0.1F});
  check_fit(packet_of({{up, 0}}), {0.4F, 0.7F, 0});    // what it cannot bear
  check_fit(packet_of({{up, 0}}), {0, -0.7F, 0});      // nothing of it
  check_fit(packet_of({{up, -5e-3F}}), {0, 0.1F, 0});  // deeper than the force says
  check_fit(packet_of({{up, 0}, {up, 0}, {up, 0}, {up, 0}}), {0, 1, 0});
  check_fit(
      packet_of({{up, 0}, {up, 0}, {up, 0}, {up, 0}, {up, 0}, {up, 0}, {up, 0}, {left, 4e-3F}}),
      {0, 1, 1});
  ContactPacket held = packet_of({{up, 0}});
  held.grasp.state = GraspState::held;
  check_fit(held, {0.3F, -0.9F, 0});

  // planes that do not touch stay where they are, and need no force
  const ContactPacket near = check_fit(packet_of({{up, 3e-3F}}), {0, 0, 0});
  Eigen::Isometry3f pose = pose_of(near);
  pose.translation().y() -= 4e-3F;
  CHECK(plane_force(near, pose).y() == Approx(120 * 1e-3F).epsilon(0.01));
}

// Would catch one plane that bears it all: as a tool goes back it would lose the others at once,
// and the tissue would seem a quarter as stiff.
TEST_CASE("contact packet: planes that are alike bear alike", "[unit]") {
  ContactPacket packet;
  packet.plane_count = 4;
  for (std::uint32_t i = 0; i < packet.plane_count; ++i) {
    packet.planes[i].point = {0.01F * static_cast<float>(i % 2), 0.01F * static_cast<float>(i / 2),
                              0};
  }
  packet.force = {0, 0, 1};
  fit_to_force(packet, 200);
  for (std::uint32_t i = 0; i < packet.plane_count; ++i) {
    CHECK(packet.planes[i].offset == Approx(1.0 / 200));
  }
  Eigen::Isometry3f pose = pose_of(packet);
  pose.translation().z() += 2e-3F;
  CHECK(plane_force(packet, pose).z() == Approx(1 - 200 * 2e-3));

  // also beside another, which bears some of a force that leans towards it
  packet.plane_count = 5;
  packet.planes[4] = {.normal = {0.6F, 0, 0.8F}};
  packet.force = {0.3F, 0, 1};
  fit_to_force(packet, 200);
  for (std::uint32_t i = 1; i < 4; ++i) {
    CHECK(packet.planes[i].offset == Approx(packet.planes[0].offset).epsilon(1e-3));
  }
  CHECK(packet.planes[4].offset > 0);
  CHECK((plane_force(packet, pose_of(packet)) - vector_of(packet.force)).norm() < 1e-4F);
}

// Would catch the plane that leans most towards a little friction bearing all of a push.
TEST_CASE("contact packet: planes that are nearly alike bear nearly alike", "[unit]") {
  ContactPacket packet;
  packet.plane_count = 4;
  for (std::uint32_t i = 0; i < packet.plane_count; ++i) {
    const Eigen::Vector3f lean(i == 0 ? 0.02F : -0.01F, i == 1 ? 0.02F : -0.01F, 1);
    packet.planes[i].normal = packet_vector(lean.normalized());
  }
  packet.force = {0.05F, 0.02F, 1};
  fit_to_force(packet, 200);
  for (std::uint32_t i = 0; i < 4; ++i) {
    CHECK(packet.planes[i].offset * packet.planes[i].stiffness == Approx(0.25).epsilon(0.1));
  }
  CHECK((plane_force(packet, pose_of(packet)) - vector_of(packet.force)).norm() < 1e-4F);
}

TEST_CASE("contact packet: a grasp bears no more than it can", "[unit]") {
  ContactPacket packet = packet_of({});
  packet.grasp.state = GraspState::held;
  packet.force = {0, 0, 9};
  fit_to_force(packet, 100);
  CHECK(grasp_force(packet.grasp, pose_of(packet)).z() == Approx(packet.grasp.largest_force));
  Eigen::Isometry3f pose = pose_of(packet);
  pose.translation().z() += 5e-3F;  // a pull that was not borne is not stored either
  CHECK(grasp_force(packet.grasp, pose).z() ==
        Approx(packet.grasp.largest_force - 0.5F).epsilon(1e-3));
}

TEST_CASE("contact packet: what cannot be felt is not valid", "[unit]") {
  const ContactPacket fine = packet_of({{{0, 1, 0}, 0}});
  CHECK(is_valid(fine));
  CHECK(is_valid(ContactPacket{}));
  const auto is_valid_with = [&](auto change) {
    ContactPacket packet = fine;
    change(packet);
    return is_valid(packet);
  };
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  CHECK_FALSE(is_valid_with([](ContactPacket& p) { p.planes[0].normal = {0, 2, 0}; }));
  CHECK_FALSE(is_valid_with([](ContactPacket& p) { p.planes[0].stiffness = -1; }));
  CHECK_FALSE(is_valid_with([](ContactPacket& p) { p.plane_count = 9; }));
  CHECK_FALSE(is_valid_with([](ContactPacket& p) { p.force[1] = kNan; }));
  CHECK_FALSE(is_valid_with([](ContactPacket& p) { p.rotation = {0, 0, 0, 0}; }));
  CHECK_FALSE(is_valid_with([](ContactPacket& p) { p.drag = -1; }));
  CHECK_FALSE(is_valid_with([](ContactPacket& p) {
    p.grasp.state = GraspState::held;
    p.grasp.anchor[0] = kNan;
  }));
  CHECK(is_valid_with([](ContactPacket& p) { p.planes[1].offset = kNan; }));  // does not count
}

}  // namespace pbdsurg
