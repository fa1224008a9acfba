// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Pictures of a run, and the plots of its curves.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "pbdsurg/mesh/mesh_data.h"

#include "apps/cholecystectomy/burn_layers.h"
#include "apps/cholecystectomy/procedure.h"
#include "apps/cholecystectomy/recorders.h"
#include "apps/viewer/offscreen_renderer.h"

namespace cholecystectomy {

/// Draws the scene at each moment into DIR/NN_name.png.
class PictureRecorder final : public Observer {
 public:
  /// @throws pbdsurg::BackendUnavailable  if nothing can draw here, with the reason
  PictureRecorder(const std::filesystem::path& directory, const pbdsurg::MeshData& backdrop);

  void step(const Simulation& simulation, double progress) override;
  void moment(const Simulation& simulation, const std::string& name) override;

  /// The files written so far.
  std::vector<std::filesystem::path> files;

 private:
  /// What the renderer knows of an organ.
  struct Seen {
    std::vector<pbdsurg::Triangle> skin;  // at the first moment, by slot: what differs is inside
    std::size_t vertex_count;
    std::uint64_t version;
  };
  void show_surfaces(const Simulation& simulation, const std::vector<Eigen::Vector4f>& burns);

  std::filesystem::path directory_;
  pbdsurg::MeshData backdrop_;
  OffscreenRenderer renderer_;
  std::vector<Seen> seen_;  // [organ]
  std::vector<SmokePuff> smoke_;
  std::vector<Eigen::Vector3f> smoke_velocities_;
};

}  // namespace cholecystectomy
