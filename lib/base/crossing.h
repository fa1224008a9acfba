// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Whether two segments, or a point and a triangle, come through each other while their corners go
/// straight and evenly, on a CPU or a device. Four corners are in a plane at the roots of a cubic
/// (Provot, "Collision and self-collision handling in cloth model dedicated to design garments",
/// 1997, section 3). In double precision, with margins wider than its rounding: what comes through
/// beside a margin is seen by a neighbour.

#include <cmath>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/vec3.h"

namespace pbdsurg {

/// A corner at the start and at the end, m.
struct CornerWay {
  Vec3<double> start, end;

  PBDSURG_HOST_DEVICE CornerWay(const Vec3<double>& from, const Vec3<double>& to)
      : start(from), end(to) {}
  PBDSURG_HOST_DEVICE CornerWay(const Vec3<float>& from, const Vec3<float>& to)
      : start{from.x, from.y, from.z}, end{to.x, to.y, to.z} {}

  [[nodiscard]] PBDSURG_HOST_DEVICE Vec3<double> at(double share) const {
    return start + share * (end - start);
  }
};

namespace crossing {

inline constexpr double kMargin = 1e-4;  // share of a side
inline constexpr int kHalvings = 40;

PBDSURG_HOST_DEVICE inline double product(const Vec3<double>& a, const Vec3<double>& b,
                                          const Vec3<double>& c) {
  return dot(a, cross(b, c));
}

PBDSURG_HOST_DEVICE inline CornerWay between(const CornerWay& from, const CornerWay& to) {
  return {to.start - from.start, to.end - from.end};
}

// The triple product of three ways: a cubic of the share of their ways.
struct Volume {
  double c[4];

  PBDSURG_HOST_DEVICE Volume(const CornerWay& u, const CornerWay& v, const CornerWay& w) {
    const Vec3<double>&u0 = u.start, &v0 = v.start, &w0 = w.start;
    const Vec3<double> u1 = u.end - u0, v1 = v.end - v0, w1 = w.end - w0;
    c[0] = product(u0, v0, w0);
    c[1] = product(u1, v0, w0) + product(u0, v1, w0) + product(u0, v0, w1);
    c[2] = product(u1, v1, w0) + product(u1, v0, w1) + product(u0, v1, w1);
    c[3] = product(u1, v1, w1);
  }
  [[nodiscard]] PBDSURG_HOST_DEVICE double at(double share) const {
    return c[0] + share * (c[1] + share * (c[2] + share * c[3]));
  }
};

// Ends of the parts of [0, 1] in which a cubic only grows or only falls.
struct Parts {
  double ends[4] = {0, 1, 1, 1};
  int count = 1;

  PBDSURG_HOST_DEVICE explicit Parts(const Volume& volume) {
    using std::sqrt;
    const double a = 3 * volume.c[3], b = volume.c[2], c = volume.c[1];  // slope a s^2 + 2 b s + c
    const double square = b * b - a * c;
    if (!(square > 0)) {
      return;
    }
    const double sum = b < 0 ? -b + sqrt(square) : -b - sqrt(square);
    const double one = a != 0 ? sum / a : -1, other = sum != 0 ? c / sum : -1;
    const double first = one < other ? one : other, second = one < other ? other : one;
    add(first);
    add(second);
  }

 private:
  PBDSURG_HOST_DEVICE void add(double turn) {
    if (turn > ends[count - 1] && turn < 1) {
      ends[count++] = turn;
      ends[count] = 1;
    }
  }
};

// Whether there is a share in ]0, 1] at which a cubic changes its sign and `is_met` says so.
template <class IsMet>
PBDSURG_HOST_DEVICE bool any_root(const Volume& volume, const IsMet& is_met) {
  const Parts parts(volume);
  for (int k = 0; k < parts.count; ++k) {
    double low = parts.ends[k], high = parts.ends[k + 1];
    const bool is_positive = volume.at(low) > 0;
    if (is_positive == (volume.at(high) > 0) || (k == 0 && volume.c[0] == 0)) {
      continue;
    }
    for (int halving = 0; halving < kHalvings; ++halving) {
      const double middle = 0.5 * (low + high);
      if ((volume.at(middle) > 0) == is_positive) {
        low = middle;
      } else {
        high = middle;
      }
    }
    if (is_met(high)) {
      return true;
    }
  }
  return false;
}

}  // namespace crossing

/// Whether segments from a to b and from c to d come through each other.
PBDSURG_HOST_DEVICE inline bool segments_cross(const CornerWay& a, const CornerWay& b,
                                               const CornerWay& c, const CornerWay& d) {
  using namespace crossing;
  const CornerWay first = between(a, b), second = between(c, d), apart = between(a, c);
  return any_root(Volume(first, second, apart), [&](double share) {
    const Vec3<double> u = first.at(share), v = second.at(share), w = apart.at(share);
    const Vec3<double> normal = cross(u, v);
    const double square = dot(normal, normal);
    const auto is_within = [&](double product) {
      return product >= -kMargin * square && product <= (1 + kMargin) * square;
    };
    return square > 0 && is_within(product(w, v, normal)) && is_within(product(w, u, normal));
  });
}

/// Whether a point comes through the triangle of a, b and c.
PBDSURG_HOST_DEVICE inline bool point_crosses(const CornerWay& point, const CornerWay& a,
                                              const CornerWay& b, const CornerWay& c) {
  using namespace crossing;
  const CornerWay first = between(a, b), second = between(a, c), to = between(a, point);
  return any_root(Volume(first, second, to), [&](double share) {
    const Vec3<double> u = first.at(share), v = second.at(share), w = to.at(share);
    const Vec3<double> normal = cross(u, v);
    const double square = dot(normal, normal);
    const double along_first = product(w, v, normal), along_second = product(u, w, normal);
    const double least = -kMargin * square;
    return square > 0 && along_first >= least && along_second >= least &&
           along_first + along_second <= (1 + kMargin) * square;
  });
}

}  // namespace pbdsurg
