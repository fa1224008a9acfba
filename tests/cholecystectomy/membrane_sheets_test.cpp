// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/membrane_sheets.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <vector>

#include "pbdsurg/base/error.h"

#include "tests/support/catch.h"

namespace cholecystectomy {
namespace {

using pbdsurg::Index;
using pbdsurg::Triangle;
using pbdsurg::testing::Approx;
using pbdsurg::testing::ContainsSubstring;

constexpr Index kSide = 6;  // links along a side of the grid
constexpr auto kRow = static_cast<Index>(MembraneSheets::kLevels.size());
constexpr float kSpacing = 2e-3F, kGap = 2e-3F;  // m
const Eigen::Vector3f kTissue(0.9F, 0.8F, 0.7F), kFirst(0.1F, 0.6F, 0.2F), kSecond(0.5F, 0, 0);

Index at(Index x, Index y) {
  return y * kSide + x;
}

/// A square membrane between two plates, z = 0 and z = kGap, and one strand beside it.
struct Grid {
  std::vector<SheetLink> links;
  std::vector<SheetLinkState> states;
  std::vector<Triangle> triangles;

  Grid() {
    for (Index y = 0; y < kSide; ++y) {
      for (Index x = 0; x < kSide; ++x) {
        add({kSpacing * static_cast<float>(x), kSpacing * static_cast<float>(y), 0});
        if (x + 1 < kSide && y + 1 < kSide) {
          triangles.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
          triangles.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
        }
      }
    }
    add({0.05F, 0, 0});
  }

  void add(const Eigen::Vector3f& foot) {
    const Eigen::Vector3f head = foot + Eigen::Vector3f(0, 0, kGap);
    links.push_back({foot, head, kFirst, kSecond});
    states.push_back({foot, head});
  }

  /// Lifts the second plate so that links are that long.
  void open(float length) {
    for (SheetLinkState& state : states) {
      state.second.z() = length;
    }
  }

  [[nodiscard]] MembraneSheets sheets() const { return {links, triangles, kTissue}; }
  [[nodiscard]] MembraneSheets updated() const {
    MembraneSheets result = sheets();
    result.update(states);
    return result;
  }
};

/// The middle of the row of a link in the curtain or web: the vertex nearest to its middle.
Index middle_of(const Surface& surface, const SheetLinkState& state) {
  const Eigen::Vector3f middle = (state.first + state.second) / 2;
  Index best = 0;
  for (Index v = kRow / 2; v < static_cast<Index>(surface.positions.size()); v += kRow) {
    if ((surface.positions[v] - middle).norm() < (surface.positions[best] - middle).norm()) {
      best = v;
    }
  }
  return best;
}

float largest_alpha(const Surface& surface) {
  float largest = 0;
  for (const Eigen::Vector4f& color : surface.colors) {
    largest = std::max(largest, color.w());
  }
  return largest;
}

void check_drawable(const Surface& surface) {
  const std::size_t count = surface.positions.size();
  REQUIRE(surface.colors.size() == count);
  REQUIRE(surface.normals.size() == count);
  REQUIRE(surface.rest_positions.size() == count);
  for (std::size_t v = 0; v < count; ++v) {
    REQUIRE(surface.positions[v].allFinite());
    REQUIRE(surface.normals[v].allFinite());
    REQUIRE(surface.colors[v].allFinite());
    REQUIRE(surface.colors[v].minCoeff() >= 0);
    REQUIRE(surface.colors[v].maxCoeff() <= 1);
  }
  for (const Triangle& triangle : surface.triangles) {
    for (const Index v : triangle) {
      REQUIRE(v >= 0);
      REQUIRE(v < static_cast<Index>(count));
    }
  }
}

bool same(const Surface& a, const Surface& b) {
  return a.positions == b.positions && a.triangles == b.triangles && a.colors == b.colors &&
         a.normals == b.normals;
}

}  // namespace

// Would catch strips that are drawn one by one, with vertices of their own or gaps between them.
TEST_CASE("membrane sheets: the curtain goes once round the membrane, welded", "[unit]") {
  const Grid grid;
  const MembraneSheets sheets = grid.updated();
  const Surface& curtain = sheets.curtain();
  check_drawable(curtain);
  constexpr Index kRim = 4 * (kSide - 1);
  CHECK(curtain.positions.size() == kRim * kRow);
  CHECK(curtain.triangles.size() == kRim * (kRow - 1) * 2);
  // each edge has two triangles, but for those along the two organs
  std::map<std::pair<Index, Index>, int> sides;
  for (const Triangle& triangle : curtain.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Index a = triangle[k], b = triangle[(k + 1) % 3];
      ++sides[{std::min(a, b), std::max(a, b)}];
    }
  }
  Index open_sides = 0;
  for (const auto& [side, count] : sides) {
    REQUIRE(count <= 2);
    open_sides += count == 1 ? 1 : 0;
  }
  CHECK(open_sides == 2 * kRim);
}

