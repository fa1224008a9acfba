// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/instrument_contacts.h"

#include <cstddef>
#include <span>
#include <vector>

#include "pbdsurg/haptics/servo.h"

namespace cholecystectomy {
namespace {

using pbdsurg::ToolPoint;

pbdsurg::ContactProbe make_probe(const Simulation& simulation, std::span<const ToolPoint> points) {
  std::vector<pbdsurg::Index> bodies;
  for (const Organ organ : pbdsurg::kOrgans) {
    bodies.push_back(simulation.world.body_in_tissue(body_of(organ)));
  }
  return {simulation.solver, bodies, points};
}

// Of the capsules that simulation.cpp makes of an instrument: ends, and places between.
constexpr float kJaw = 1.8e-3F, kShaft = 2.5e-3F, kHook = 0.5e-3F, kStem = 0.6e-3F;  // m, radii

std::vector<ToolPoint> grasper_points() {
  return {{{0, 0, 0}, kJaw},        {{0, 0, 8e-3F}, kJaw},    {{0, 0, 16e-3F}, kJaw},
          {{0, 0, 24e-3F}, kShaft}, {{0, 0, 36e-3F}, kShaft}, {{0, 0, 48e-3F}, kShaft}};
}

std::vector<ToolPoint> hook_points() {
  return {{{0, 0, 0}, kHook},           {{1.5e-3F, 0, 0.5e-3F}, kHook},
          {{3e-3F, 0, 1e-3F}, kStem},   {{3e-3F, 0, 6e-3F}, kStem},
          {{3e-3F, 0, 12e-3F}, kStem},  {{3e-3F, 0, 18e-3F}, kShaft},
          {{3e-3F, 0, 30e-3F}, kShaft}, {{3e-3F, 0, 42e-3F}, kShaft}};
}

// N, at the tip, from which the spring of the jaws saturates: 1.5 N in a hand by the usual scale.
constexpr float kLargestGrasp = 6;

}  // namespace

InstrumentContacts::InstrumentContacts(const Simulation& simulation)
    : probes_{make_probe(simulation, grasper_points()), make_probe(simulation, hook_points())} {}

void InstrumentContacts::collect(const Simulation& simulation, pbdsurg::GraspState grasp,
                                 std::uint64_t sequence, double time,
                                 const ContactPatches& patches) {
  // surfaces that the step has read already: however long it was, nothing is too fast for them
  std::array<pbdsurg::TouchedSurface, pbdsurg::kOrgans.size()> surfaces;
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const pbdsurg::Surface& surface = simulation.surface(pbdsurg::kOrgans[i]);
    surfaces[i] = {surface.triangles(), surface.positions()};
  }
  const std::array tools{simulation.grasper.tool, simulation.hook.tool};
  const std::array grasps{grasp, pbdsurg::GraspState::open};
  for (std::size_t i = 0; i < patches.size(); ++i) {
    if (patches[i] != nullptr) {
      probes_[i].collect_patch(surfaces, simulation.solver, tools[i], grasps[i], sequence, time,
                               *patches[i]);
    }
  }
}

pbdsurg::ContactPacket packet_of(const pbdsurg::ContactPatch& patch) {
  pbdsurg::ContactPacket packet = pbdsurg::make_contact_packet(patch);
  if (packet.grasp.state == pbdsurg::GraspState::held) {
    packet.grasp.largest_force = kLargestGrasp;
    pbdsurg::fit_to_force(packet, pbdsurg::kLeastStiffness);
  }
  return packet;
}

}  // namespace cholecystectomy
