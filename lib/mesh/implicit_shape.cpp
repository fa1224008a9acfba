// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/mesh/implicit_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"

#include "lib/base/describe.h"

namespace pbdsurg {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;
using Eigen::Vector4d;

// Shapes may change a little slower than a distance, so a box grows by more than the value does.
constexpr double kBoxSlack = 1.25;

void require_positive(const char* what, double value) {
  if (!(value > 0) || !std::isfinite(value)) {
    throw InvalidArgument(std::string(what) + " is " + describe(value) +
                          " m; it must be positive and finite");
  }
}

void require_finite(const char* what, const Vector3d& point) {
  if (!point.allFinite()) {
    throw InvalidArgument(std::string(what) + " is " + describe(point) + "; it must be finite");
  }
}

void require_blend_radius(double blend_radius) {
  if (!(blend_radius >= 0) || !std::isfinite(blend_radius)) {
    throw InvalidArgument("the blend radius is " + describe(blend_radius) +
                          " m; it must be zero or positive, and finite");
  }
}

AlignedBox3d grown(AlignedBox3d box, double distance) {
  box.min().array() -= distance;
  box.max().array() += distance;
  return box;
}

AlignedBox3d ball_box(const Vector3d& center, double radius) {
  return grown(AlignedBox3d(center), radius);
}

// Quadratic smooth minimum: the smaller value, lowered by at most a quarter of the radius where the
// two are close.
double smooth_min(double a, double b, double radius) {
  const double overlap = std::max(radius - std::abs(a - b), 0.0);
  const double lowering = overlap > 0 ? 0.25 * overlap * overlap / radius : 0.0;
  return std::min(a, b) - lowering;
}

double smooth_max(double a, double b, double radius) {
  return -smooth_min(-a, -b, radius);
}

// The nearest point of the surface is e_i^2 p_i / (t + e_i^2) along each axis, where t makes it lie
// on the surface: S(t) = sum (e_i p_i / (t + e_i^2))^2 = 1. The distance follows from t, which is
// negative inside. 1 / sqrt(S) is concave and almost straight, so Newton's method on it rises to
// the root from any start of S >= 1 in a few steps (More and Sorensen 1983, "Computing a trust
// region step").
double ellipsoid_distance(const Vector3d& point, const Vector3d& radii) {
  const Vector3d squared = radii.cwiseAbs2();
  // Off the planes of symmetry, on which the smallest term would vanish with its denominator. A
  // distance of a point moved by this little is as exact.
  const Vector3d p = point.cwiseAbs().cwiseMax(1e-7 * radii.minCoeff());
  double t = (radii.cwiseProduct(p) - squared).maxCoeff();
  for (int step = 0; step < 50; ++step) {
    const Vector3d terms = radii.cwiseProduct(p).cwiseQuotient((squared.array() + t).matrix());
    const double sum = terms.squaredNorm();
    const double slope = -2 * terms.cwiseAbs2().cwiseQuotient((squared.array() + t).matrix()).sum();
    const double change = 2 * sum * (1 - std::sqrt(sum)) / slope;
    t += change;
    if (!(change > 1e-14 * squared.maxCoeff())) {
      break;
    }
  }
  return t * p.cwiseQuotient((squared.array() + t).matrix()).norm();
}

// The hull of two spheres. In the half plane (t along the axis, y away from it) the slanted side
// has the normal (sine, cosine); points before or behind it belong to one of the spheres.
class RoundCone {
 public:
  RoundCone(const Vector3d& from, double from_radius, const Vector3d& to, double to_radius)
      : from_(from), to_(to), from_radius_(from_radius), to_radius_(to_radius) {
    length_ = (to - from).norm();
    if (length_ > std::abs(from_radius - to_radius)) {
      axis_ = (to - from) / length_;
      sine_ = (from_radius - to_radius) / length_;
      cosine_ = std::sqrt(1 - sine_ * sine_);
    } else {
      // one sphere holds the other: keep the larger
      if (to_radius > from_radius) {
        from_ = to;
        from_radius_ = to_radius;
      }
      to_ = from_;
      to_radius_ = from_radius_;
      length_ = 0;
    }
  }

