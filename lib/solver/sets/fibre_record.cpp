// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/sets/fibre_record.h"

#include "lib/solver/sets/neo_hookean_record.h"

namespace pbdsurg {

Numbers<FibreConstraint> fibre_numbers(const Numbers<NeoHookeanConstraint>& solid,
                                       const Fibre& fibre) {
  const Eigen::Matrix3d inverse = inverse_shape({{}, solid});
  const Eigen::Vector3d shares = inverse * fibre.direction.cast<double>();
  Numbers<FibreConstraint> numbers;
  for (int k = 0; k < 3; ++k) {
    numbers[FibreConstraint::kShares + k] = static_cast<float>(shares[k]);
  }
  numbers[FibreConstraint::kStiffness] =
      static_cast<float>(double{fibre.stiffness} / (6 * inverse.determinant()));
  return numbers;
}

}  // namespace pbdsurg
