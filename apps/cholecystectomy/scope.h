// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// An oblique laparoscope in a port: how it is held, and what its camera then sees.

#include <Eigen/Core>
#include <numbers>

#include "pbdsurg/base/error.h"

#include "apps/viewer/render_snapshot.h"

namespace cholecystectomy {

/// Angles are radians, lengths metres.
struct ScopeOptions {
  float angle = static_cast<float>(std::numbers::pi / 6);  ///< of view and shaft: 0, 30 or 45
                                                           ///< degrees are usual; [0, 80 degrees]
  Eigen::Vector3f up{0, 0, 1};     ///< what a level picture has above; any length but zero
  float widest_tilt = 1.2F;        ///< of the shaft from the port's axis; (0, pi]
  float least_insertion = 0.02F;   ///< m, from the port to the tip, positive
  float most_insertion = 0.28F;    ///< m, not less
  float working_distance = 0.06F;  ///< m, from tip to what looking_at() aims at; positive
  /// Across the round picture, whose diameter is 1.2 heights of the frame: usual scopes have 70
  /// degrees. (0, 150 degrees]
  float field_of_view = static_cast<float>(70 * std::numbers::pi / 180);
  /// Of the lamp from the lens, on the side of the light post. m
  float lamp_offset = 4e-3F;
};

/// The shaft turns about a pivot, the port, and slides through it. Optics at its tip look off its
/// axis; turning the light post turns them about the shaft. The camera head sits behind the
/// eyepiece: it turns the picture, not the view.
///
/// Axes. Directions of the shaft are azimuth and elevation: with e and n level, and e, n, up a
/// right-handed frame, d = cos(elevation) (cos(azimuth) e + sin(azimuth) n) + sin(elevation) up.
/// For up = z, e is x. The frame S of the shaft has as columns right, above, back: back is -d, and
/// above is where d goes as elevation grows. The camera's columns right, up, back are
///
///     S Rz(post) Rx(-angle) Rz(head - post)
///
/// with Rx and Rz counter-clockwise turns about the first and third axis: the third looks at the
/// viewer. The view, minus the last column, depends on post alone: at 0 the post is above and the
/// scope looks below its shaft, at pi it looks above. With the head at 0 and a straight scope the
/// picture stands as S does, however the post turns.
///
/// A level scope's head follows all else, so that `up` is upwards in the picture. Where it looks
/// along `up`, its head stays.
class Scope {
 public:
  /// The shaft along the port's axis, at least insertion, level.
  /// @param pivot  m
  /// @param axis  of the port, into the body; any length but zero
  /// @throws pbdsurg::InvalidArgument  naming the option or vector out of its range
  Scope(const Eigen::Vector3f& pivot, const Eigen::Vector3f& axis,
        const ScopeOptions& options = {});

  /// A level scope whose view goes through a target, at its working distance where the insertion
  /// allows. The shaft lies in the upright plane of pivot and target: above the line to the target,
  /// the post above; where above would be beyond upright, below, with the post below. The port's
  /// axis points at the target.
  /// @throws pbdsurg::InvalidArgument  as the constructor, and if the target is no farther from the
  ///                                   pivot than the least insertion
  static Scope looking_at(const Eigen::Vector3f& pivot, const Eigen::Vector3f& target,
                          const ScopeOptions& options = {});

  /// What follows keeps to the limits, and ignores what is not finite.
  ///
  /// Turns the shaft about the pivot, at most to the rim of the port's cone.
  void orbit(float azimuth, float elevation);
  /// Slides the shaft, inwards where positive; what it looks at stays as far from the port.
  void advance(float distance);
  /// Turns and slides the shaft, its post as it is, so that the target is in the middle of the
  /// picture and the lens at a distance from it, in focus. What cannot have both keeps the first.
  /// @param distance  m, positive
  void look_at(const Eigen::Vector3f& target, float distance);
  void turn_post(float angle);
  /// Turns the camera head by hand, which ends levelling.
  void turn_head(float angle);
  /// Levels the picture from now on, or holds the head as it is.
  void set_level(bool level);
  /// How far away that is which the light is set for. m, positive
  void set_focus(float distance);

  /// To draw with: the eye and lamp at the tip.
  [[nodiscard]] Camera camera() const;

  [[nodiscard]] const ScopeOptions& options() const noexcept { return options_; }
  [[nodiscard]] const Eigen::Vector3f& pivot() const noexcept { return pivot_; }
  [[nodiscard]] Eigen::Vector3f shaft() const;  ///< unit, from pivot to tip
  [[nodiscard]] Eigen::Vector3f tip() const { return pivot_ + insertion_ * shaft(); }  ///< m
  [[nodiscard]] Eigen::Vector3f view() const;                                          ///< unit
  [[nodiscard]] float azimuth() const noexcept { return azimuth_; }
  [[nodiscard]] float elevation() const noexcept { return elevation_; }  ///< [-pi / 2, pi / 2]
  [[nodiscard]] float insertion() const noexcept { return insertion_; }  ///< m
  [[nodiscard]] float post() const noexcept { return post_; }            ///< [-pi, pi]
  [[nodiscard]] float head() const noexcept { return head_; }            ///< [-pi, pi]
  [[nodiscard]] float focus() const noexcept { return focus_; }          ///< m
  [[nodiscard]] bool is_level() const noexcept { return is_level_; }

 private:
  [[nodiscard]] Eigen::Vector3f direction(float azimuth, float elevation) const;
  [[nodiscard]] Eigen::Matrix3f shaft_frame() const;
  [[nodiscard]] Eigen::Matrix3f optics_frame() const;  // S Rz(post) Rx(-angle)
  // As near as the lens can come, m.
  [[nodiscard]] float least_focus() const { return 0.2F * options_.working_distance; }
  void aim(const Eigen::Vector3f& direction);
  void level();

  ScopeOptions options_;
  Eigen::Vector3f pivot_;
  Eigen::Vector3f axis_;   // of the port, unit
  Eigen::Matrix3f level_;  // e, n, up as columns
  float azimuth_ = 0, elevation_ = 0;
  float insertion_;
  float post_ = 0, head_ = 0;
  float focus_;
  bool is_level_ = true;
};

}  // namespace cholecystectomy