  [[nodiscard]] double distance(const Vector3d& point) const {
    const Vector3d d = point - from_;
    const double t = d.dot(axis_);
    const double y = std::sqrt(std::max(d.squaredNorm() - t * t, 0.0));
    const double along = cosine_ * t - sine_ * y;
    if (!(along > 0)) {
      return d.norm() - from_radius_;
    }
    if (along >= cosine_ * length_) {
      return (point - to_).norm() - to_radius_;
    }
    return sine_ * t + cosine_ * y - from_radius_;
  }

  [[nodiscard]] AlignedBox3d bounds() const {
    return ball_box(from_, from_radius_).merged(ball_box(to_, to_radius_));
  }

 private:
  Vector3d from_, to_;
  Vector3d axis_ = Vector3d::Zero();
  double from_radius_, to_radius_;
  double length_;
  double sine_ = 0, cosine_ = 0;
};

struct Ball {
  Vector3d center;
  double radius;

  explicit Ball(const AlignedBox3d& box)
      : center(box.center()), radius(0.5 * box.diagonal().norm()) {}
  Ball(const Vector3d& a, double a_radius, const Vector3d& b, double b_radius)
      : center(0.5 * (a + b)), radius(0.5 * (b - a).norm() + std::max(a_radius, b_radius)) {}

  // Whether every point of the ball is at least `distance` away.
  [[nodiscard]] bool is_beyond(const Vector3d& point, double distance) const {
    const double reach = distance + radius;
    return reach <= 0 || (point - center).squaredNorm() >= reach * reach;
  }
};

// A union of many round cones in order along a path.
class Tube {
 public:
  Tube(std::span<const Vector4d> knots, int pieces_per_span) : pieces_per_span_(pieces_per_span) {
    const int last = static_cast<int>(knots.size()) - 1;
    Vector4d start = knots[0];
    for (int span = 0; span < last; ++span) {
      // the ends are continued by reflection
      const Vector4d& b = knots[span];
      const Vector4d& c = knots[span + 1];
      const Vector4d a = span > 0 ? knots[span - 1] : Vector4d(2 * b - c);
      const Vector4d d = span + 1 < last ? knots[span + 2] : Vector4d(2 * c - b);
      AlignedBox3d span_box;
      for (int piece = 1; piece <= pieces_per_span; ++piece) {
        const double t = static_cast<double>(piece) / pieces_per_span;
        Vector4d end = 0.5 * (2 * b + t * (c - a) + t * t * (2 * a - 5 * b + 4 * c - d) +
                              t * t * t * (3 * b - a - 3 * c + d));
        // overshoot of the spline must not turn a narrowing tube inside out
        end.w() = std::max(end.w(), 0.5 * std::min(b.w(), c.w()));
        pieces_.push_back(RoundCone(start.head<3>(), start.w(), end.head<3>(), end.w()));
        piece_balls_.push_back(Ball(start.head<3>(), start.w(), end.head<3>(), end.w()));
        span_box.extend(pieces_.back().bounds());
        start = end;
      }
      span_balls_.push_back(Ball(span_box));
      bounds_.extend(span_box);
    }
  }

  [[nodiscard]] double distance(const Vector3d& point) const {
    // the nearest span first, so that most others are beyond its distance
    std::size_t nearest = 0;
    double nearest_distance = std::numeric_limits<double>::infinity();
    for (std::size_t span = 0; span < span_balls_.size(); ++span) {
      const double d = (point - span_balls_[span].center).squaredNorm();
      if (d < nearest_distance) {
        nearest_distance = d;
        nearest = span;
      }
    }
    double best = std::numeric_limits<double>::infinity();
    lower_by_span(nearest, point, best);
    for (std::size_t span = 0; span < span_balls_.size(); ++span) {
      if (span != nearest && !span_balls_[span].is_beyond(point, best)) {
        lower_by_span(span, point, best);
      }
    }
    return best;
  }

