// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A hook that rests on a gallbladder and heats it.

#include <memory>
#include <string>

#include "pbdsurg/heat/surface_map.h"
#include "pbdsurg/heat/surface_texture.h"
#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/surgery/cautery.h"
#include "pbdsurg/views/live_surface.h"

namespace pbdsurg::bench {

/// Physics and what the generator is set to.
struct BurnModel {
  std::string name;
  CauteryOptions cautery;
  GeneratorSettings generator;
};

/// The library's physics, 30 W.
BurnModel physical_burn();

/// The paper's: its tissue, no latent heat, the same current all the time, no metal that cools.
BurnModel paper_burn();

/// The organ does not move, so that pictures differ by heat alone.
class Burn {
 public:
  /// @param tip  m, of the hook
  Burn(const TetMesh& gallbladder, const Eigen::Vector3f& tip, const BurnModel& model);

  /// Heats until a time, s, and takes over what that did to the surface.
  void run_to(double time);

  [[nodiscard]] const LiveSurface& surface() const { return *surface_; }
  [[nodiscard]] const SurfaceTexture& texture() const { return texture_; }
  [[nodiscard]] const HeatField& field() const { return cautery_.field(); }

  /// Of the last step.
  [[nodiscard]] const CauteryReport& report() const { return report_; }

  /// Taken away so far, m^3.
  [[nodiscard]] double removed_volume() const { return removed_volume_; }

 private:
  Electrode electrode_;
  GeneratorSettings generator_;
  Solver solver_;
  Cautery cautery_;
  std::shared_ptr<const LiveSurface> surface_;
  SurfaceMap map_;
  SurfaceTexture texture_;
  CauteryReport report_;
  double removed_volume_ = 0;
  int steps_ = 0;
};

}  // namespace pbdsurg::bench
