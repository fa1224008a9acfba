// SPDX-License-Identifier: Apache-2.0
#include "bench/frames/measure.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "bench/support/timing.h"

namespace pbdsurg::bench {
namespace {

constexpr int kFramesApart = 25;  // whose stages follow one another, for the time of each
constexpr int kFirstFrames = 2;   // which bring the state to a device, and tools to their places

}  // namespace

FrameEffort frame_effort(bool is_software, bool steps_on_gpu, bool quick) {
  if (quick) {
    return {3, 3, 0};
  }
  if (is_software) {
    return {5, 60, 3};
  }
  return steps_on_gpu ? FrameEffort{400, 400, 0} : FrameEffort{5, 400, 3};
}

FrameTimes measure_frames(FrameWorld& world, FrameWorld& apart, FramePicture* picture,
                          const FrameEffort& effort, const std::filesystem::path& file) {
  const auto start_picture = [&] {
    if (picture != nullptr) {
      picture->start();
    }
  };
  const auto finish_picture = [&] { return picture != nullptr ? picture->finish() : 0.0; };
  for (int i = 0; i < kFirstFrames; ++i) {
    world.next();
    apart.next();
    start_picture();
    finish_picture();
  }
  std::vector<double> whole;
  double seconds = 0, energy = 0, contacts = 0;
  int touching = 0;
  for (int i = 0;
       i < effort.most_frames && (i < effort.least_frames || seconds < effort.most_seconds); ++i) {
    Frame frame;
    // a picture is drawn while the next frame is simulated, and done before that is shown
    whole.push_back(time_of([&] {
      frame = world.next();
      finish_picture();
      start_picture();
    }));
    seconds += 1e-3 * whole.back();
    energy += frame.cauteries.front().energy;
    contacts += frame.report.contacts;
    touching += frame.report.contacts > 0 ? 1 : 0;
  }
  finish_picture();
  std::vector<double> heat, edit, step, step_apart, readback, upload, draw;
  for (int i = 0; i < std::min(kFramesApart, effort.least_frames); ++i) {
    const Frame frame = world.next();
    heat.push_back(1e3 * frame.times.heat);
    edit.push_back(1e3 * frame.times.edit);
    step.push_back(1e3 * frame.times.step);
    readback.push_back(1e3 * frame.times.readback);
    step_apart.push_back(1e3 * apart.next().times.step);
    const double picture_ms = time_of([&] {
      start_picture();
      upload.push_back(finish_picture());
    });
    draw.push_back(picture_ms - upload.back());
  }
  if (2 * touching < static_cast<int>(whole.size())) {
    throw Error("instruments touch tissue in " + std::to_string(touching) + " of " +
                std::to_string(whole.size()) + " frames");
  }
  if (energy <= 0) {
    throw Error("the hook heats nothing");
  }
  if (picture != nullptr && !file.empty()) {
    picture->write(file);
  }
  const double contact = std::max(median(step) - median(step_apart), 0.0);
  const double sum = std::accumulate(whole.begin(), whole.end(), 0.0);
  return {world.world().solver().backend_name(),
          picture != nullptr ? picture->renderer() : "",
          picture != nullptr ? picture->quality() : "",
          world.step(),
          static_cast<int>(whole.size()),
          contacts / static_cast<double>(whole.size()),
          1e3 * static_cast<double>(whole.size()) / sum,
          median(whole),
          quantile(whole, 0.99),
          {median(heat), median(edit), median(step) - contact, contact, median(readback),
           median(upload), median(draw)}};
}

}  // namespace pbdsurg::bench