  [[nodiscard]] const AlignedBox3d& bounds() const { return bounds_; }

 private:
  void lower_by_span(std::size_t span, const Vector3d& point, double& best) const {
    const std::size_t first = span * pieces_per_span_;
    const std::size_t middle = first + pieces_per_span_ / 2;
    best = std::min(best, pieces_[middle].distance(point));
    for (std::size_t i = first; i < first + pieces_per_span_; ++i) {
      if (i != middle && !piece_balls_[i].is_beyond(point, best)) {
        best = std::min(best, pieces_[i].distance(point));
      }
    }
  }

  std::size_t pieces_per_span_;
  std::vector<RoundCone> pieces_;
  std::vector<Ball> piece_balls_;
  std::vector<Ball> span_balls_;
  AlignedBox3d bounds_;
};

}  // namespace

ImplicitShape::ImplicitShape(Value value, const AlignedBox3d& bounds, ClosestPoint closest_point) {
  if (!value) {
    throw InvalidArgument("an implicit shape needs a value function");
  }
  if (!(bounds.min().array() <= bounds.max().array()).all()) {
    throw InvalidArgument("the box of an implicit shape runs from " + describe(bounds.min()) +
                          " to " + describe(bounds.max()) + "; it must not be empty");
  }
  definition_ = std::make_shared<const Definition>(
      Definition{std::move(value), bounds, std::move(closest_point)});
}

Vector3d ImplicitShape::project(const Vector3d& point, double reach) const {
  Vector3d target = point;
  if (definition_->closest_point) {
    target = definition_->closest_point(point);
  } else {
    // four values at the corners of a small tetrahedron give a second-order gradient
    static const Vector3d kCorners[] = {{1, -1, -1}, {-1, -1, 1}, {-1, 1, -1}, {1, 1, 1}};
    const ImplicitShape& value = *this;
    const double step = 0.04 * reach;
    Vector3d gradient = Vector3d::Zero();
    for (const Vector3d& corner : kCorners) {
      gradient += value(point + step * corner) * corner;
    }
    gradient /= 4 * step;
    const double slope = gradient.squaredNorm();
    if (!(slope > 0)) {
      return point;  // at a ridge of the distance, where no way is nearer than another
    }
    target -= value(target) / slope * gradient;
    target -= value(target) / slope * gradient;
  }
  return (target - point).squaredNorm() <= reach * reach ? target : point;
}

ImplicitShape sphere_shape(const Vector3d& center, double radius) {
  require_finite("the centre of a sphere", center);
  require_positive("the radius of a sphere", radius);
  return ImplicitShape([=](const Vector3d& p) { return (p - center).norm() - radius; },
                       ball_box(center, radius));
}

ImplicitShape capsule_shape(const Vector3d& from, const Vector3d& to, double radius) {
  return round_cone_shape(from, radius, to, radius);
}

ImplicitShape round_cone_shape(const Vector3d& from, double from_radius, const Vector3d& to,
                               double to_radius) {
  require_finite("an end of a round cone", from);
  require_finite("an end of a round cone", to);
  require_positive("a radius of a round cone", from_radius);
  require_positive("a radius of a round cone", to_radius);
  const RoundCone cone(from, from_radius, to, to_radius);
  return ImplicitShape([cone](const Vector3d& p) { return cone.distance(p); }, cone.bounds());
}

ImplicitShape tube_shape(std::span<const Vector4d> knots, int pieces_per_span) {
  if (knots.size() < 2 || pieces_per_span < 1 || pieces_per_span > 1000) {
    throw InvalidArgument("a tube of " + std::to_string(knots.size()) + " knots with " +
                          std::to_string(pieces_per_span) +
                          " pieces a span; it needs two knots or more and 1 to 1000 pieces");
  }
  for (const Vector4d& knot : knots) {
    require_finite("a knot of a tube", knot.head<3>());
    require_positive("a radius of a tube", knot.w());
  }
  const auto tube = std::make_shared<const Tube>(knots, pieces_per_span);
  return ImplicitShape([tube](const Vector3d& p) { return tube->distance(p); }, tube->bounds());
}

