// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How long a whole frame takes: a step under two instruments, heat, and a picture of it.

#include <filesystem>
#include <string>

#include "bench/frames/frame_picture.h"

namespace pbdsurg::bench {

/// No further frame begins after so many seconds, once there are enough, nor when there are most.
struct FrameEffort {
  int least_frames;
  int most_frames;
  double most_seconds;
};

/// A picture in software takes longer than all else, and then few frames tell. With a picture by a
/// GPU, p99 needs a few hundred.
[[nodiscard]] FrameEffort frame_effort(bool is_software, bool steps_on_gpu, bool quick);

/// ms a frame, medians of frames whose stages follow one another.
struct FrameStages {
  double heat;
  double edit;     ///< what heat removed and parted
  double solver;   ///< without contact
  double contact;  ///< what a step takes more than without; at least zero
  double readback;
  double upload;   ///< to whoever draws
  double picture;  ///< until it is there
};

struct FrameTimes {
  std::string backend;
  std::string renderer;
  std::string quality;
  double step;  ///< s, of a frame
  int frames;
  double contacts;      ///< of vertices and instruments in a frame, mean
  double frames_per_s;  ///< of all frames and their time
  double median_ms;
  double p99_ms;
  FrameStages stages;

  /// Simulated time over wall time.
  [[nodiscard]] double realtime_factor() const { return step * frames_per_s; }
};

/// @param apart    the same world without contact, whose steps are timed by turns with those of
///                 `world`
/// @param picture  of `world`; null for frames without
/// @param file     for the picture of the last frame, or empty
/// @throws Error  if instruments touch or the hook heats nothing, or the picture shows nothing
[[nodiscard]] FrameTimes measure_frames(FrameWorld& world, FrameWorld& apart, FramePicture* picture,
                                        const FrameEffort& effort,
                                        const std::filesystem::path& file = {});

}  // namespace pbdsurg::bench
