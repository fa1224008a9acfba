// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/anatomy/organs.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/mesh/tetrahedralize.h"

#include "tests/support/catch.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3d;
using testing::Approx;

std::vector<std::pair<std::string, ImplicitShape>> all_organs() {
  const ImplicitShape gallbladder = gallbladder_outer();
  return {{"gallbladder", gallbladder},
          {"liver bed", liver_bed(gallbladder)},
          {"cystic duct", cystic_duct()},
          {"cystic artery", cystic_artery()},
          {"common bile duct", common_bile_duct()},
          {"Calot's fat", calot_fat(gallbladder)}};
}

Vector3d random_point(const Eigen::AlignedBox3d& box, int element) {
  Vector3d unit;
  for (int axis = 0; axis < 3; ++axis) {
    unit[axis] = random_unit(2, static_cast<std::uint64_t>(element), axis);
  }
  return box.min() + unit.cwiseProduct(box.sizes());
}

struct Measures {
  double volume = 0;        // ml
  Eigen::AlignedBox3d box;  // mm
};

// By counting cells, without any mesh.
Measures measure(const ImplicitShape& shape, int steps) {
  Measures measures;
  const Eigen::AlignedBox3d& box = shape.bounds();
  const Vector3d cell = box.sizes() / steps;
  for (int i = 0; i < steps * steps * steps; ++i) {
    const Vector3d index(i % steps + 0.5, i / steps % steps + 0.5, i / (steps * steps) + 0.5);
    const Vector3d point = box.min() + index.cwiseProduct(cell);
    if (shape(point) < 0) {
      measures.volume += 1e6 * cell.prod();
      measures.box.extend(1e3 * point);
    }
  }
  return measures;
}

}  // namespace

TEST_CASE("organs: sizes are those of an adult", "[unit]") {
  const Measures gallbladder = measure(gallbladder_outer(), 60);
  CHECK(gallbladder.volume == Approx(59).epsilon(0.03));
  CHECK(gallbladder.box.sizes().x() == Approx(89).epsilon(0.04));
  CHECK(gallbladder.box.sizes().y() == Approx(36).epsilon(0.04));
  CHECK(measure(offset_shape(gallbladder_outer(), -2.5e-3), 60).volume == Approx(40).epsilon(0.03));

  const Measures liver = measure(liver_bed(gallbladder_outer()), 60);
  CHECK(liver.volume == Approx(525).epsilon(0.03));
  CHECK((liver.box.sizes() - Vector3d(142, 94, 61)).cwiseAbs().maxCoeff() < 4);

  CHECK(measure(calot_fat(gallbladder_outer()), 60).volume == Approx(7.9).epsilon(0.03));
  // a tube of length l and radius r with round ends: pi r^2 (l + 4 r / 3), l from the note of sizes
  CHECK(measure(cystic_artery(), 80).volume == Approx(0.24).epsilon(0.08));
  CHECK(measure(cystic_duct(), 80).volume == Approx(0.33).epsilon(0.1));
  const Measures bile_duct = measure(common_bile_duct(), 80);
  CHECK(bile_duct.volume == Approx(1.95).epsilon(0.05));
  CHECK(bile_duct.box.sizes().z() > 50);
}

// Would catch two organs that start inside each other, which contact handling cannot undo.
TEST_CASE("organs: no two overlap, but for what the fat encloses", "[property]") {
  const auto organs = all_organs();
  for (std::size_t i = 0; i < organs.size(); ++i) {
    for (std::size_t j = i + 1; j < organs.size(); ++j) {
      const auto& [a_name, a] = organs[i];
      const auto& [b_name, b] = organs[j];
      CAPTURE(a_name, b_name);
      const bool enclosed =
          b_name == "Calot's fat" && (a_name == "cystic duct" || a_name == "cystic artery");
      const Eigen::AlignedBox3d common = a.bounds().intersection(b.bounds());
      int both = 0;
      for (int k = 0; k < 20000 && !common.isEmpty(); ++k) {
        const Vector3d point = random_point(common, k);
        both += a(point) < 0 && b(point) < 0 ? 1 : 0;
      }
      CHECK((both > 0) == enclosed);
    }
  }
}

TEST_CASE("organs: neighbours lie as close as surgery needs them", "[unit]") {
  const auto nearest = [](const ImplicitShape& a, const ImplicitShape& b) {
    // the value of b, least over the surface of a
    TetrahedralizeOptions options;
    options.spacing = 1.0e-3;
    options.smoothing_sweeps = 0;
    double least = 1;
    const TetMesh mesh = tetrahedralize(a, options).mesh;
    for (const Vector3d& point : mesh.positions()) {
      least = std::min(least, b(point));
    }
    return 1e3 * least;
  };
  const ImplicitShape gallbladder = gallbladder_outer();
  CHECK(nearest(cystic_duct(), gallbladder) == Approx(0.3).margin(0.15));
  CHECK(nearest(cystic_duct(), common_bile_duct()) == Approx(0.4).margin(0.3));
  CHECK(nearest(cystic_artery(), liver_bed(gallbladder)) > 0.1);
  CHECK(nearest(cystic_artery(), gallbladder) > 0.4);
  CHECK(nearest(cystic_artery(), cystic_duct()) > 1);
}

// The tetrahedraliser skips space on this promise.
TEST_CASE("organs: values change by at most 1.3 per unit of distance", "[property]") {
  for (const auto& [name, shape] : all_organs()) {
    CAPTURE(name);
    for (int i = 0; i < 3000; ++i) {
      const Vector3d a = random_point(shape.bounds(), 2 * i);
      const Vector3d b = a + std::pow(0.1, i % 3) * (random_point(shape.bounds(), 2 * i + 1) - a);
      REQUIRE(std::abs(shape(a) - shape(b)) <= 1.3 * (a - b).norm());
    }
  }
}

TEST_CASE("organs: the liver has a fossa for any gallbladder", "[unit]") {
  const ImplicitShape block = liver_block();
  const ImplicitShape own = sphere_shape({0.03, 0.01, 0.02}, 0.015);
  const ImplicitShape bed = liver_bed(own, 2e-3);
  int carved = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vector3d point = random_point(block.bounds(), i);
    if (bed(point) < 0) {
      REQUIRE(own(point) >= 2e-3);
    } else if (block(point) < -3e-3) {
      ++carved;
    }
  }
  CHECK(carved > 10);
}

TEST_CASE("organs: the abdominal wall faces the organs and holds them", "[unit]") {
  const MeshData wall = abdominal_wall();
  const Vector3d middle(0.035, 0, 0);
  for (const auto& [a, b, c] : wall.triangles) {
    const Vector3d normal =
        (wall.points[b] - wall.points[a]).cross(wall.points[c] - wall.points[a]);
    REQUIRE(normal.dot(middle - wall.points[a]) > 0);
  }
  Eigen::AlignedBox3d box;
  for (const Vector3d& point : wall.points) {
    box.extend(point);
  }
  CHECK(box.contains(liver_block().bounds()));
}

}  // namespace pbdsurg