ImplicitShape ellipsoid_shape(const Vector3d& center, const Vector3d& radii) {
  require_finite("the centre of an ellipsoid", center);
  for (const double radius : radii) {
    require_positive("a radius of an ellipsoid", radius);
  }
  const auto value = [=](const Vector3d& p) { return ellipsoid_distance(p - center, radii); };
  return ImplicitShape(value, AlignedBox3d(center - radii, center + radii));
}

ImplicitShape rounded_box_shape(const Vector3d& center, const Vector3d& half_size,
                                double corner_radius) {
  require_finite("the centre of a box", center);
  for (const double half : half_size) {
    require_positive("a half size of a box", half);
  }
  if (!(corner_radius >= 0 && corner_radius <= half_size.minCoeff())) {
    throw InvalidArgument("the corner radius of a box is " + describe(corner_radius) +
                          " m; it must be in [0, " + describe(half_size.minCoeff()) + "]");
  }
  const Vector3d core = half_size.array() - corner_radius;
  const auto value = [=](const Vector3d& p) {
    const Vector3d beyond = (p - center).cwiseAbs() - core;
    return beyond.cwiseMax(0.0).norm() + std::min(beyond.maxCoeff(), 0.0) - corner_radius;
  };
  return ImplicitShape(value, AlignedBox3d(center - half_size, center + half_size));
}

ImplicitShape half_space_shape(const Vector3d& point, const Vector3d& normal) {
  require_finite("the point of a half space", point);
  require_positive("the length of a normal", normal.norm());
  const Vector3d unit = normal.normalized();
  const Vector3d infinite = Vector3d::Constant(std::numeric_limits<double>::infinity());
  return ImplicitShape([=](const Vector3d& p) { return unit.dot(p - point); },
                       AlignedBox3d(-infinite, infinite));
}

ImplicitShape smooth_union(const ImplicitShape& a, const ImplicitShape& b, double blend_radius) {
  require_blend_radius(blend_radius);
  return ImplicitShape([=](const Vector3d& p) { return smooth_min(a(p), b(p), blend_radius); },
                       grown(a.bounds().merged(b.bounds()), kBoxSlack * blend_radius / 4));
}

ImplicitShape smooth_intersection(const ImplicitShape& a, const ImplicitShape& b,
                                  double blend_radius) {
  require_blend_radius(blend_radius);
  const AlignedBox3d common = a.bounds().intersection(b.bounds());
  if (common.isEmpty()) {
    throw InvalidArgument("the intersection of two shapes is empty: their boxes are apart");
  }
  return ImplicitShape([=](const Vector3d& p) { return smooth_max(a(p), b(p), blend_radius); },
                       common);
}

ImplicitShape smooth_difference(const ImplicitShape& a, const ImplicitShape& b,
                                double blend_radius) {
  require_blend_radius(blend_radius);
  return ImplicitShape([=](const Vector3d& p) { return smooth_max(a(p), -b(p), blend_radius); },
                       a.bounds());
}

ImplicitShape offset_shape(const ImplicitShape& shape, double distance) {
  if (!std::isfinite(distance)) {
    throw InvalidArgument("an offset is " + describe(distance) + " m; it must be finite");
  }
  return ImplicitShape([=](const Vector3d& p) { return shape(p) - distance; },
                       grown(shape.bounds(), kBoxSlack * std::max(distance, 0.0)));
}

ImplicitShape shell_shape(const ImplicitShape& shape, double thickness) {
  require_positive("the thickness of a shell", thickness);
  const auto value = [=](const Vector3d& p) {
    const double outer = shape(p);
    return std::max(outer, -(outer + thickness));
  };
  return ImplicitShape(value, shape.bounds());
}

}  // namespace pbdsurg
