// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Pictures of a run, and the plots of its curves.

#include <filesystem>
#include <optional>
#include <vector>

#include "pbdsurg/mesh/mesh_data.h"

#include "apps/cholecystectomy/play/scene_feed.h"
#include "apps/cholecystectomy/procedure.h"
#include "apps/cholecystectomy/recorders.h"
#include "apps/cholecystectomy/smoke.h"
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
  std::filesystem::path directory_;
  pbdsurg::MeshData backdrop_;
  OffscreenRenderer renderer_;
  std::optional<SceneFeed> feed_;  // from the first step on
  Smoke smoke_;
};

}  // namespace cholecystectomy
