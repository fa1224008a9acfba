// SPDX-License-Identifier: Apache-2.0
#include "bench/frames/report.h"

namespace pbdsurg::bench {

Json to_json(const FrameStages& stages) {
  return {{"heat", rounded(stages.heat, 1e3)},         {"edit", rounded(stages.edit, 1e3)},
          {"solver", rounded(stages.solver, 1e3)},     {"contact", rounded(stages.contact, 1e3)},
          {"readback", rounded(stages.readback, 1e3)}, {"upload", rounded(stages.upload, 1e3)},
          {"picture", rounded(stages.picture, 1e3)}};
}

Json to_json(const std::optional<FrameTimes>& times) {
  if (!times) {
    return nullptr;
  }
  return {{"frames_per_s", rounded(times->frames_per_s, 1e2)},
          {"frame_ms", rounded(times->median_ms, 1e3)},
          {"p99_ms", rounded(times->p99_ms, 1e3)},
          {"frames", times->frames},
          {"contacts", rounded(times->contacts, 1e1)},
          {"step_ms", rounded(1e3 * times->step, 1e3)},
          {"realtime_factor", rounded(times->realtime_factor(), 1e4)},
          {"size", std::to_string(kFrameWidth) + "x" + std::to_string(kFrameHeight)},
          {"backend", times->backend},
          {"renderer", times->renderer},
          {"quality", times->quality},
          {"stages_ms", to_json(times->stages)}};
}

}  // namespace pbdsurg::bench
