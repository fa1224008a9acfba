// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/sets/neo_hookean_record.h"

#include <Eigen/LU>
#include <cmath>

namespace pbdsurg {
namespace {

using Record = ConstraintRecord<NeoHookeanConstraint>;

// Pa
double shear_modulus(const Material& material, float stiffness) noexcept {
  return double{stiffness} *
         (material.youngs_modulus / (2 * (1 + double{material.poissons_ratio})));
}

double exact_rest_volume(const Record& record) noexcept {
  return 1 / (6 * inverse_shape(record).determinant());
}

}  // namespace

Eigen::Matrix3d inverse_shape(const Record& record) noexcept {
  Eigen::Matrix3d inverse;
  for (int i = 0; i < 9; ++i) {
    inverse(i / 3, i % 3) = record.parameters[NeoHookeanConstraint::kInverseShape + i];
  }
  return inverse;
}

Record make_neo_hookean(std::span<const Eigen::Vector3d> positions, const Tet& tet,
                        const Tet& places, const Material& material, float stiffness) {
  Eigen::Matrix3d sides;
  for (int k = 0; k < 3; ++k) {
    sides.col(k) = positions[tet[k + 1]] - positions[tet[0]];
  }
  const Eigen::Matrix3d inverse = sides.inverse();
  Record record{places, {}};
  for (int i = 0; i < 9; ++i) {
    record.parameters[NeoHookeanConstraint::kInverseShape + i] =
        static_cast<float>(inverse(i / 3, i % 3));
  }
  record.parameters[NeoHookeanConstraint::kStiffness] =
      static_cast<float>(shear_modulus(material, stiffness) * sides.determinant() / 6);
  record.parameters[NeoHookeanConstraint::kRatio] =
      static_cast<float>(1 / (1 - 2 * double{material.poissons_ratio}));
  record.parameters[NeoHookeanConstraint::kDamping] = material.damping;
  return record;
}

Eigen::Matrix3d rest_sides(const Record& record) {
  return inverse_shape(record).inverse();
}

Record make_part(const Record& whole, const Eigen::Matrix3d& sides, const Tet& places) {
  const Eigen::Matrix3d inverse = sides.inverse() * inverse_shape(whole);
  Record part = whole;
  part.places = places;
  for (int i = 0; i < 9; ++i) {
    part.parameters[NeoHookeanConstraint::kInverseShape + i] =
        static_cast<float>(inverse(i / 3, i % 3));
  }
  part.parameters[NeoHookeanConstraint::kStiffness] =
      static_cast<float>(whole.parameters[NeoHookeanConstraint::kStiffness] * sides.determinant());
  return part;
}

float rest_volume(const Record& record) noexcept {
  return static_cast<float>(exact_rest_volume(record));
}

void set_stiffness(ConstraintSlots<NeoHookeanConstraint>& slots, Index tet,
                   const Material& material, float stiffness) {
  const double volume = exact_rest_volume(slots.record(tet));
  slots.set_parameter(tet, NeoHookeanConstraint::kStiffness,
                      static_cast<float>(shear_modulus(material, stiffness) * volume));
}

void set_rest_volume(ConstraintSlots<NeoHookeanConstraint>& slots, Index tet, float volume) {
  const Record record = slots.record(tet);
  const double shrinkage = exact_rest_volume(record) / volume;
  const auto scale = [&](int parameter, double factor) {
    slots.set_parameter(tet, static_cast<NeoHookeanConstraint::Parameter>(parameter),
                        static_cast<float>(record.parameters[parameter] * factor));
  };
  for (int i = 0; i < 9; ++i) {
    scale(NeoHookeanConstraint::kInverseShape + i, std::cbrt(shrinkage));
  }
  scale(NeoHookeanConstraint::kStiffness, 1 / shrinkage);
}

}  // namespace pbdsurg
