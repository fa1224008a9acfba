// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/heat/disk_source.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/tet_mesh.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;

constexpr double kRadius = 0.5e-3;

// A block under a disk at the middle of its top, which lies at z = 0.
struct Block {
  std::vector<Eigen::Vector3f> positions;
  std::vector<Tet> tets;
  std::vector<Index> all;

  Block(Index cells, double width, double jitter = 0) {
    const TetMesh mesh = testing::make_box({cells, cells, cells / 2}, width / cells, jitter);
    for (const Eigen::Vector3d& x : mesh.positions()) {
      positions.push_back((x - Eigen::Vector3d(width / 2, width / 2, width / 2)).cast<float>());
    }
    tets.assign(mesh.tets().begin(), mesh.tets().end());
    all.resize(tets.size());
    std::iota(all.begin(), all.end(), 0);
  }
};

const DiskContact kOnTop{Eigen::Vector3d::Zero(), -Eigen::Vector3d::UnitZ(), kRadius};

double sum(const std::vector<VertexShare>& shares) {
  double result = 0;
  for (const VertexShare& entry : shares) {
    result += entry.share;
  }
  return result;
}

template <class Function>
double mean(const Block& block, const std::vector<VertexShare>& shares, Function function) {
  double result = 0;
  for (const VertexShare& entry : shares) {
    const Eigen::Vector3d position = block.positions[entry.vertex].cast<double>();
    result += entry.share * function(position);
  }
  return result;
}

// s = sinh(mu) of the oblate spheroid of the disk that a point lies on, by its coordinates:
// rho^2 / (1 + s^2) + z^2 / s^2 = 1 in units of the radius.
double spheroid_through(const Eigen::Vector3d& point) {
  const Eigen::Vector3d x = point / kRadius;
  const double b = x.squaredNorm() - 1;
  return std::sqrt((b + std::sqrt(b * b + 4 * x.z() * x.z())) / 2);
}

}  // namespace

// P(s) = (2/pi) atan(s) of the power lies inside of sinh(mu) = s (Newman 1966). Would catch a wrong
// density of points, a wrong depth or scale, and power lost at the rim.
TEST_CASE("disk source: the power inside of a spheroid follows its closed form", "[validation]") {
  const Block block(40, 8 * kRadius);
  DiskSource source;
  std::vector<VertexShare> shares;
  const double covered = source.distribute(kOnTop, block.positions, block.tets, block.all, shares);
  // the block ends between the spheroids 4 and 5.7
  CHECK(covered > 2 / std::numbers::pi * std::atan(3.8));
  CHECK(covered < 2 / std::numbers::pi * std::atan(5.7));
  for (const double s : {0.6, 1.0, 1.5, 2.0, 3.0}) {
    const double inside = covered * mean(block, shares, [&](const Eigen::Vector3d& x) {
                            return spheroid_through(x) <= s ? 1.0 : 0.0;
                          });
    CHECK(inside == Approx(2 / std::numbers::pi * std::atan(s)).margin(0.03));
  }
}

// Linear elements take the load of whatever is linear exactly, on the coarsest mesh as on the
// finest; what is not, converges. Would catch shares that follow the number or the size of
// elements.
TEST_CASE("disk source: heat does not depend on the mesh", "[property]") {
  DiskSource source;
  const double width = 16 * kRadius;
  std::vector<VertexShare> shares;
  std::vector<double> depths, reaches, covers;
  for (const Index cells : {2, 4, 8, 16, 32}) {  // edges from 8 radii to half of one
    const Block block(cells, width);
    covers.push_back(source.distribute(kOnTop, block.positions, block.tets, block.all, shares));
    CHECK(sum(shares) == Approx(1).epsilon(1e-12));
    depths.push_back(mean(block, shares, [](const Eigen::Vector3d& x) { return x.z(); }));
    reaches.push_back(mean(block, shares, [](const Eigen::Vector3d& x) { return x.norm(); }));
    // on the axis of the disk
    CHECK(mean(block, shares, [](const Eigen::Vector3d& x) { return x.x(); }) ==
          Approx(0).margin(0.05 * kRadius));
  }
  for (std::size_t i = 1; i < depths.size(); ++i) {
    CHECK(covers[i] == Approx(covers[0]).margin(2e-3));
    CHECK(depths[i] == Approx(depths[0]).epsilon(2e-3));
  }
  for (std::size_t i = 2; i < reaches.size(); ++i) {
    CHECK(std::abs(reaches[i] - reaches.back()) <= std::abs(reaches[i - 1] - reaches.back()));
  }
  CHECK(reaches[3] == Approx(reaches[4]).epsilon(0.05));
}

