// SPDX-License-Identifier: Apache-2.0
// What a step tells of itself, in words.
#include <string>

#include "pbdsurg/world/world.h"

namespace pbdsurg {

const char* name_of(EditSource source) {
  switch (source) {
    case EditSource::heat:
      return "heat";
    case EditSource::strands:
      return "strands";
    case EditSource::program:
      return "program";
  }
  throw InvalidArgument("unknown source of edits");
}

bool Frame::ok() const noexcept {
  return refused.empty() && report.non_finite_vertices == 0 && !report.stalled;
}

std::string Frame::why() const {
  if (report.non_finite_vertices > 0) {
    return std::to_string(report.non_finite_vertices) + " vertices are not finite, the first is " +
           std::to_string(report.first_non_finite);
  }
  if (report.stalled) {
    return "the device gave the step up, because a block of its kernel did not go on";
  }
  if (!refused.empty()) {
    return std::string("an edit of ") + name_of(refused.front().source) +
           " was refused: " + refused.front().why;
  }
  return {};
}

}  // namespace pbdsurg
