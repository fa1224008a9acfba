// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/tube.h"

#include <Eigen/Geometry>
#include <cmath>
#include <string>

#include "pbdsurg/base/error.h"

namespace cholecystectomy {
namespace {

constexpr int kSides = 24;
constexpr int kCapRings = 5;
constexpr float kPi = 3.14159265f;

struct Station {
  Eigen::Vector3f center;
  float radius;
};

std::vector<Station> usable_stations(std::span<const Eigen::Vector3f> points,
                                     std::span<const float> radii) {
  std::vector<Station> stations;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].allFinite() && std::isfinite(radii[i]) &&
        (stations.empty() || points[i] != stations.back().center)) {
      stations.push_back({points[i], radii[i]});
    }
  }
  return stations;
}

/// Builds the rings of a tube, joining each to the one before.
class Sweeper {
 public:
  explicit Sweeper(const Eigen::Vector3f& direction)
      : direction_(direction), side_(direction.unitOrthogonal()) {}

  /// Turns the frame by the smallest rotation, which adds no twist.
  void turn_to(const Eigen::Vector3f& direction) {
    side_ = Eigen::Quaternionf::FromTwoVectors(direction_, direction) * side_;
    direction_ = direction;
    side_ = (side_ - direction_ * side_.dot(direction_)).normalized();
  }

  void add_ring(const Eigen::Vector3f& center, float radius) {
    const pbdsurg::Index first = static_cast<pbdsurg::Index>(mesh_.positions.size());
    const Eigen::Vector3f other = direction_.cross(side_);
    for (int i = 0; i < kSides; ++i) {
      const float angle = 2 * kPi * static_cast<float>(i) / kSides;
      mesh_.positions.push_back(center +
                                radius * (std::cos(angle) * side_ + std::sin(angle) * other));
    }
    if (first == 0) {
      return;
    }
    for (int i = 0; i < kSides; ++i) {
      const pbdsurg::Index a = first - kSides + i;
      const pbdsurg::Index b = first - kSides + (i + 1) % kSides;
      mesh_.triangles.push_back({a, b, a + kSides});
      mesh_.triangles.push_back({b, b + kSides, a + kSides});
    }
  }

  /// A half sphere towards (end = 1) or against (end = -1) the direction, pole first or last.
  void add_cap(const Station& station, int end) {
    for (int i = 0; i < kCapRings; ++i) {
      const int ring = end > 0 ? i + 1 : kCapRings - i;
      const float angle = kPi / 2 * static_cast<float>(ring) / kCapRings;
      add_ring(
          station.center + static_cast<float>(end) * station.radius * std::sin(angle) * direction_,
          station.radius * std::cos(angle));
    }
  }

  TriangleMesh take() { return std::move(mesh_); }

 private:
  Eigen::Vector3f direction_;
  Eigen::Vector3f side_;
  TriangleMesh mesh_;
};

}  // namespace

TriangleMesh sweep_tube(std::span<const Eigen::Vector3f> points, std::span<const float> radii) {
  if (points.size() != radii.size()) {
    throw pbdsurg::InvalidArgument("a tube has " + std::to_string(points.size()) + " points and " +
                                   std::to_string(radii.size()) +
                                   " radii; each point needs one radius");
  }
  const std::vector<Station> stations = usable_stations(points, radii);
  if (stations.size() < 2) {
    return {};
  }
  const auto direction = [&](std::size_t segment) -> Eigen::Vector3f {
    return (stations[segment + 1].center - stations[segment].center).normalized();
  };
  Sweeper sweeper(direction(0));
  sweeper.add_cap(stations.front(), -1);
  sweeper.add_ring(stations.front().center, stations.front().radius);
  for (std::size_t i = 1; i + 1 < stations.size(); ++i) {
    const Eigen::Vector3f mean = direction(i - 1) + direction(i);
    sweeper.turn_to(mean.norm() > 0.01f ? mean.normalized() : direction(i));
    sweeper.add_ring(stations[i].center, stations[i].radius);
  }
  sweeper.turn_to(direction(stations.size() - 2));
  sweeper.add_ring(stations.back().center, stations.back().radius);
  sweeper.add_cap(stations.back(), 1);
  return sweeper.take();
}

std::vector<Eigen::Vector3f> vertex_normals(std::span<const Eigen::Vector3f> positions,
                                            std::span<const pbdsurg::Triangle> triangles) {
  // In double: the cross product of two 0.1 mm edges underflows nothing and keeps its direction.
  std::vector<Eigen::Vector3d> sums(positions.size(), Eigen::Vector3d::Zero());
  for (const pbdsurg::Triangle& triangle : triangles) {
    const auto corner = [&](std::size_t i) -> Eigen::Vector3d {
      return positions[static_cast<std::size_t>(triangle[i])].cast<double>();
    };
    const Eigen::Vector3d normal = (corner(1) - corner(0)).cross(corner(2) - corner(0));
    if (normal.allFinite()) {
      for (const pbdsurg::Index v : triangle) {
        sums[static_cast<std::size_t>(v)] += normal;
      }
    }
  }
  std::vector<Eigen::Vector3f> normals(positions.size(), Eigen::Vector3f::Zero());
  for (std::size_t v = 0; v < sums.size(); ++v) {
    const double length = sums[v].norm();
    if (length > 0) {
      normals[v] = (sums[v] / length).cast<float>();
    }
  }
  return normals;
}

}  // namespace cholecystectomy
