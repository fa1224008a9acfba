// SPDX-License-Identifier: Apache-2.0
#include "tests/support/bending_lanes.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "pbdsurg/base/random.h"
#include "pbdsurg/constraints/bending.h"

#include "tests/support/bending_hinge.h"
#include "tests/support/catch.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::Hinge;
using testing::kPi;
using testing::random_point;
using testing::turn_of;

}  // namespace

TEST_CASE("bending constraint: lanes agree with single and double precision", "[property]") {
  const std::uint64_t seed = GENERATE(range(1, 20));
  testing::HingeSamples samples, start;
  for (int lane = 0; lane < testing::kHingeLanes; ++lane) {
    testing::HingeSample& sample = samples[lane];
    // lanes side by side: flat, folded, without area, and a random one
    const std::uint64_t stream = 100 * seed + static_cast<std::uint64_t>(lane);
    const Hinge<float> hinge(1e-3, lane == 0 ? 0 : lane == 1 ? kPi : 4 * random_unit(stream, 1));
    std::copy(std::begin(hinge.x), std::end(hinge.x), sample.x.begin());
    if (lane == 2) {
      sample.x[3] = sample.x[0];
    }
    start[lane] = sample;
    for (int i = 0; i < 4; ++i) {
      sample.w[i] = static_cast<float>(1e6 * (i == 1 ? 0 : random_unit(stream, 2, i)));
      const Vec3<double> shake = random_point(1e-5, stream, 10 + i);
      start[lane].x[i] =
          sample.x[i] - Vec3<float>{static_cast<float>(shake.x), static_cast<float>(shake.y),
                                    static_cast<float>(shake.z)};
    }
    sample.parameters = {static_cast<float>(turn_of(4 * random_unit(stream, 3) - 2)), 1e6F, 1e-3F};
    sample.multiplier = 1e-9F;
  }

  const auto project = [&](const testing::HingeSample& sample, const testing::HingeSample& from,
                           auto zero) {
    using Scalar = decltype(zero);
    const auto convert = [](const Vec3<float>& v) { return Vec3<Scalar>{v.x, v.y, v.z}; };
    Vec3<Scalar> x[4];
    Scalar w[4];
    Damped<Scalar, 4> damping;
    for (int i = 0; i < 4; ++i) {
      x[i] = convert(sample.x[i]);
      damping.start[i] = convert(from.x[i]);
      w[i] = sample.w[i];
    }
    const Scalar parameters[] = {sample.parameters[0], sample.parameters[1], sample.parameters[2]};
    Scalar multiplier[] = {sample.multiplier};
    BendingConstraint::project<ProjectionMode::compliance>(
        x, w, parameters, Substep<Scalar>{Scalar(1e3), Scalar(1e6)}, multiplier, damping);
    testing::HingeSample result = sample;
    for (int i = 0; i < 4; ++i) {
      result.x[i] = {static_cast<float>(x[i].x), static_cast<float>(x[i].y),
                     static_cast<float>(x[i].z)};
    }
    result.multiplier = static_cast<float>(multiplier[0]);
    return result;
  };

  testing::HingeSamples strict = samples, fast = samples;
  testing::project_lanes_strict(strict, start);
  testing::project_lanes_fast(fast, start);
  for (int lane = 0; lane < testing::kHingeLanes; ++lane) {
    INFO("lane " << lane);
    const testing::HingeSample single = project(samples[lane], start[lane], 0.0F);
    const testing::HingeSample exact = project(samples[lane], start[lane], 0.0);
    CHECK(strict[lane].multiplier == single.multiplier);
    CHECK(fast[lane].multiplier == Approx(single.multiplier).epsilon(1e-4));
    CHECK(single.multiplier == Approx(exact.multiplier).epsilon(1e-4));
    for (int i = 0; i < 4; ++i) {
      const auto differ = [&](const testing::HingeSample& a, const testing::HingeSample& b) {
        const Vec3<float> d = a.x[i] - b.x[i];
        return std::sqrt(dot(d, d));
      };
      CHECK(differ(strict[lane], single) == 0);
      CHECK(differ(fast[lane], single) < 1e-7);
      CHECK(differ(single, exact) < 1e-7);
      if (lane == 2) {
        CHECK(differ(fast[lane], samples[lane]) == 0);
      }
    }
  }
}

}  // namespace pbdsurg