// Would catch a curtain whose sides are lit as if they faced each other.
TEST_CASE("membrane sheets: normals of the curtain agree from row to row", "[unit]") {
  const Grid grid;
  const MembraneSheets sheets = grid.updated();
  const Surface& curtain = sheets.curtain();
  for (const Triangle& triangle : curtain.triangles) {
    REQUIRE(curtain.normals[triangle[0]].dot(curtain.normals[triangle[1]]) > 0.3F);
    REQUIRE(curtain.normals[triangle[1]].dot(curtain.normals[triangle[2]]) > 0.3F);
  }
}

// Would catch a sheet that bulges out, or a straight wall.
TEST_CASE("membrane sheets: the curtain has a waist inside the membrane", "[unit]") {
  Grid grid;
  grid.open(2 * kGap);
  const MembraneSheets sheets = grid.updated();
  const Surface& curtain = sheets.curtain();
  const Eigen::Vector2f center = Eigen::Vector2f::Constant(kSpacing * (kSide - 1) / 2);
  for (Index v = 0; v < static_cast<Index>(curtain.positions.size()); v += kRow) {
    const auto radius = [&](Index level) {
      return (curtain.positions[v + level].head<2>() - center).norm();
    };
    REQUIRE(radius(kRow / 2) < radius(0) - 0.1e-3F);
    REQUIRE(radius(kRow / 2) < radius(kRow - 1) - 0.1e-3F);
  }
}

// Would catch links that are drawn after they parted, and a hole without a rim.
TEST_CASE("membrane sheets: parted links vanish, and the rim of the hole gets a curtain",
          "[unit]") {
  Grid grid;
  MembraneSheets sheets = grid.updated();
  const std::size_t whole = sheets.curtain().triangles.size();
  grid.states[at(2, 2)].is_alive = false;
  sheets.update(grid.states);
  CHECK(sheets.curtain().triangles.size() == whole + 6 * (kRow - 1) * 2);  // six around a link
  for (const Surface& surface : sheets.surfaces()) {
    for (const Eigen::Vector3f& position : surface.positions) {
      REQUIRE((position - grid.states[at(2, 2)].first).head<2>().norm() > 0.2F * kSpacing);
    }
  }
  for (SheetLinkState& state : grid.states) {
    state.is_alive = false;
  }
  sheets.update(grid.states);
  for (const Surface& surface : sheets.surfaces()) {
    CHECK(surface.positions.empty());
    CHECK(surface.triangles.empty());
  }
}

