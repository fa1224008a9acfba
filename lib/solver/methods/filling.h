// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What fills a closed surface under one pressure, on a host or a device:
/// pbdsurg/surgery/lumen.h has the equations.

#include <cmath>
#include <cstdint>
#include <span>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"

namespace pbdsurg {

class Tissue;

/// Of a copy, after a substep: as LumenState.
struct FillingState {
  double amount = 0;   ///< m^3, at ambient pressure
  float pressure = 0;  ///< Pa, above ambient
};

/// Within a substep.
struct FillingSubstep {
  double most = 0;       ///< m^3, what there would be at its end without pressure
  double drain = 0;      ///< m^3/Pa, what less by pressure
  float pressure = 0;    ///< Pa, the last estimate
  float multiplier = 0;  ///< Pa
};

/// How contents answer to pressure, and flow.
struct FillingLaw {
  float density;             ///< kg/m^3
  float ambient_pressure;    ///< Pa
  float discharge;           ///< of orifices
  float inflow;              ///< m^3/s
  float leak;                ///< m^2
  float reservoir_area;      ///< m^2
  float reservoir_pressure;  ///< Pa, above ambient
  bool is_gas;

  /// The value of the constraint, m^3, and its compliance, m^3/Pa: the multiplier is the pressure.
  struct Constraint {
    float value, compliance;
  };

  /// m^3, of contents that have a pressure in a volume.
  [[nodiscard]] PBDSURG_HOST_DEVICE double amount_in(double volume, float pressure) const {
    return volume * (is_gas ? 1 + pressure / double{ambient_pressure} : 1);
  }

  /// @param holes  m^2, of the wall
  /// @param h      s, of the substep
  [[nodiscard]] PBDSURG_HOST_DEVICE FillingSubstep begin(const FillingState& start, double holes,
                                                         double h) const {
    const double out = conductance(leak + holes, start.pressure);
    const double in = conductance(reservoir_area, start.pressure - reservoir_pressure);
    const double most = start.amount + h * (inflow + in * reservoir_pressure);
    return {most > 0 ? most : 0, h * (out + in), start.pressure, 0};
  }

  /// V (P + p) = P (most - drain p), P the ambient pressure, at the last p; of a liquid P is
  /// endless.
  /// @param volume  m^3
  [[nodiscard]] PBDSURG_HOST_DEVICE Constraint constraint(const FillingSubstep& now,
                                                          double volume) const {
    const double ambient = ambient_pressure;
    const double thinnest = (kThinnest - 1) * ambient;
    const double absolute = ambient + (now.pressure > thinnest ? double{now.pressure} : thinnest);
    const double ratio = is_gas ? ambient / absolute : 1;
    const double given = is_gas ? (volume > 0 ? volume : 0) / absolute : 0;
    return {static_cast<float>(ratio * (volume - now.most)),
            static_cast<float>(given + ratio * now.drain)};
  }

  [[nodiscard]] PBDSURG_HOST_DEVICE static FillingState end(const FillingSubstep& now) {
    const double amount = now.most - now.drain * now.pressure;
    return {amount > 0 ? amount : 0, now.pressure};
  }

 private:
  /// Pa: where flow through an orifice becomes linear, so that it has a slope at rest.
  static constexpr double kLaminar = 1;
  /// Of ambient pressure: what a gas is linearised at is not thinner.
  static constexpr double kThinnest = 0.1;

  /// m^3/(s Pa), of an orifice at a difference of pressure: a chord of its law, through zero. The
  /// law with a laminar end is that of Simscape's block "Orifice (IL)".
  [[nodiscard]] PBDSURG_HOST_DEVICE double conductance(double area, double difference) const {
    using std::sqrt;
    const double least = difference * difference + kLaminar * kLaminar;
    return double{discharge} * area * sqrt(2 / double{density}) / sqrt(sqrt(least));
  }
};

/// m^2, a third of a triangle's area, along its normal: how volume changes with a corner.
PBDSURG_HOST_DEVICE inline Vec3<float> third_of_area(const Vec3<double>& a, const Vec3<double>& b,
                                                     const Vec3<double>& c) {
  const Vec3<double> normal = cross(b - a, c - a);
  return {static_cast<float>(normal.x / 6), static_cast<float>(normal.y / 6),
          static_cast<float>(normal.z / 6)};
}

/// m^3, six times the volume between a triangle and an origin.
PBDSURG_HOST_DEVICE inline double six_volumes(const Vec3<double>& origin, const Vec3<double>& a,
                                              const Vec3<double>& b, const Vec3<double>& c) {
  return dot(a - origin, cross(b - origin, c - origin));
}

/// A set of custom constraints in the form in which a device projects it: one constraint on the
/// volume within a closed surface, as of the last begin_step() of the set.
class Filling {
 public:
  Filling() = default;
  virtual ~Filling() = default;
  Filling(const Filling&) = delete;
  Filling& operator=(const Filling&) = delete;

  struct Surface {
    std::uint64_t version;                ///< changes with what follows
    std::span<const Index> vertices;      ///< [vertex] of the scene
    std::span<const Triangle> triangles;  ///< by places in `vertices`: of the wall, then caps
    std::span<const Index> hole_ends;     ///< [hole] of triangles that are caps over it
    Index wall_count;                     ///< triangles of the wall
  };
  [[nodiscard]] virtual Surface surface() const = 0;
  [[nodiscard]] virtual FillingLaw law() const = 0;
  [[nodiscard]] virtual FillingState state(Index copy) const = 0;
  /// Whether there are to be contents that give the pressure of the state, in a wall that is new.
  [[nodiscard]] virtual bool is_new(Index copy) const = 0;
  /// @throws InvalidArgument  if the solver is of another tissue than the surface
  virtual void check(const Tissue& tissue) const = 0;
  /// After a step.
  virtual void take(Index copy, const FillingState& state) = 0;
};

}  // namespace pbdsurg
