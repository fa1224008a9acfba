// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/solver/tet_stress.h"

#include <Eigen/LU>
#include <string>

#include "lib/base/check.h"
#include "lib/solver/sets/neo_hookean_record.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

using Constraint = NeoHookeanConstraint;

// Of the scene.
// @param sides  m, from the first vertex, in columns
TetStress stress_of(const ConstraintRecord<Constraint>& record, const Fibre& fibre,
                    const Eigen::Matrix3d& sides) {
  const Eigen::Matrix3d inverse = inverse_shape(record);
  const double ratio = record.parameters[Constraint::kRatio];
  const double mu = record.parameters[Constraint::kStiffness] * 6 * inverse.determinant();
  const Eigen::Matrix3d deformation = sides * inverse;
  const double volume = deformation.determinant();
  const Eigen::Matrix3d one = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d stress =
      mu / volume * (deformation * deformation.transpose()) - mu * (1 + ratio * (1 - volume)) * one;
  const Eigen::Vector3d along = deformation * fibre.direction.cast<double>();
  if (const double stretch = along.norm(); stretch > 1) {
    stress += fibre.stiffness * (stretch - 1) / (stretch * volume) * (along * along.transpose());
  }
  return {deformation.cast<float>(),
          (0.5 * (deformation.transpose() * deformation - one)).cast<float>(),
          stress.cast<float>()};
}

}  // namespace

std::vector<TetStress> tet_stresses(const Solver& solver, std::span<const Index> tets, Index copy) {
  const auto& solids = solver_data(solver).sets.of<Constraint>();
  const Tissue& tissue = solver.tissue();
  std::vector<Index> vertices;
  for (const Index t : tets) {
    check_id("tet", t, tissue.tets().size());
    if (!solids.is_alive(t)) {
      throw InvalidArgument("tet " + std::to_string(t) +
                            " was removed or belongs to a body that is not Neo-Hookean; only such "
                            "tissue has a stress");
    }
    const Tet& corners = tissue.tets()[t];
    vertices.insert(vertices.end(), corners.begin(), corners.end());
  }
  std::vector<Eigen::Vector3f> x(vertices.size());
  solver.read_positions(vertices, x, copy);
  std::vector<TetStress> stresses;
  stresses.reserve(tets.size());
  for (std::size_t i = 0; i < tets.size(); ++i) {
    Eigen::Matrix3d sides;
    for (std::size_t k = 0; k < 3; ++k) {
      sides.col(static_cast<Eigen::Index>(k)) = (x[4 * i + k + 1] - x[4 * i]).cast<double>();
    }
    stresses.push_back(stress_of(solids.record(tets[i]), tissue.fibre(tets[i]), sides));
    stresses.back().stress *= solver.factors(copy).stiffness;
  }
  return stresses;
}

}  // namespace pbdsurg
