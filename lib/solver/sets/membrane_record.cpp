// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/sets/membrane_record.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace pbdsurg {
namespace {

// N/m, the shear modulus times the thickness
double shear_stiffness(const Body& sheet, float stiffness) noexcept {
  const double ratio = sheet.material.poissons_ratio;
  const double mu = double{stiffness} * (sheet.material.youngs_modulus / (2 * (1 + ratio)));
  return mu * double{sheet.thickness};
}

}  // namespace

ConstraintRecord<MembraneConstraint> make_membrane(std::span<const Eigen::Vector3d> positions,
                                                   const Triangle& triangle, const Triangle& places,
                                                   const Body& sheet, float stiffness) {
  const Eigen::Vector3d first = positions[triangle[1]] - positions[triangle[0]];
  const Eigen::Vector3d second = positions[triangle[2]] - positions[triangle[0]];
  const Eigen::Vector3d along = first.normalized();
  Eigen::Matrix2d sides;
  sides << first.norm(), along.dot(second), 0, along.cross(second).norm();
  const Eigen::Matrix2d inverse = sides.inverse();
  const double ratio = sheet.material.poissons_ratio;
  ConstraintRecord<MembraneConstraint> record{places, {}};
  for (int i = 0; i < 4; ++i) {
    record.parameters[MembraneConstraint::kInverseShape + i] =
        static_cast<float>(inverse(i / 2, i % 2));
  }
  record.parameters[MembraneConstraint::kStiffness] =
      static_cast<float>(shear_stiffness(sheet, stiffness) * sides.determinant() / 2);
  record.parameters[MembraneConstraint::kRatio] = static_cast<float>((1 + ratio) / (1 - ratio));
  record.parameters[MembraneConstraint::kDamping] = sheet.material.damping;
  return record;
}

Eigen::Matrix2d rest_sides(const ConstraintRecord<MembraneConstraint>& record) {
  Eigen::Matrix2d inverse;
  for (int i = 0; i < 4; ++i) {
    inverse(i / 2, i % 2) = record.parameters[MembraneConstraint::kInverseShape + i];
  }
  return inverse.inverse();
}

double rest_area(const ConstraintRecord<MembraneConstraint>& record) {
  return rest_sides(record).determinant() / 2;
}

double longest_side(const ConstraintRecord<MembraneConstraint>& record) {
  const Eigen::Matrix2d sides = rest_sides(record);
  return std::max({sides.col(0).norm(), sides.col(1).norm(), (sides.col(0) - sides.col(1)).norm()});
}

void set_rest_area(ConstraintSlots<MembraneConstraint>& slots, Index triangle, float area) {
  const ConstraintRecord<MembraneConstraint> record = slots.record(triangle);
  const double shrinkage = rest_area(record) / area;
  const auto scale = [&](int parameter, double factor) {
    slots.set_parameter(triangle, static_cast<MembraneConstraint::Parameter>(parameter),
                        static_cast<float>(record.parameters[parameter] * factor));
  };
  for (int i = 0; i < 4; ++i) {
    scale(MembraneConstraint::kInverseShape + i, std::sqrt(shrinkage));
  }
  scale(MembraneConstraint::kStiffness, 1 / shrinkage);
}

void set_stiffness(ConstraintSlots<MembraneConstraint>& slots, Index triangle, const Body& sheet,
                   float stiffness) {
  const double area = rest_area(slots.record(triangle));
  slots.set_parameter(triangle, MembraneConstraint::kStiffness,
                      static_cast<float>(shear_stiffness(sheet, stiffness) * area));
}

}  // namespace pbdsurg
