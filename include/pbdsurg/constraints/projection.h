// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The projection shared by every constraint: how far one Gauss-Seidel visit moves the multiplier.
///
/// A constraint C(x) with gradient g_i at vertex i moves its vertices by  dx_i = w_i g_i dlambda.
/// Two modes use the same line:
///
///     fraction    dlambda = -k C / m                position-based dynamics (Mueller et al. 2007,
///                                                   "Position Based Dynamics", section 3.3)
///     compliance  dlambda = -(C + a lambda + c r) / ((1 + c) m + a)
///                                                   XPBD (Macklin, Mueller, Chentanez 2016,
///                                                   "XPBD", eq. 18, and eq. 26 with damping)
///
/// with m = sum_i w_i |g_i|^2, a = compliance / dt^2, r = sum_i g_i . (x_i - x_i at the start of
/// the substep) and c = damping / dt: the damping coefficient is the stiffness times the relaxation
/// time `damping`, which takes the stiffness out of eq. 26's gamma. The force of a constraint is
/// g_i lambda / dt^2.
///
/// A constraint is a struct of kVertexCount, kMultiplierCount, an enum of what one constraint
/// stores, kParameterCount long, and the functions
///
///     value(x, rest)                                                       C
///     move<kMode>(x, w, parameters, substep, multipliers, damping)         one visit
///
/// The latter returns by how much each vertex moves: solvers add that to displacements, which are
/// small and so keep more digits than positions. InPlace adds it to the positions. Only differences
/// of positions matter, so these may be given from any origin.
///
/// in which Scalar is a number or a vector register of numbers, one constraint each. So there is no
/// branch: a constraint that has no direction, or a vertex that is not finite, moves nothing.

#include <cstdint>
#include <limits>
#include <type_traits>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/select.h"
#include "pbdsurg/base/vec3.h"

namespace pbdsurg {

/// How the stiffness number of a constraint is read.
enum class ProjectionMode : std::uint8_t {
  fraction,    ///< share of the violation removed by one projection, in (0, 1]: the paper's mode
  compliance,  ///< inverse stiffness; behaviour does not depend on iterations or time step
};

/// Length of a substep as projections need it.
template <class Scalar>
struct Substep {
  Scalar inverse_dt;          ///< 1/s
  Scalar inverse_dt_squared;  ///< 1/s^2

  /// Number by number.
  bool operator==(const Substep&) const = default;
};

/// A projection that ignores the damping parameter, and reads no more than positions.
struct Undamped {};

/// A projection with damping, in compliance mode.
template <class Scalar, int kVertexCount>
struct Damped {
  Vec3<Scalar> start[std::size_t{kVertexCount}];  ///< m, at the start of the substep
};

/// Whether a projection reads the damping parameter: its last argument is a Damped.
template <class Damping>
inline constexpr bool kIsDamped = !std::is_same_v<Damping, Undamped>;

/// By how much one projection moves the vertices of a constraint.
template <class Scalar, int kVertexCount>
struct Moves {
  Vec3<Scalar> of[std::size_t{kVertexCount}];  ///< m
};

/// A constraint that is projected in place.
template <class Constraint>
struct InPlace {
  /// One projection, with the arguments of Constraint::move().
  /// @param x  m, moved
  template <ProjectionMode kMode, class Scalar, std::size_t kVertices, std::size_t kParameters,
            std::size_t kMultipliers, class Damping = Undamped>
  PBDSURG_HOST_DEVICE static void project(Vec3<Scalar> (&x)[kVertices],
                                          const Scalar (&w)[kVertices],
                                          const Scalar (&parameters)[kParameters],
                                          const Substep<Scalar>& substep,
                                          Scalar (&multipliers)[kMultipliers],
                                          const Damping& damping = {}) {
    const Moves<Scalar, int{kVertices}> moves =
        Constraint::template move<kMode>(x, w, parameters, substep, multipliers, damping);
    for (std::size_t k = 0; k < kVertices; ++k) {
      x[k] = x[k] + moves.of[k];
    }
  }
};

/// A constant and no function: devices cannot call the standard library's.
inline constexpr float kInfinity = std::numeric_limits<float>::infinity();
inline constexpr float kNoNumber = std::numeric_limits<float>::quiet_NaN();  ///< likewise

/// Whether a length or a mobility can be divided by: positive and finite. Exact zero only: any
/// other threshold would depend on the unit and the size of the tissue.
template <class Scalar>
PBDSURG_HOST_DEVICE constexpr auto is_usable(Scalar value) {
  return (value > Scalar(0)) & (value < Scalar(kInfinity));
}

/// Change of the multiplier in one projection.
///
/// @param value       C, the violation
/// @param mobility    m = sum of w |g|^2; zero when no vertex can move
/// @param stiffness   k in fraction mode, a = compliance / dt^2 in compliance mode
/// @param multiplier  lambda before this projection; read in compliance mode only
template <ProjectionMode kMode, class Scalar>
PBDSURG_HOST_DEVICE constexpr Scalar multiplier_change(Scalar value, Scalar mobility,
                                                       Scalar stiffness, Scalar multiplier) {
  const auto can_move = is_usable(mobility);
  if constexpr (kMode == ProjectionMode::fraction) {
    return select(can_move, -stiffness * value / mobility, Scalar(0));
  } else {
    return select(can_move, -(value + stiffness * multiplier) / (mobility + stiffness), Scalar(0));
  }
}

/// The same with damping.
/// @param motion   r, in the unit of C
/// @param damping  c = relaxation time / dt
template <class Scalar>
PBDSURG_HOST_DEVICE constexpr Scalar damped_multiplier_change(Scalar value, Scalar mobility,
                                                              Scalar stiffness, Scalar multiplier,
                                                              Scalar motion, Scalar damping) {
  return select(is_usable(mobility),
                -(value + stiffness * multiplier + damping * motion) /
                    (mobility + damping * mobility + stiffness),
                Scalar(0));
}

}  // namespace pbdsurg
