// SPDX-License-Identifier: Apache-2.0
// Compiled once for each way of rounding: see CMakeLists.txt.
#include "tests/support/bending_lanes.h"

#include "lib/solver/host/lanes.h"

namespace pbdsurg::testing {
namespace {

using PBDSURG_LANES_NAMESPACE::Lanes;

// A number of each sample, in a register.
template <class Number>
Lanes gather(const HingeSamples& samples, const Number& number) {
  alignas(64) float numbers[kHingeLanes];
  for (int lane = 0; lane < kHingeLanes; ++lane) {
    numbers[lane] = number(samples[lane]);
  }
  return PBDSURG_LANES_NAMESPACE::load_lanes(numbers);
}

template <class Number>
void scatter(Lanes lanes, HingeSamples& samples, const Number& number) {
  alignas(64) float numbers[kHingeLanes];
  PBDSURG_LANES_NAMESPACE::store_lanes(lanes, numbers);
  for (int lane = 0; lane < kHingeLanes; ++lane) {
    number(samples[lane]) = numbers[lane];
  }
}

Vec3<Lanes> gather_vertex(const HingeSamples& samples, int i) {
  return {gather(samples, [&](const HingeSample& s) { return s.x[i].x; }),
          gather(samples, [&](const HingeSample& s) { return s.x[i].y; }),
          gather(samples, [&](const HingeSample& s) { return s.x[i].z; })};
}

}  // namespace

void PBDSURG_TEST_FUNCTION(HingeSamples& samples, const HingeSamples& start) {
  Vec3<Lanes> x[4];
  Lanes w[4], parameters[BendingConstraint::kParameterCount];
  Damped<Lanes, 4> damping;
  for (int i = 0; i < 4; ++i) {
    x[i] = gather_vertex(samples, i);
    damping.start[i] = gather_vertex(start, i);
    w[i] = gather(samples, [&](const HingeSample& s) { return s.w[i]; });
  }
  for (int p = 0; p < BendingConstraint::kParameterCount; ++p) {
    parameters[p] = gather(samples, [&](const HingeSample& s) { return s.parameters[p]; });
  }
  Lanes multiplier[] = {gather(samples, [](const HingeSample& s) { return s.multiplier; })};
  BendingConstraint::project<ProjectionMode::compliance>(
      x, w, parameters, Substep<Lanes>{Lanes(1e3), Lanes(1e6)}, multiplier, damping);
  for (int i = 0; i < 4; ++i) {
    scatter(x[i].x, samples, [&](HingeSample& s) -> float& { return s.x[i].x; });
    scatter(x[i].y, samples, [&](HingeSample& s) -> float& { return s.x[i].y; });
    scatter(x[i].z, samples, [&](HingeSample& s) -> float& { return s.x[i].z; });
  }
  scatter(multiplier[0], samples, [](HingeSample& s) -> float& { return s.multiplier; });
}

}  // namespace pbdsurg::testing
