// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Time series of meshes that ParaView opens.

#include <filesystem>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/mesh/mesh_data.h"
#include "pbdsurg/mesh/write.h"

namespace pbdsurg {

/// Writes `name.pvd` and, beside it, `name_000000.vtu`, `name_000001.vtu` ... The list is complete
/// after each frame, so that a series can be watched while it grows and survives a crash.
class PBDSURG_API MeshSeries {
 public:
  /// Writes an empty list at once, to fail early where nothing can be written.
  /// @param path  of the .pvd file; frames take its stem
  /// @throws InvalidArgument  if the extension is not .pvd
  /// @throws FileError        if the file cannot be written
  explicit MeshSeries(std::filesystem::path path);

  /// Adds a frame. Points, cells and fields may differ from those of the frame before.
  ///
  /// @param time    s, finite and not before the time of the last frame
  /// @param mesh    in metres
  /// @param fields  e.g. temperature of points, state and body of cells
  /// @throws InvalidArgument, InvalidMesh, FileError  as write_mesh()
  /// Cost: the frame, and one line for each frame so far.
  void add_frame(double time, const MeshData& mesh, const MeshFields& fields = {});

  /// Frames so far.
  [[nodiscard]] std::size_t frame_count() const noexcept { return times_.size(); }

 private:
  void write_list() const;

  std::filesystem::path path_;
  std::vector<double> times_;
};

}  // namespace pbdsurg
