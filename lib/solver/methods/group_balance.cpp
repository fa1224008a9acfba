// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/group_balance.h"

#include <Eigen/Cholesky>

namespace pbdsurg {
namespace {

using Vec3d = Vec3<double>;

constexpr int kMostRows = 6 * GroupScrews::kMostPieces;
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostRows, kMostRows>;

Eigen::Vector<double, 6> vector_of(const Vec3d& linear, const Vec3d& angular) {
  return {linear.x, linear.y, linear.z, angular.x, angular.y, angular.z};
}

Vec3d move_at(const GroupScrews& twists, Index piece, const Vec3d& arm) {
  const Screw twist = twists.of(piece);
  return twist.linear + cross(twist.angular, arm);
}

ContactAnswer<double> answer(const GroupContact& contact, const GroupScrews& twists) {
  Vec3d move = move_at(twists, contact.first, contact.contact.arm);
  if (contact.second != kInvalidIndex) {
    move = move - move_at(twists, contact.second, contact.other_arm);
  }
  return contact.contact.answer(move);
}

}  // namespace

GroupScrews GroupBalance::twists() const {
  GroupScrews rest;
  rest.values.setZero(6 * static_cast<Index>(bodies_.size()));
  return BalancingMotion<GroupBalance, GroupScrews>(*this).from(rest);
}

GroupScrews GroupBalance::imbalance(const GroupScrews& twists) const {
  GroupScrews sum = twists;
  for (Index i = 0; i < static_cast<Index>(bodies_.size()); ++i) {
    const Screw lack = bodies_[i].lack(twists.of(i));
    sum.values.segment<6>(6 * i) = vector_of(lack.linear, lack.angular);
  }
  for (const GroupContact& contact : contacts_) {
    const ContactForce<double> force = answer(contact, twists).force;
    const Vec3d push = force.push * contact.contact.normal + force.drag;
    sum.values.segment<6>(6 * contact.first) += vector_of(push, cross(contact.contact.arm, push));
    if (contact.second != kInvalidIndex) {
      sum.values.segment<6>(6 * contact.second) -= vector_of(push, cross(contact.other_arm, push));
    }
  }
  return sum;
}

GroupScrews GroupBalance::way(const GroupScrews& twists, const GroupScrews& wrenches) const {
  const Eigen::Index rows = twists.values.size();
  Matrix matrix = Matrix::Zero(rows, rows);
  for (Index i = 0; i < static_cast<Index>(bodies_.size()); ++i) {
    const Inertia& inertia = bodies_[i].inertia;
    matrix.block<3, 3>(6 * i, 6 * i).diagonal().setConstant(bodies_[i].mass);
    matrix.block<3, 3>(6 * i + 3, 6 * i + 3) << inertia.xx, inertia.xy, inertia.xz,  //
        inertia.xy, inertia.yy, inertia.yz,                                          //
        inertia.xz, inertia.yz, inertia.zz;
  }
  for (const GroupContact& contact : contacts_) {
    const auto add = [&](double stiffness, const Vec3d& direction) {
      const auto first = vector_of(direction, cross(contact.contact.arm, direction));
      const Index f = 6 * contact.first;
      matrix.block<6, 6>(f, f) += stiffness * first * first.transpose();
      if (contact.second == kInvalidIndex) {
        return;
      }
      const auto second = vector_of(direction, cross(contact.other_arm, direction));
      const Index s = 6 * contact.second;
      matrix.block<6, 6>(s, s) += stiffness * second * second.transpose();
      matrix.block<6, 6>(f, s) -= stiffness * first * second.transpose();
      matrix.block<6, 6>(s, f) -= stiffness * second * first.transpose();
    };
    contact.contact.for_each_spring(answer(contact, twists), add);
  }
  return {matrix.llt().solve(wrenches.values)};
}

}  // namespace pbdsurg
