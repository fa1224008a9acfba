// SPDX-License-Identifier: Apache-2.0
// One copy of a world: calls of the solver for it.
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/world/world.h"

namespace pbdsurg {

void Replica::move(ToolId tool, const ToolPose& pose) {
  solver_->move_tool(tool, pose, id_);
}
void Replica::set_joint(ToolId tool, Index joint, float angle) {
  solver_->set_joint(tool, joint, angle, id_);
}
void Replica::grasp(ToolId tool, std::span<const Index> vertices, float compliance) {
  solver_->grasp(tool, vertices, compliance, id_);
}
void Replica::grasp(ToolId tool, std::span<const TissuePoint> points, const Grip& grip) {
  solver_->grasp(tool, points, grip, id_);
}
std::size_t Replica::close_jaws(ToolId tool, std::array<ToolId, 2> jaws, const Grip& grip) {
  return solver_->close_jaws(tool, jaws, grip, id_);
}
void Replica::set_clamp_force(ToolId tool, float force) {
  solver_->set_clamp_force(tool, force, id_);
}
GripReport Replica::grip(ToolId tool) const {
  return solver_->tool_grip(tool, id_);
}
void Replica::release(ToolId tool) {
  solver_->release(tool, id_);
}
void Replica::set_forces(std::span<const Index> vertices, std::span<const Eigen::Vector3f> forces) {
  solver_->set_forces(vertices, forces, id_);
}
void Replica::clear_forces() {
  solver_->clear_forces(id_);
}
void Replica::set_factors(const CopyFactors& factors) {
  solver_->set_factors(factors, id_);
}
CopyFactors Replica::factors() const {
  return solver_->factors(id_);
}
Eigen::Vector3f Replica::force(ToolId tool) const {
  return solver_->tool_force(tool, id_);
}
std::vector<Eigen::Vector3f> Replica::positions() const {
  return solver_->positions(id_);
}
std::vector<Eigen::Vector3f> Replica::velocities() const {
  return solver_->velocities(id_);
}
StepReport Replica::report() const {
  return solver_->last_report(id_);
}
Snapshot Replica::snapshot() const {
  return solver_->snapshot(id_);
}
void Replica::restore(const Snapshot& snapshot) {
  solver_->restore(snapshot, id_);
}
std::uint64_t Replica::state_hash() const {
  return solver_->state_hash(id_);
}

}  // namespace pbdsurg
