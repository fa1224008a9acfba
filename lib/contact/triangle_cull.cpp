// SPDX-License-Identifier: Apache-2.0
#include "lib/contact/triangle_cull.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "pbdsurg/base/error.h"

#include "lib/contact/nearest_triangle.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3f;

constexpr float kFar = std::numeric_limits<float>::infinity();  // m
constexpr float kNowhere = 1e12F;                               // m, whose square is finite

[[noreturn]] void refuse(const CulledSurface& surface, std::size_t triangle) {
  const auto& [a, b, c] = surface.triangles[triangle];
  throw InvalidArgument("triangle " + std::to_string(triangle) + " of a surface has corners " +
                        std::to_string(a) + ", " + std::to_string(b) + ", " + std::to_string(c) +
                        "; they must be in [0, " + std::to_string(surface.positions.size()) + ")");
}

// Calls visit(place, surface, a, b, c) for all that there are.
template <class Visit>
void for_each_triangle(std::span<const CulledSurface> surfaces, Visit visit) {
  std::size_t place = 0;
  for (const CulledSurface& surface : surfaces) {
    const Vector3f* const positions = surface.positions.data();
    for (std::size_t t = 0; t < surface.triangles.size(); ++t, ++place) {
      const auto& [i, j, k] = surface.triangles[t];
      if (i == j) {
        continue;
      }
      if (std::min({i, j, k}) < 0 ||
          static_cast<std::size_t>(std::max({i, j, k})) >= surface.positions.size()) {
        refuse(surface, t);
      }
      visit(place, surface, positions[i], positions[j], positions[k]);
    }
  }
}

}  // namespace

TriangleCull::Reaches::Reaches(std::span<const ToolPoint> balls)
    : x(EachBall::Constant(kNowhere)), y(x), z(x), distance(EachBall::Zero()) {
  for (std::size_t i = 0; i < balls.size(); ++i) {
    low = low.cwiseMin(balls[i].center);
    high = high.cwiseMax(balls[i].center);
    const auto ball = static_cast<Eigen::Index>(i);
    x[ball] = balls[i].center.x();
    y[ball] = balls[i].center.y();
    z[ball] = balls[i].center.z();
  }
}

TriangleCull::EachBall TriangleCull::Reaches::squares_to(const Vector3f& point) const noexcept {
  return (x - point.x()).square() + (y - point.y()).square() + (z - point.z()).square();
}

bool TriangleCull::Reaches::meet(const PatchTriangle& triangle) const noexcept {
  return (squares_to(triangle.corners[0]) <=
          (distance + (triangle.size + kDistanceRounding)).square())
      .any();
}

// All triangles that reaches may meet.
void TriangleCull::take(std::span<const CulledSurface> surfaces, const Reaches& reaches,
                        Taken& taken) {
  taken.triangles.clear();
  taken.places.clear();
  taken.gaps.assign(surfaces.size(), kFar);
  const float farthest = reaches.distance.maxCoeff();
  EachBall nearest = EachBall::Constant(kFar);
  for_each_triangle(surfaces, [&](std::size_t place, const CulledSurface& surface,
                                  const Vector3f& a, const Vector3f& b, const Vector3f& c) {
    const float ab = (b - a).squaredNorm(), ac = (c - a).squaredNorm();
    const float outside = (reaches.low - a).cwiseMax(a - reaches.high).cwiseMax(0).squaredNorm();
    const float size = std::sqrt(std::max(ab, ac)), far = farthest + size + kDistanceRounding;
    float& gap = taken.gaps[static_cast<std::size_t>(&surface - surfaces.data())];
    if (!(outside <= far * far) || !(ab + ac < kFar)) {  // or not finite
      gap = std::min(gap, std::sqrt(outside) - far);
      return;
    }
    const EachBall squares = reaches.squares_to(a);
    nearest = nearest.min(squares);
    if ((squares <= (reaches.distance + (size + kDistanceRounding)).square()).any()) {
      taken.triangles.push_back(
          {{a, b, c}, size, surface.youngs_modulus, surface.poissons_ratio, surface.thickness});
      taken.places.push_back(place);
    } else {
      gap = 0;
    }
  });
  taken.nearest_corner = nearest.sqrt();
}

