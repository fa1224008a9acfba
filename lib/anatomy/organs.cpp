// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/anatomy/organs.h"

#include <cmath>
#include <initializer_list>
#include <numbers>
#include <vector>

namespace pbdsurg {
namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;

// Anatomy is written down in millimetres, as anatomists do.
constexpr double kMillimetre = 1e-3;

Vector3d millimetres(double x, double y, double z) {
  return kMillimetre * Vector3d(x, y, z);
}

ImplicitShape tube_in_millimetres(std::initializer_list<Vector4d> knots) {
  std::vector<Vector4d> scaled;
  for (const Vector4d& knot : knots) {
    scaled.push_back(kMillimetre * knot);
  }
  return tube_shape(scaled);
}

}  // namespace

ImplicitShape gallbladder_outer() {
  const ImplicitShape sac = tube_in_millimetres({{0, 0, 0, 15},
                                                 {12, 0, 1, 17.3},
                                                 {26, 0, 3, 18},
                                                 {40, 0.5, 6, 15.6},
                                                 {52, 1.5, 9, 11.8},
                                                 {60, 3, 11.3, 8.8},
                                                 {66, 5.5, 11.8, 6},
                                                 {70, 9, 11, 3.9},
                                                 {72, 12.5, 9.5, 2.9}});
  const ImplicitShape pouch = ellipsoid_shape(millimetres(60.5, -2.5, 7), millimetres(9.5, 8, 7.5));
  return smooth_union(sac, pouch, 5 * kMillimetre);
}

ImplicitShape gallbladder_wall(double thickness) {
  return shell_shape(gallbladder_outer(), thickness);
}

ImplicitShape cystic_duct() {
  // begins where the neck ends, so that the two touch without overlapping
  return smooth_difference(tube_in_millimetres({{70, 9, 11, 2.2},
                                                {72, 12.5, 9.5, 1.9},
                                                {74.5, 16.5, 8, 1.8},
                                                {78.5, 20.5, 6, 1.8},
                                                {84.5, 23.5, 3.5, 1.8},
                                                {91.5, 25, 0.5, 1.8},
                                                {98, 25.5, -4, 1.8}}),
                           offset_shape(gallbladder_outer(), 0.3 * kMillimetre), 0);
}

ImplicitShape cystic_artery() {
  return tube_in_millimetres({{99, 17, 16, 1.5},
                              {92, 15.8, 15.8, 1.4},
                              {85, 14.6, 15.7, 1.3},
                              {78, 13.2, 15.8, 1.25},
                              {72, 12.2, 16.1, 1.25},
                              {66, 12.2, 16.7, 1.2},
                              {60, 12.6, 17.4, 1.15},
                              {54, 13, 17.6, 1.1}});
}

ImplicitShape common_bile_duct() {
  return tube_in_millimetres({{110, 27, 14, 3.2},
                              {107.5, 26.3, 5, 3.3},
                              {104, 25.8, -4, 3.3},
                              {100.5, 26, -12, 3.3},
                              {97, 27, -20, 3.3},
                              {94, 29, -28, 3.3},
                              {92, 31, -36, 3.2}});
}

ImplicitShape liver_block() {
  const ImplicitShape slab =
      rounded_box_shape(millimetres(35, 0, 31), millimetres(72, 48, 21), 14 * kMillimetre);
  // The slab rises towards the porta hepatis and its sides bend upwards. The shear stretches
  // distances by up to 15 %, which the division takes back.
  const auto rise = [](double x, double y) { return 0.16 * x + 1.2 * y * y; };
  const auto value = [slab, rise](const Vector3d& p) {
    return slab(p - Vector3d(0, 0, rise(p.x(), p.y()))) / 1.15;
  };
  Eigen::AlignedBox3d box = slab.bounds();
  box.min().z() += rise(box.min().x(), 0);
  box.max().z() += rise(box.max().x(), box.max().y());
  return ImplicitShape(value, box);
}

ImplicitShape liver_bed(const ImplicitShape& gallbladder, double gap) {
  return smooth_difference(liver_block(), offset_shape(gallbladder, gap), 3 * kMillimetre);
}

ImplicitShape calot_fat(const ImplicitShape& gallbladder) {
  constexpr double kBlend = 5 * kMillimetre;
  constexpr double kEdge = 1.5 * kMillimetre;
  const ImplicitShape lobes = smooth_union(
      smooth_union(ellipsoid_shape(millimetres(84, 17, 9), millimetres(15, 10, 9.5)),
                   ellipsoid_shape(millimetres(72, 13, 13), millimetres(8, 6, 5.5)), kBlend),
      ellipsoid_shape(millimetres(93, 21, 4), millimetres(9, 7.5, 7.5)), kBlend);
  ImplicitShape fat = smooth_difference(lobes, offset_shape(gallbladder, 0.4 * kMillimetre), kEdge);
  fat = smooth_difference(fat, offset_shape(liver_block(), 0.8 * kMillimetre), kEdge);
  return smooth_difference(fat, offset_shape(common_bile_duct(), 0.3 * kMillimetre), kEdge);
}

MeshData abdominal_wall() {
  // Longitude by latitude on a stretched half sphere that opens towards the laparoscope.
  constexpr int kAround = 64, kRows = 24;
  const Vector3d center = millimetres(35, 0, 0);
  const Vector3d radii = millimetres(230, 220, 190);
  MeshData wall;
  wall.points.push_back(center + Vector3d(0, 0, radii.z()));
  for (int row = 1; row <= kRows; ++row) {
    const double latitude = 0.85 * std::numbers::pi * row / kRows;  // from the pole
    for (int i = 0; i < kAround; ++i) {
      const double longitude = 2 * std::numbers::pi * i / kAround;
      const Vector3d direction(std::sin(latitude) * std::cos(longitude),
                               std::sin(latitude) * std::sin(longitude), std::cos(latitude));
      wall.points.push_back(center + direction.cwiseProduct(radii));
    }
  }
  const auto id = [](int row, int i) {
    return row == 0 ? 0 : static_cast<Index>(1 + (row - 1) * kAround + i % kAround);
  };
  for (int row = 0; row < kRows; ++row) {
    for (int i = 0; i < kAround; ++i) {
      // counter-clockwise when seen from within the bowl
      wall.triangles.push_back({id(row, i), id(row + 1, i + 1), id(row + 1, i)});
      if (row > 0) {
        wall.triangles.push_back({id(row, i), id(row, i + 1), id(row + 1, i + 1)});
      }
    }
  }
  return wall;
}

}  // namespace pbdsurg