// Would catch power lost or doubled between tetrahedra, and an answer that depends on their order.
TEST_CASE("disk source: shares are positive, add up to one, in any order and any pose",
          "[property]") {
  DiskSource source;
  std::vector<VertexShare> shares, again;
  for (const Index cells : {2, 6, 12}) {
    Block block(cells, 12 * kRadius, 0.1);
    const double covered =
        source.distribute(kOnTop, block.positions, block.tets, block.all, shares);
    CHECK(covered > 0.7);
    CHECK(sum(shares) == Approx(1).epsilon(1e-12));
    for (std::size_t i = 0; i < shares.size(); ++i) {
      CHECK(shares[i].share > 0);
      CHECK((i == 0 || shares[i - 1].vertex < shares[i].vertex));
    }
    std::reverse(block.all.begin(), block.all.end());
    CHECK(source.distribute(kOnTop, block.positions, block.tets, block.all, again) == covered);
    REQUIRE(again.size() == shares.size());
    for (std::size_t i = 0; i < shares.size(); ++i) {
      CHECK(again[i].vertex == shares[i].vertex);
      CHECK(again[i].share == Approx(shares[i].share).epsilon(1e-6));
    }
    // turned, moved and grown; the points turn about the axis, so shares agree roughly only
    const Eigen::Affine3d pose = Eigen::Translation3d(0.01, -0.02, 0.03) *
                                 Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, -1).normalized()) *
                                 Eigen::Scaling(3.0);
    for (Eigen::Vector3f& x : block.positions) {
      x = (pose * x.cast<double>()).cast<float>();
    }
    const DiskContact moved{pose * kOnTop.center, (pose.linear() * kOnTop.inward).normalized(),
                            3 * kRadius};
    source.distribute(moved, block.positions, block.tets, block.all, again);
    double difference = 0;
    std::vector<double> dense(block.positions.size());
    for (const auto& [vertex, share] : shares) {
      dense[vertex] += share;
    }
    for (const auto& [vertex, share] : again) {
      dense[vertex] -= share;
    }
    for (const double d : dense) {
      difference += std::abs(d);
    }
    CHECK(difference < 0.15);
  }
}

TEST_CASE("disk source: what is not there takes nothing", "[unit]") {
  Block block(4, 8 * kRadius);
  DiskSource source;
  std::vector<VertexShare> shares{{1, 1.0}};
  DiskContact away = kOnTop;
  away.inward = Eigen::Vector3d::UnitZ();  // out of the tissue
  CHECK(source.distribute(away, block.positions, block.tets, block.all, shares) == 0);
  CHECK(shares.empty());
  CHECK(source.distribute(kOnTop, block.positions, block.tets, {}, shares) == 0);
  // a flat tetrahedron holds no point, and is no trouble
  const std::vector<Tet> flat{{0, 1, 2, 3}};
  CHECK(source.distribute(kOnTop, block.positions, flat, std::vector<Index>{0}, shares) == 0);
  CHECK(shares.empty());
  // without half of the tetrahedra the rest takes all
  std::vector<Index> half;
  for (std::size_t t = 0; t < block.all.size(); t += 2) {
    half.push_back(block.all[t]);
  }
  const double all = source.distribute(kOnTop, block.positions, block.tets, block.all, shares);
  const double some = source.distribute(kOnTop, block.positions, block.tets, half, shares);
  CHECK((some > 0 && some < all));
  CHECK(sum(shares) == Approx(1).epsilon(1e-12));
}

TEST_CASE("disk source: bad values are refused by name, and nothing has changed", "[unit]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Block block(2, 8 * kRadius);
  DiskSource source;
  std::vector<VertexShare> shares{{1, 1.0}};
  const auto attempt = [&](const DiskContact& contact, std::vector<Index> near) {
    source.distribute(contact, block.positions, block.tets, near, shares);
  };
  DiskContact bad = kOnTop;
  bad.radius = 0;
  CHECK_THROWS_WITH(attempt(bad, {0}), ContainsSubstring("radius"));
  bad = kOnTop;
  bad.center.y() = nan;
  CHECK_THROWS_WITH(attempt(bad, {0}), ContainsSubstring("centre"));
  bad = kOnTop;
  bad.inward *= 2;
  CHECK_THROWS_WITH(attempt(bad, {0}), ContainsSubstring("length 2"));
  CHECK_THROWS_WITH(attempt(kOnTop, {0, 1000}), ContainsSubstring("tetrahedron 1000"));
  CHECK(shares.size() == 1);
}

}  // namespace pbdsurg
