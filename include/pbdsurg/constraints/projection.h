// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The projection shared by every constraint: how far one Gauss-Seidel visit moves the multiplier.
///
/// A constraint C(x) with gradient g_i at vertex i moves its vertices by  dx_i = w_i g_i dlambda.
/// Two modes use the same line:
///
///   fraction    dlambda = -k C / m                       position-based dynamics (Mueller et al.
///   2007,
///                                                        "Position Based Dynamics", section 3.3)
///   compliance  dlambda = -(C + a lambda) / (m + a)      XPBD (Macklin, Mueller, Chentanez 2016,
///                                                        "XPBD", eq. 18)
///
/// with m = sum_i w_i |g_i|^2 and a = compliance / dt^2. The force of a constraint is g_i lambda /
/// dt^2.

#include <cstdint>

#include "pbdsurg/core/host_device.h"

namespace pbdsurg {

/// How the stiffness number of a constraint is read.
enum class ProjectionMode : std::uint8_t {
  fraction,    ///< share of the violation removed by one projection, in (0, 1]: the paper's mode
  compliance,  ///< inverse stiffness; behaviour does not depend on iterations or time step
};

/// Change of the multiplier in one projection.
///
/// @param value       C, the violation
/// @param mobility    m = sum of w |g|^2; zero when no vertex can move
/// @param stiffness   k in fraction mode, a = compliance / dt^2 in compliance mode
/// @param multiplier  lambda before this projection; read in compliance mode only
template <ProjectionMode kMode, class Scalar>
PBDSURG_HOST_DEVICE constexpr Scalar multiplier_change(Scalar value, Scalar mobility,
                                                       Scalar stiffness, Scalar multiplier) {
  // Exact zero only: any other threshold would depend on the unit and the size of the tissue.
  if (!(mobility > Scalar(0))) {
    return Scalar(0);
  }
  if constexpr (kMode == ProjectionMode::fraction) {
    return -stiffness * value / mobility;
  } else {
    return -(value + stiffness * multiplier) / (mobility + stiffness);
  }
}

}  // namespace pbdsurg
