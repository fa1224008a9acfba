// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/scope.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

namespace cholecystectomy {
namespace {

constexpr float kPi = static_cast<float>(std::numbers::pi);
constexpr float kRound = 1.2F;  // heights of the frame, the diameter of the round picture

void check(bool is_right, const std::string& what, float value, const char* rule) {
  if (!is_right) {
    throw pbdsurg::InvalidArgument("the scope's " + what + " is " + std::to_string(value) +
                                   "; it must be " + rule);
  }
}

ScopeOptions checked(const ScopeOptions& options) {
  const float degree = kPi / 180;
  check(options.angle >= 0 && options.angle <= 80 * degree, "angle", options.angle,
        "from 0 to 80 degrees, in rad");
  check(options.widest_tilt > 0 && options.widest_tilt <= kPi, "widest tilt", options.widest_tilt,
        "in (0, pi]");
  check(options.least_insertion > 0 && std::isfinite(options.least_insertion), "least insertion",
        options.least_insertion, "positive and finite");
  check(options.most_insertion >= options.least_insertion && std::isfinite(options.most_insertion),
        "most insertion", options.most_insertion, "finite and not less than the least");
  check(options.working_distance > 0 && std::isfinite(options.working_distance), "working distance",
        options.working_distance, "positive and finite");
  check(options.field_of_view > 0 && options.field_of_view <= 150 * degree, "field of view",
        options.field_of_view, "up to 150 degrees, in rad");
  check(std::isfinite(options.lamp_offset), "lamp offset", options.lamp_offset, "finite");
  return options;
}

Eigen::Vector3f unit(const Eigen::Vector3f& vector, const char* what) {
  if (!vector.allFinite() || vector.isZero(0)) {
    throw pbdsurg::InvalidArgument(std::string("the scope's ") + what + " has no direction");
  }
  return vector.stableNormalized();
}

Eigen::Vector3f finite(const Eigen::Vector3f& point, const char* what) {
  if (!point.allFinite()) {
    throw pbdsurg::InvalidArgument(std::string("the scope's ") + what + " is not finite");
  }
  return point;
}

// Two level directions and up, right-handed. The first is the world's x, or y where x is upright.
Eigen::Matrix3f level_frame(const Eigen::Vector3f& up) {
  const Eigen::Vector3f guide =
      std::abs(up.x()) < 0.9F ? Eigen::Vector3f::UnitX() : Eigen::Vector3f::UnitY();
  Eigen::Matrix3f frame;
  frame.col(0) = (guide - guide.dot(up) * up).normalized();
  frame.col(1) = up.cross(frame.col(0));
  frame.col(2) = up;
  return frame;
}

float wrapped(float angle) {
  return std::remainder(angle, 2 * kPi);
}

float finite_or_zero(float value) {
  return std::isfinite(value) ? value : 0;
}

Eigen::Matrix3f turn(float angle, const Eigen::Vector3f& axis) {
  return Eigen::AngleAxisf(angle, axis).toRotationMatrix();
}

// The triangle of pivot, tip and target: its angle at the tip is pi - angle. Of the two sides
// there, the other than `side`; 0 where there is none.
double other_side(double line, double angle, double side) {
  const double sine = std::sin(angle);
  const double squared = line * line - side * side * sine * sine;
  return squared > 0 ? std::max(std::sqrt(squared) - side * std::cos(angle), 0.0) : 0;
}

}  // namespace

Scope::Scope(const Eigen::Vector3f& pivot, const Eigen::Vector3f& axis, const ScopeOptions& options)
    : options_(checked(options)),
      pivot_(finite(pivot, "pivot")),
      axis_(unit(axis, "port's axis")),
      level_(level_frame(unit(options.up, "up"))),
      insertion_(options.least_insertion),
      focus_(options.working_distance) {
  aim(axis_);
  level();
}

Scope Scope::looking_at(const Eigen::Vector3f& pivot, const Eigen::Vector3f& target,
                        const ScopeOptions& options) {
  const Eigen::Vector3f way = finite(target, "target") - finite(pivot, "pivot");
  const double line = way.cast<double>().norm();
  if (!(line > options.least_insertion)) {
    throw pbdsurg::InvalidArgument("the scope's target is " + std::to_string(line) +
                                   " m from its pivot; it must be farther than the least " +
                                   "insertion, " + std::to_string(options.least_insertion) + " m");
  }
  Scope scope(pivot, way, options);
  const double insertion =
      std::clamp<double>(other_side(line, options.angle, options.working_distance),
                         options.least_insertion, options.most_insertion);
  const double focus = other_side(line, options.angle, insertion);
  const double sine = std::sin(static_cast<double>(options.angle));
  const auto aside = static_cast<float>(std::asin(focus * sine / line));
  const bool is_above = scope.elevation_ + aside <= kPi / 2;
  scope.elevation_ += is_above ? aside : -aside;
  scope.post_ = is_above ? 0 : kPi;
  scope.insertion_ = static_cast<float>(insertion);
  scope.focus_ = static_cast<float>(focus);
  scope.level();
  return scope;
}

Eigen::Vector3f Scope::direction(float azimuth, float elevation) const {
  const Eigen::Vector3f level_part =
      std::cos(azimuth) * level_.col(0) + std::sin(azimuth) * level_.col(1);
  return std::cos(elevation) * level_part + std::sin(elevation) * level_.col(2);
}

Eigen::Vector3f Scope::shaft() const {
  return direction(azimuth_, elevation_);
}

Eigen::Matrix3f Scope::shaft_frame() const {
  const Eigen::Vector3f ahead = shaft();
  const Eigen::Vector3f above = direction(azimuth_, elevation_ + kPi / 2);
  Eigen::Matrix3f frame;
  frame.col(0) = ahead.cross(above);
  frame.col(1) = above;
  frame.col(2) = -ahead;
  return frame;
}

Eigen::Matrix3f Scope::optics_frame() const {
  return shaft_frame() * turn(post_, Eigen::Vector3f::UnitZ()) *
         turn(-options_.angle, Eigen::Vector3f::UnitX());
}

Eigen::Vector3f Scope::view() const {
  return -optics_frame().col(2);
}

// An upright direction keeps its azimuth.
void Scope::aim(const Eigen::Vector3f& direction) {
  const Eigen::Vector3f parts = level_.transpose() * direction;
  const float across = std::hypot(parts.x(), parts.y());
  elevation_ = std::atan2(parts.z(), across);
  if (across > 1e-6F * parts.norm()) {
    azimuth_ = std::atan2(parts.y(), parts.x());
  }
}

void Scope::orbit(float azimuth, float elevation) {
  azimuth_ = wrapped(azimuth_ + finite_or_zero(azimuth));
  elevation_ = std::clamp(elevation_ + finite_or_zero(elevation), -kPi / 2, kPi / 2);
  const Eigen::Vector3f wanted = shaft();
  const float tilt = std::atan2(axis_.cross(wanted).norm(), axis_.dot(wanted));
  if (tilt > options_.widest_tilt) {
    const Eigen::Vector3f aside = wanted - wanted.dot(axis_) * axis_;
    if (aside.norm() > 1e-6F) {
      aim(std::cos(options_.widest_tilt) * axis_ +
          std::sin(options_.widest_tilt) * aside.normalized());
    } else {
      aim(axis_);  // straight back: no way there is nearest
    }
  }
  level();
}

void Scope::advance(float distance) {
  const float wanted = insertion_ + finite_or_zero(distance);
  const float before = insertion_;
  insertion_ = std::clamp(wanted, options_.least_insertion, options_.most_insertion);
  focus_ = std::max(focus_ - (insertion_ - before), least_focus());
}

void Scope::look_at(const Eigen::Vector3f& target, float distance) {
  if (!target.allFinite() || !(distance > 0) || !std::isfinite(distance)) {
    return;
  }
  const Eigen::Vector3d way = (level_.transpose() * (target - pivot_)).cast<double>();
  const double line = way.norm();
  const double insertion = std::clamp<double>(other_side(line, options_.angle, distance),
                                              options_.least_insertion, options_.most_insertion);
  const double focus = other_side(line, options_.angle, insertion);
  // the way in axes of the shaft, whose elevation turns the last two
  const double aside = focus * std::sin(static_cast<double>(options_.angle));
  const double right = aside * std::sin(static_cast<double>(post_));
  const double above = -aside * std::cos(static_cast<double>(post_));
  const double ahead = insertion + focus * std::cos(static_cast<double>(options_.angle));
  const double length = std::hypot(above, ahead);
  const double lean = std::asin(std::clamp(way.z() / length, -1.0, 1.0));
  const double azimuth = std::atan2(way.y(), way.x()) + std::atan2(right, length * std::cos(lean));
  const double elevation = lean - std::atan2(above, ahead);
  insertion_ = static_cast<float>(insertion);
  focus_ = std::max(static_cast<float>(focus), least_focus());
  orbit(static_cast<float>(azimuth - azimuth_), static_cast<float>(elevation - elevation_));
}

void Scope::turn_post(float angle) {
  post_ = wrapped(post_ + finite_or_zero(angle));
  level();
}

void Scope::turn_head(float angle) {
  is_level_ = false;
  head_ = wrapped(head_ + finite_or_zero(angle));
}

void Scope::set_level(bool level_wanted) {
  is_level_ = level_wanted;
  level();
}

void Scope::set_focus(float distance) {
  if (distance > 0 && std::isfinite(distance)) {
    focus_ = distance;
  }
}

void Scope::level() {
  if (!is_level_) {
    return;
  }
  // up in the picture of a head that turns with the post: the head then turns as far as that leans
  const Eigen::Vector3f up = optics_frame().transpose() * level_.col(2);
  if (std::hypot(up.x(), up.y()) > 1e-3F) {
    head_ = wrapped(post_ + std::atan2(-up.x(), up.y()));
  }
}

Camera Scope::camera() const {
  const Eigen::Matrix3f frame = optics_frame() * turn(head_ - post_, Eigen::Vector3f::UnitZ());
  Camera camera;
  camera.eye = tip();
  camera.target = camera.eye - focus_ * frame.col(2);
  camera.up = frame.col(1);
  camera.vertical_field_of_view = 2 * std::atan(std::tan(options_.field_of_view / 2) / kRound);
  camera.light_offset =
      turn(post_ - head_, Eigen::Vector3f::UnitZ()) * Eigen::Vector3f(0, options_.lamp_offset, 0);
  return camera;
}

}  // namespace cholecystectomy