// m, to the nearest triangle of all, negative inside; infinite beyond a box around all
float TriangleCull::search(std::span<const CulledSurface> surfaces, const Vector3f& point) {
  Eigen::Array3f low = Eigen::Array3f::Constant(kFar), high = -low;
  const Vector3f* seen = nullptr;
  for (const CulledSurface& surface : surfaces) {
    if (surface.positions.data() == seen) {  // another part of the last
      continue;
    }
    seen = surface.positions.data();
    for (const Vector3f& x : surface.positions) {
      low = low.min(x.array());
      high = high.max(x.array());
    }
  }
  if ((point.array() < low).any() || (point.array() > high).any()) {
    return kFar;
  }
  float square = kFar;
  for_each_triangle(surfaces, [&](std::size_t, const CulledSurface&, const Vector3f& a,
                                  const Vector3f& b, const Vector3f& c) {
    square = (a + b + c).allFinite() ? std::min(square, (a - point).squaredNorm()) : square;
  });
  const ToolPoint ball{point, 0};
  Reaches reach(std::span(&ball, 1));
  reach.distance[0] = tied_with(std::sqrt(square));
  take(surfaces, reach, searched_);
  return find_nearest_triangle(searched_.triangles, point).distance;
}

// Whether a center, which no triangle is in reach of, is nearer than that to one outside.
bool TriangleCull::is_beside_outside(std::span<const ToolPoint> balls, std::size_t ball,
                                     std::span<const bool> is_outside) const noexcept {
  const float own_reach = reaches_.distance[static_cast<Eigen::Index>(ball)];
  for (std::size_t i = 0; i < balls.size(); ++i) {
    if (!((balls[i].center - balls[ball].center).norm() < own_reach)) {
      continue;
    }
    const float distance = find_nearest_triangle(near_.triangles, balls[i].center).distance;
    if (is_outside[i] ||
        (distance > 0 && distance <= reaches_.distance[static_cast<Eigen::Index>(i)])) {
      return true;
    }
  }
  return false;
}

void TriangleCull::find(std::span<const CulledSurface> surfaces, std::span<const ToolPoint> balls,
                        std::span<const float> whole, float margin) {
  reaches_ = Reaches(balls);
  for (std::size_t i = 0; i < balls.size(); ++i) {
    reaches_.distance[static_cast<Eigen::Index>(i)] =
        balls[i].radius + ContactPatch::kReach + margin;
  }
  take(surfaces, reaches_, near_);

  std::array<bool, ContactPacket::kLargestPlaneCount> is_outside{};
  bool is_deep = false;
  for (std::size_t i = 0; i < balls.size(); ++i) {
    float& reach = reaches_.distance[static_cast<Eigen::Index>(i)];
    if (near_.nearest_corner[static_cast<Eigen::Index>(i)] + 2 * margin <= reach) {
      continue;  // whichever side
    }
    float distance = find_nearest_triangle(near_.triangles, balls[i].center).distance;
    if (std::abs(distance) > reach) {
      distance = is_beside_outside(balls, i, is_outside) ? kFar : search(surfaces, balls[i].center);
    }
    // farther than that, only the rim of what is there is near
    is_outside[i] = distance > 0 || -distance > whole[i];
    if (!is_outside[i]) {  // what is nearest after a move was farther by up to twice that
      is_deep = true;
      reach = std::max(reach, 2 * margin - distance);
    }
  }
  if (is_deep) {
    take(surfaces, reaches_, near_);
  }
  note_reaches(balls.size(), margin);
}

void TriangleCull::find_within(std::span<const CulledSurface> surfaces,
                               std::span<const ToolPoint> balls, std::span<const float> distances) {
  reaches_ = Reaches(balls);
  for (std::size_t i = 0; i < balls.size(); ++i) {
    reaches_.distance[static_cast<Eigen::Index>(i)] = distances[i];
  }
  take(surfaces, reaches_, near_);
  note_reaches(balls.size(), 0);
}

void TriangleCull::tighten(float margin) {
  reaches_.distance = reaches_.distance.min(near_.nearest_corner + 2 * margin);
  std::size_t kept = 0;
  for (std::size_t t = 0; t < near_.triangles.size(); ++t) {
    if (reaches_.meet(near_.triangles[t])) {
      near_.triangles[kept] = near_.triangles[t];
      near_.places[kept++] = near_.places[t];
    }
  }
  near_.triangles.resize(kept);
  near_.places.resize(kept);
  note_reaches(ball_reaches_.size(), margin);
}

void TriangleCull::note_reaches(std::size_t count, float margin) {
  ball_reaches_.clear();
  for (std::size_t i = 0; i < count; ++i) {
    ball_reaches_.push_back(reaches_.distance[static_cast<Eigen::Index>(i)] - margin +
                            kDistanceRounding);
  }
}

}  // namespace pbdsurg
