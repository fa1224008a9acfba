// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Tissue of tests/haptics/rig.h that a solver simulates, with packets of what a tool meets there.

#include <memory>
#include <optional>
#include <vector>

#include "pbdsurg/contact/contact_probe.h"
#include "pbdsurg/solver/solver.h"

#include "tests/haptics/rig.h"

namespace pbdsurg::testing {

/// A tool whose tip is its origin, and what a packet says of it.
struct FeltTool {
  std::vector<Capsule> capsules;
  std::vector<ToolPoint> points;
  ToolSurface surface{ContactFeatures::all, 0};
};

/// A scene below y = 0, and the tool that a hand holds over it. Steps once for each packet, by the
/// time that passed since the last, at most 0.1 s.
class SimulatedTissue {
 public:
  SimulatedTissue(const Scene& scene, const FeltTool& tool);

  /// The packet of where the hand is now.
  void operator()(ContactPacket& packet, double time);

  /// The tool is jaws that close on the first body when force has been let in.
  void close_jaws(const Grip& grip) { grip_ = grip; }

  /// N, of the tissue on the tool, in the last step of each packet.
  [[nodiscard]] const std::vector<Eigen::Vector3f>& forces() const noexcept { return forces_; }

 private:
  [[nodiscard]] GraspState grasp() const;

  Solver solver_;
  ToolId tool_;
  ContactProbe probe_;
  std::optional<Grip> grip_;  // until they have closed
  std::vector<Eigen::Vector3f> forces_;
  double time_ = 0;
};

/// A tissue that rigs share. What it holds outlives the rig.
[[nodiscard]] FakeTissue felt(std::shared_ptr<SimulatedTissue> tissue);

/// A block of 20 x 20 mm, 25 mm deep, and a plate wider than it that sticks to it: four points of
/// contact on a spring, see plate_force().
[[nodiscard]] Scene spring_block();
[[nodiscard]] FeltTool plate();

/// N, of a static solution in double precision: what the block takes, its top that deep.
/// @param depth  m
[[nodiscard]] double plate_force(double depth);

/// Blocks of tissue for a rod of 2 mm to meet with its tip: a face, an edge, or a vertex, at the
/// origin, on cells of 4 mm.
enum class Place { face, edge, vertex };
[[nodiscard]] Scene pointed_block(Place place);
[[nodiscard]] FeltTool rod();

/// Of what a hand or a weight of half a newton presses a tool on.
struct PressedScene {
  const char* name;
  Scene (*scene)();
  FeltTool (*tool)();
};
[[nodiscard]] std::vector<PressedScene> pressed_scenes();

/// Light and heavy plants, with little friction and much, early and late packets, in a hand and,
/// on a guide, without.
[[nodiscard]] std::vector<Case> simulated_grid();

/// pushed() on simulated tissue.
struct Pressed {
  Rig rig;
  double depth;      ///< m, mean of the last second
  double felt;       ///< N, commanded, likewise
  double simulated;  ///< N, of the tissue on the tool, likewise
};
[[nodiscard]] Pressed press(const PressedScene& scene, const Case& one);

/// A slab of 40 x 30 mm, 12 mm thick, that stands on its lower edge, for jaws at the upper one.
[[nodiscard]] Scene standing_slab();
[[nodiscard]] FeltTool jaws();
[[nodiscard]] Grip slab_grip();

/// What a hand feels that closes jaws on the slab and pulls by 14 mm, and for a second afterwards.
[[nodiscard]] Rig pulled_slab(const Grip& grip);

/// A sheet of 40 x 40 mm at y = 0, held at its rim, for a ball of 3 mm.
[[nodiscard]] Scene held_sheet();
[[nodiscard]] FeltTool ball();

}  // namespace pbdsurg::testing