// Would catch opacity that does not know stretch, or thins along one direction alone.
TEST_CASE("membrane sheets: stretched, tissue keeps its volume and turns glassy", "[unit]") {
  Grid grid;
  const MembraneSheets at_rest = grid.updated();
  const float stretch = GENERATE(1.5F, 2.0F);
  const bool is_along = GENERATE(true, false);
  for (SheetLinkState& state : grid.states) {
    if (is_along) {
      state.second.z() *= stretch;
    } else {
      state.first.head<2>() *= stretch;
      state.second.head<2>() *= stretch;
    }
  }
  const MembraneSheets stretched = grid.updated();
  // in the middle of a side: nearer to the corners, rows are not where links are
  const float before =
      at_rest.curtain().colors[middle_of(at_rest.curtain(), Grid().states[at(3, 0)])].w();
  const float after =
      stretched.curtain().colors[middle_of(stretched.curtain(), grid.states[at(3, 0)])].w();
  CHECK(1 - after == Approx(std::pow(1 - before, 1 / stretch)).epsilon(1e-3));
}

// Would catch a web between organs that touch, one as dense as the curtain, and none at all.
TEST_CASE("membrane sheets: a faint web shows where the gap is open", "[unit]") {
  Grid grid;
  grid.open(0.9e-3F);
  CHECK(grid.updated().web().triangles.empty());
  grid.open(kGap);  // long, but no longer than at rest
  CHECK(grid.updated().web().triangles.empty());
  grid.open(3e-3F);
  const MembraneSheets sheets = grid.updated();
  check_drawable(sheets.web());
  CHECK(!sheets.web().triangles.empty());
  CHECK(largest_alpha(sheets.web()) > 0.03F);
  CHECK(largest_alpha(sheets.web()) < 0.5F * largest_alpha(sheets.curtain()));
}

// Would catch spikes between organs that touch, and joints that are not drawn.
TEST_CASE("membrane sheets: links beside the membrane are ribbons once they are long", "[unit]") {
  Grid grid;
  grid.open(0.9e-3F);
  CHECK(grid.updated().ribbons().triangles.empty());
  grid.open(3e-3F);
  const MembraneSheets sheets = grid.updated();
  const Surface& ribbons = sheets.ribbons();
  check_drawable(ribbons);
  CHECK(!ribbons.triangles.empty());
  CHECK(largest_alpha(ribbons) < 0.4F);
  for (const Eigen::Vector3f& position : ribbons.positions) {
    REQUIRE((position - grid.states.back().first).head<2>().norm() < 1.5e-3F);
  }
  // a link of the membrane that has lost its neighbours is a ribbon, too
  for (SheetLinkState& state : grid.states) {
    state.is_alive = false;
  }
  grid.states[at(2, 2)].is_alive = true;
  CHECK(grid.updated().ribbons().triangles.size() == ribbons.triangles.size());
  CHECK(grid.updated().curtain().triangles.empty());
}

// Would catch a seam: a sheet that ends in its own colour, or as if cut off.
TEST_CASE("membrane sheets: near an organ they are denser, of its colour, and fade into it",
          "[unit]") {
  const Grid grid;
  const MembraneSheets sheets = grid.updated();
  const Surface& curtain = sheets.curtain();
  for (Index v = 0; v < static_cast<Index>(curtain.positions.size()); v += kRow) {
    const auto color = [&](Index level) -> Eigen::Vector4f { return curtain.colors[v + level]; };
    REQUIRE((color(0).head<3>() - kFirst).norm() < 1e-5F);
    REQUIRE((color(kRow - 1).head<3>() - kSecond).norm() < 1e-5F);
    REQUIRE((color(kRow / 2).head<3>() - kTissue).norm() < 1e-5F);
    REQUIRE(color(1).w() > color(kRow / 2).w());
    REQUIRE(color(kRow - 2).w() > color(kRow / 2).w());
    REQUIRE(color(0).w() < 0.02F);
    REQUIRE(color(kRow - 1).w() < 0.02F);
  }
}

