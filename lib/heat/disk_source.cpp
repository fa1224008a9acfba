// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/heat/disk_source.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/owned.h"

#include "lib/base/check.h"

namespace pbdsurg {
namespace {

void check_contact(const DiskContact& contact) {
  if (!(contact.radius > 0) || !std::isfinite(contact.radius)) {
    throw InvalidArgument("disk radius is " + std::to_string(contact.radius) +
                          " m; it must be positive and finite");
  }
  if (!contact.center.allFinite()) {
    throw InvalidArgument("disk centre is not finite");
  }
  const double length = contact.inward.norm();
  if (!(std::abs(length - 1) < 1e-4)) {
    throw InvalidArgument("disk inward direction has length " + std::to_string(length) +
                          "; it must be one");
  }
}

// Range of what lies in a box around a tetrahedron, in the disk's frame.
struct Bounds {
  double low_depth, high_depth;
  double low_radius, high_radius;  // from the axis
};

Bounds find_bounds(const Eigen::Matrix<double, 3, 4>& corners) {
  const Eigen::Vector3d low = corners.rowwise().minCoeff();
  const Eigen::Vector3d high = corners.rowwise().maxCoeff();
  const Eigen::Vector3d nearest = low.cwiseMax(0.0).cwiseMax(-high);  // of the box, by axis
  const double farthest = corners.topRows<2>().colwise().norm().maxCoeff();
  return {low.z(), high.z(), std::hypot(nearest.x(), nearest.y()), farthest};
}

}  // namespace

DiskSource::DiskSource() : is_taken_(kPoints) {
  constexpr double kPi = std::numbers::pi;
  const double golden_angle = kPi * (3 - std::sqrt(5.0));  // rows do not line up
  for (int shell = 0; shell < kShells; ++shell) {
    const double s = std::tan(kPi / 2 * (shell + 0.5) / kShells);
    shells_.push_back(s);
    for (int k = 0; k < kRows; ++k) {
      const double t = (k + 0.5) / kRows;
      const Row row{s * t, std::sqrt((1 + s * s) * (1 - t * t))};
      const double turned = golden_angle * static_cast<double>(rows_.size());
      for (int turn = 0; turn < kTurns; ++turn) {
        const double angle = turned + 2 * kPi * turn / kTurns;
        points_.emplace_back(row.radius * std::cos(angle), row.radius * std::sin(angle), row.depth);
      }
      rows_.push_back(row);
    }
  }
}

double DiskSource::distribute(const DiskContact& contact,
                              std::span<const Eigen::Vector3f> positions, std::span<const Tet> tets,
                              std::span<const Index> near, std::vector<VertexShare>& shares) {
  if (shells_.empty()) {
    throw_moved_from("a disk source");
  }
  check_contact(contact);
  for (const Index t : near) {
    check_id("tetrahedron", t, tets.size());
    for (const Index v : tets[t]) {
      check_id("vertex", v, positions.size());
    }
  }
  Eigen::Matrix3d to_disk;  // rows are the axes
  const Eigen::Vector3d inward = contact.inward.normalized();
  to_disk.row(0) = inward.unitOrthogonal();
  to_disk.row(1) = inward.cross(Eigen::Vector3d(to_disk.row(0)));
  to_disk.row(2) = inward;
  to_disk /= contact.radius;

  shares.clear();
  std::fill(is_taken_.begin(), is_taken_.end(), std::uint8_t{0});
  int taken = 0;
  for (const Index t : near) {
    Eigen::Matrix<double, 3, 4> corners;
    for (int k = 0; k < 4; ++k) {
      corners.col(k) = to_disk * (positions[tets[t][k]].cast<double>() - contact.center);
    }
    const Bounds box = find_bounds(corners);
    // r^2 = s^2 + 1 - t^2
    const double low_depth = std::max({box.low_depth, -box.high_depth, 0.0});
    const double least = low_depth * low_depth + box.low_radius * box.low_radius - 1;
    const double most = corners.colwise().norm().maxCoeff();
    const auto first =
        std::lower_bound(shells_.begin(), shells_.end(), least > 0 ? std::sqrt(least) : 0.0);
    const auto end = std::upper_bound(first, shells_.end(), most);
    const Eigen::Matrix3d edges = corners.rightCols<3>().colwise() - corners.col(0);
    const Eigen::Matrix3d inverse = edges.inverse();
    if (!inverse.allFinite()) {
      continue;  // a flat tetrahedron holds no point
    }
    Eigen::Vector4d sums = Eigen::Vector4d::Zero();
    for (auto row = (first - shells_.begin()) * kRows; row < (end - shells_.begin()) * kRows;
         ++row) {
      const auto [depth, radius] = rows_[row];
      if (depth < box.low_depth || depth > box.high_depth || radius < box.low_radius ||
          radius > box.high_radius) {
        continue;
      }
      for (auto p = row * kTurns; p < (row + 1) * kTurns; ++p) {
        if (is_taken_[p] != 0) {
          continue;
        }
        const Eigen::Vector3d inner = inverse * (points_[p] - corners.col(0));
        const Eigen::Vector4d share(1 - inner.sum(), inner.x(), inner.y(), inner.z());
        // a point on a shared face must not fall between two: the first takes it
        if (share.minCoeff() >= -1e-9) {
          is_taken_[p] = 1;
          ++taken;
          sums += share.cwiseMax(0.0);
        }
      }
    }
    for (int k = 0; k < 4; ++k) {
      if (sums[k] > 0) {
        shares.push_back({tets[t][k], sums[k]});
      }
    }
  }

  std::sort(shares.begin(), shares.end(), [](const VertexShare& a, const VertexShare& b) {
    return a.vertex != b.vertex ? a.vertex < b.vertex : a.share < b.share;
  });
  double total = 0;
  std::size_t count = 0;
  for (const VertexShare& entry : shares) {
    total += entry.share;
    if (count > 0 && shares[count - 1].vertex == entry.vertex) {
      shares[count - 1].share += entry.share;
    } else {
      shares[count++] = entry;
    }
  }
  shares.resize(count);
  for (VertexShare& entry : shares) {
    entry.share /= total;
  }
  return static_cast<double>(taken) / kPoints;
}

}  // namespace pbdsurg
