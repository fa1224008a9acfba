// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Instruments as the solver sees them: sets of capsules that push tissue away, rigid but for
/// joints.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// A capsule in the tool's frame; a sphere when both ends coincide; or a plate.
struct Capsule {
  Eigen::Vector3f start{0, 0, 0};  ///< m
  Eigen::Vector3f end{0, 0, 0};    ///< m
  float radius = 0;                ///< m, positive
  /// m, at right angles to the way from start to end: a plate is what the capsule sweeps along it,
  /// a rounded box twice the radius thick. Zero: a capsule.
  Eigen::Vector3f across{0, 0, 0};
};

/// All that lies below a plane: a table, the wall of the abdomen.
struct HalfSpace {
  Eigen::Vector3f point{0, 0, 0};   ///< m, of the plane, in the tool's frame
  Eigen::Vector3f normal{0, 0, 1};  ///< unit, out of it
};

/// An axis in a tool around which some of its capsules turn: a jaw, a blade, or a wrist with both.
struct ToolJoint {
  Eigen::Vector3f point{0, 0, 0};  ///< m, of the axis, in the tool's frame
  Eigen::Vector3f axis{0, 0, 1};   ///< unit, likewise; positive angles are counter-clockwise
  Index first_capsule = 0;         ///< the first that it turns
  Index capsule_count = 0;         ///< how many it turns, positive
};

/// What of tissue meets a tool.
enum class ContactFeatures : std::uint8_t {
  vertices,  ///< alone, which costs least: a capsule thinner than an edge can pass through a face
  all,       ///< vertices, and edges and triangles of surfaces between them
};

/// How a tool's surface meets tissue. By default it is smooth.
struct ToolSurface {
  ContactFeatures features = ContactFeatures::all;  ///< what it pushes
  float friction = 0;  ///< Coulomb's coefficient, >= 0, at rest and sliding
};

/// A spring between a tool and where it is to be, as between an instrument and a hand: tissue
/// pushes the tool away by its force over the stiffness, in any direction, and does not turn it. So
/// a hand pushes no harder than stiffness times the way between the two. (The "virtual coupling" of
/// Colgate, Stanley, Brown 1995, without mass.)
struct ToolCoupling {
  /// N/m, positive; a hand on a haptic device bears 300 to 1000. Infinite: no spring, a tool is
  /// where it is to be.
  float stiffness = std::numeric_limits<float>::infinity();
};

/// Tissue that pushes a tool, at one point.
struct ToolContact {
  std::array<Index, 3> vertices;  ///< scene vertices: one, the two of an edge, or the three of a
                                  ///< triangle; kInvalidIndex behind them
  std::array<float, 3> weights;   ///< of these at the point; their sum is one
  Eigen::Vector3f point;          ///< m, of the tissue, in the scene
  Eigen::Vector3f normal;         ///< out of the tool
  Eigen::Vector3f force;          ///< N, on the tool, with friction
};

/// Where a tool is: rotation, then translation, from the tool's frame to the world, in m.
using ToolPose = Eigen::Isometry3f;

}  // namespace pbdsurg