// Would catch a burn that is not drawn, one that counts beyond its cover, and a bad one that
// spreads.
TEST_CASE("membrane sheets: heat colours tissue as its two ends, each by its cover", "[unit]") {
  Grid grid;
  for (SheetLinkState& state : grid.states) {
    state.first_burn = {0.2F, 0.1F, 0, 0.8F};
    state.second_burn = {1, 1, 1, 0};
  }
  const float nan = std::numeric_limits<float>::quiet_NaN();
  grid.states[at(3, 0)].second_burn = {nan, 0, 0, 1};
  const MembraneSheets sheets = grid.updated();
  check_drawable(sheets.curtain());
  const Index v = middle_of(sheets.curtain(), grid.states[at(3, 0)]);
  const Eigen::Vector3f expected = 0.6F * kTissue + 0.4F * Eigen::Vector3f(0.2F, 0.1F, 0);
  CHECK((sheets.curtain().colors[v].head<3>() - expected).norm() < 1e-5F);
  const MembraneSheets unburnt = Grid().updated();
  CHECK(sheets.curtain().colors[v].w() > unburnt.curtain().colors[v].w());
}

// Would catch one vertex that takes the whole sheet away, or is passed on to the renderer.
TEST_CASE("membrane sheets: links that are not finite or without length are left out", "[unit]") {
  Grid grid;
  grid.open(3e-3F);
  const float infinity = std::numeric_limits<float>::infinity();
  grid.states[at(2, 0)].second.y() = infinity;
  grid.states[at(3, 3)].first.x() = std::numeric_limits<float>::quiet_NaN();
  grid.states[at(4, 4)].second = grid.states[at(4, 4)].first;
  grid.states[at(0, 5)].second = grid.states[at(0, 5)].first;
  const MembraneSheets sheets = grid.updated();
  for (const Surface& surface : sheets.surfaces()) {
    check_drawable(surface);
    CHECK(!surface.triangles.empty());
  }
  for (SheetLinkState& state : grid.states) {
    state.first = state.second = Eigen::Vector3f::Zero();
  }
  const MembraneSheets flat = grid.updated();
  for (const Surface& surface : flat.surfaces()) {
    check_drawable(surface);
    CHECK(surface.triangles.empty());
  }
}

// Would catch leftovers of an earlier update, and arrays that are made anew in each.
TEST_CASE("membrane sheets: they depend on the last states alone and keep their buffers",
          "[unit]") {
  Grid grid;
  grid.open(3e-3F);
  MembraneSheets sheets = grid.updated();
  const Triangle* triangles = sheets.web().triangles.data();
  const Grid before = grid;
  for (const Index l : {at(0, 0), at(1, 0), at(1, 1), at(4, 3)}) {
    grid.states[l].is_alive = false;
  }
  sheets.update(grid.states);
  const MembraneSheets fresh = grid.updated();
  for (std::size_t i = 0; i < fresh.surfaces().size(); ++i) {
    CHECK(same(sheets.surfaces()[i], fresh.surfaces()[i]));
  }
  sheets.update(before.states);  // as an undo brings links back
  const MembraneSheets first = before.updated();
  for (std::size_t i = 0; i < first.surfaces().size(); ++i) {
    CHECK(same(sheets.surfaces()[i], first.surfaces()[i]));
  }
  const Eigen::Vector3f* grown = sheets.curtain().positions.data();
  sheets.update(grid.states);
  CHECK(sheets.curtain().positions.data() == grown);
  CHECK(sheets.web().triangles.data() == triangles);
}

TEST_CASE("membrane sheets: what does not fit is refused by name", "[unit]") {
  Grid grid;
  MembraneSheets sheets = grid.sheets();
  CHECK(sheets.curtain().triangles.empty());
  grid.states.pop_back();
  CHECK_THROWS_WITH(sheets.update(grid.states),
                    ContainsSubstring("37 links") && ContainsSubstring("36"));
  grid.triangles[3][1] = 37;
  CHECK_THROWS_WITH(grid.sheets(), ContainsSubstring("triangle 3") && ContainsSubstring("link 37"));
  grid.triangles[3][1] = 0;
  grid.links[5].first.y() = std::numeric_limits<float>::quiet_NaN();
  CHECK_THROWS_WITH(grid.sheets(), ContainsSubstring("link 5"));
}

}  // namespace cholecystectomy
