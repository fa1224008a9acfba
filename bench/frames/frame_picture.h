// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The picture of a frame, as the demo's window draws it; in a build without pictures, why there is
/// none.

#include <filesystem>
#include <memory>
#include <string>

#include "bench/frames/frame_world.h"

namespace pbdsurg::bench {

inline constexpr int kFrameWidth = 1280;
inline constexpr int kFrameHeight = 720;

/// Keeps the surfaces of a world in the memory of whoever draws.
class FramePicture {
 public:
  FramePicture() = default;
  virtual ~FramePicture() = default;
  FramePicture(const FramePicture&) = delete;
  FramePicture& operator=(const FramePicture&) = delete;

  /// Takes what the last frame changed (positions, triangles, burns) and begins to send and draw
  /// it, on a thread of its own: the next frame may be simulated meanwhile.
  virtual void start() = 0;
  /// Waits until the picture is there, without reading it back.
  /// @return  what of it went into sending, ms
  virtual double finish() = 0;
  /// Reads it back.
  /// @throws Error  if it shows nothing
  virtual void write(const std::filesystem::path& path) = 0;

  /// As OpenGL names it.
  [[nodiscard]] virtual const std::string& renderer() const = 0;
  /// Whether that is a program on the CPU.
  [[nodiscard]] virtual bool is_software() const = 0;
  /// "full" on a GPU, "quick" in software
  [[nodiscard]] std::string quality() const { return is_software() ? "quick" : "full"; }
};

/// One picture has been drawn then, since shaders are compiled with the first.
/// @param world  must outlive it
/// @throws BackendUnavailable  if no picture can be drawn here, saying why
[[nodiscard]] std::unique_ptr<FramePicture> make_frame_picture(const FrameWorld& world);

}  // namespace pbdsurg::bench
