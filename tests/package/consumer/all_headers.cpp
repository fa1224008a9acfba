// SPDX-License-Identifier: Apache-2.0
// Would catch a public header that the warnings of a user's project refuse, as long as templates of
// its kind are used here.
#include "pbdsurg/pbdsurg.h"

namespace pbdsurg {

template class UndoArray<int>;

float total_area(const ThermalMesh& mesh, const ConstraintVertices& constraints) {
  float sum = 0;
  mesh.for_each_corner(0, [&](Index tet, int) { sum += static_cast<float>(mesh.volume(tet)); });
  for (const Index vertex : constraints[0]) {
    sum += static_cast<float>(vertex);
  }
  return sum;
}

template <class Constraint>
float project_one() {
  Vec3<float> x[Constraint::kVertexCount]{};
  float multipliers[Constraint::kMultiplierCount]{};
  return Constraint::template move<ProjectionMode::compliance>(x, {}, {}, Substep<float>{1, 1},
                                                               multipliers)
      .of[0]
      .x;
}

float project_all() {
  return project_one<DistanceConstraint>() + project_one<NeoHookeanConstraint>() +
         project_one<VolumeConstraint>();
}

}  // namespace pbdsurg
