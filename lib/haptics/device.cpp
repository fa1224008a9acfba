// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/haptics/device.h"

namespace pbdsurg {

Activation activation_of(const Pedals& pedals) noexcept {
  if (pedals.cut == pedals.coagulation) {
    return Activation::none;
  }
  return pedals.cut ? Activation::cut : Activation::coagulation;
}

}  // namespace pbdsurg
