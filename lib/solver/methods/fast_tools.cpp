// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/fast_tools.h"

#include <algorithm>

#include "lib/solver/methods/contact_stage.h"
#include "lib/solver/methods/feature_search.h"

namespace pbdsurg {
namespace {

bool presses(const ToolState& tool) {
  return tool.meets_triangles() &&
         std::ranges::any_of(tool.remembered,
                             [](const RememberedContact& contact) { return contact.force > 0; });
}

// Calls visit(radii) for each such tool.
template <class Visit>
void for_each_way(CopyState& copy, const Visit& visit) {
  for (ToolState& tool : copy.tools) {
    if (!presses(tool)) {
      continue;
    }
    place_capsules(tool, tool.pose, 0, tool.capsules_before);
    place_capsules(tool, tool.target, 1, tool.placed_capsules);
    float radii = 0;
    for (std::size_t c = 0; c < tool.capsules.size(); ++c) {
      radii = std::max(radii, swept_capsule(tool, c).relative_way());
    }
    visit(radii);
  }
}

}  // namespace

float farthest_way(CopyState& copy) {
  float farthest = 0;
  for_each_way(copy, [&](float radii) { farthest = std::max(farthest, radii); });
  return farthest;
}

Index count_fast_tools(CopyState& copy, int substeps) {
  Index count = 0;
  for_each_way(
      copy, [&](float radii) { count += radii > kFastWay * static_cast<float>(substeps) ? 1 : 0; });
  return count;
}

}  // namespace pbdsurg
