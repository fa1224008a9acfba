// SPDX-License-Identifier: Apache-2.0
#include "bench/statics/cases.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

#include "pbdsurg/mesh/implicit_shape.h"
#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/tissue/library.h"

#include "bench/support/neo_hookean.h"
#include "tests/support/meshes.h"

namespace pbdsurg::bench {
namespace {

constexpr float kGravity = 9.81F;  // m/s^2

std::string in_kilopascals(double pascals) {
  return std::to_string(std::lround(pascals / 1000)) + " kPa";
}

// @param gravity  m/s^2, downwards along y
Case make_case(const std::string& name, TetMesh mesh, const Material& material, float gravity) {
  Case each;
  each.name = name;
  each.scene.add_body("first", std::move(mesh), material);
  each.scene.set_gravity({0, -gravity, 0});
  return each;
}

std::vector<Index> vertices_where(const Scene& scene,
                                  const std::function<bool(const Eigen::Vector3d&)>& is_in) {
  std::vector<Index> result;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    if (is_in(scene.positions()[v])) {
      result.push_back(v);
    }
  }
  return result;
}

// 2 omega of the lowest mode of a bar that is held at one end.
double critical_drag(double youngs_modulus, double length) {
  return std::numbers::pi * std::sqrt(youngs_modulus / 1000) / length;
}

// Likewise of a square bar that bends (Euler and Bernoulli).
double critical_drag_of_bending(double youngs_modulus, double length, double height) {
  constexpr double kFirstMode = 1.8751 * 1.8751;
  return 2 * kFirstMode * std::sqrt(youngs_modulus / (12 * 1000)) * height / (length * length);
}

// Of 10 x 60 x 10 mm, held at the top, under its weight.
Case hanging_bar(const std::string& name, const Material& material) {
  constexpr double kEdge = 10e-3 / 3;
  Case each =
      make_case("hanging bar, " + name, testing::make_box({3, 18, 3}, kEdge), material, kGravity);
  const double top = 18 * kEdge;
  each.scene.fix_where(0, [&](const Eigen::Vector3d& x) { return x.y() > top - 0.5 * kEdge; });
  each.tip = vertices_where(each.scene, [](const Eigen::Vector3d& x) { return x.y() < 1e-6; });
  each.drag = critical_drag(material.youngs_modulus, top);
  return each;
}

// Of a usual material, but for one number.
std::vector<Case> hanging_bars() {
  std::vector<Case> cases;
  for (const double pascals : {5e3, 20e3, 80e3, 320e3}) {
    cases.push_back(hanging_bar(in_kilopascals(pascals), neo_hookean(pascals, 0.45)));
    cases.back().steps_ms.push_back(33);
  }
  cases.push_back(hanging_bar("20 kPa, Poisson's ratio 0.3", neo_hookean(20e3, 0.3)));
  cases.push_back(hanging_bar("20 kPa, Poisson's ratio 0.49", neo_hookean(20e3, 0.49)));
  Material rubs = neo_hookean(20e3, 0.45);
  rubs.damping = 5e-3F;
  cases.push_back(hanging_bar("20 kPa, friction of 5 ms", rubs));
  return cases;
}

// A solid ellipsoid of 100 x 30 x 60 mm, of the stiffness of a gallbladder's wall, pulled by a
// grasp.
Case pulled_ellipsoid() {
  const ImplicitShape shape = ellipsoid_shape({0, 0, 0}, {50e-3, 15e-3, 30e-3});
  TetrahedralizeOptions options;
  options.spacing = 6e-3;
  Case each = make_case("ellipsoid of 250 kPa, pulled by 20 mm",
                        tetrahedralize(shape, options).mesh, neo_hookean(250e3, 0.45), 0);
  each.scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < -40e-3; });
  each.pull =
      Pull{vertices_where(each.scene, [](const Eigen::Vector3d& x) { return x.x() > 43e-3; }),
           {0, 20e-3, 0}};
  each.drag = critical_drag(250e3, 0.1);
  return each;
}

// Half of the length more, by all vertices of an end.
Case stretched_block(double youngs_modulus) {
  constexpr double kEdge = 5e-3;
  Case each = make_case("block of " + in_kilopascals(youngs_modulus) + ", stretched by 50 %",
                        testing::make_box({6, 4, 4}, kEdge), neo_hookean(youngs_modulus, 0.45), 0);
  each.scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 1e-6; });
  each.pull = Pull{
      vertices_where(each.scene, [](const Eigen::Vector3d& x) { return x.x() > 6 * kEdge - 1e-6; }),
      {15e-3, 0, 0}};
  each.drag = critical_drag(youngs_modulus, 30e-3);
  return each;
}

// Of the friction and the limit of stretch that its tissue has, lifted by a grasp as
// examples/tools.cpp does.
Case lifted_liver() {
  const ImplicitShape box = rounded_box_shape({0, -15e-3, 0}, {30e-3, 15e-3, 30e-3}, 2e-3);
  TetrahedralizeOptions options;
  options.spacing = 4e-3;
  const Material liver = tissues::liver().mechanics;
  Case each = make_case("liver with its friction, lifted by 8 mm",
                        tetrahedralize(box, options).mesh, liver, kGravity);
  each.scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.y() < -28e-3; });
  each.pull =
      Pull{vertices_where(each.scene, [](const Eigen::Vector3d& x) { return x.norm() < 6e-3; }),
           {0, 8e-3, 0}};
  each.drag = critical_drag(liver.youngs_modulus, 30e-3);
  return each;
}

// A slab whose faces stay plane: a simple shear but for its free sides.
Case sheared_slab() {
  constexpr double kEdge = 2.5e-3;
  constexpr double kShear = 0.2;
  const double height = 4 * kEdge, side = 16 * kEdge;
  Case each = make_case("slab of 40 x 40 x 10 mm and 10 kPa, sheared by 20 %",
                        testing::make_box({16, 4, 16}, kEdge), neo_hookean(10e3, 0.45), 0);
  each.scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.y() < 1e-6; });
  each.pull = Pull{
      vertices_where(each.scene, [&](const Eigen::Vector3d& x) { return x.y() > height - 1e-6; }),
      {kShear * height, 0, 0}};
  each.drag = critical_drag(10e3, height);
  each.closed_form = NeoHookeanModuli(each.scene.bodies()[0].material).mu * kShear * side * side;
  return each;
}

// Of 10 x 10 x 60 mm, both ends held.
Case twisted_bar(Index cells) {
  constexpr double kSide = 10e-3;
  constexpr double kAngle = 0.3;  // rad
  const double length = 6 * kSide;
  Case each = make_case(
      "square bar of 1:6 and 20 kPa, twisted, " + std::to_string(cells) + " cells across",
      testing::make_box({6 * cells, cells, cells}, kSide / cells), neo_hookean(20e3, 0.45), 0);
  each.scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 1e-6; });
  each.twist = Twist{
      vertices_where(each.scene, [&](const Eigen::Vector3d& x) { return x.x() > length - 1e-6; }),
      kAngle,
      {length, kSide / 2, kSide / 2}};
  each.drag = critical_drag(20e3, length);
  // Saint-Venant's torsion of a square (Timoshenko and Goodier, "Theory of Elasticity", 109)
  const double stiffness =
      0.1406 * NeoHookeanModuli(each.scene.bodies()[0].material).mu * std::pow(kSide, 4);
  each.closed_form = 1e6 * stiffness * kAngle / length;
  return each;
}

// Square, 10 mm high, held at one end, under a gravity that bends it by some percent of its length.
Case cantilever(Index slenderness, Index cells, double poissons_ratio) {
  constexpr double kHeight = 10e-3;
  constexpr double kYoungsModulus = 250e3;
  const double length = slenderness * kHeight;
  const double gravity = slenderness > 4 ? 0.3 : 5;
  std::string name = "cantilever of 1:" + std::to_string(slenderness) + ", " +
                     std::to_string(cells) + " cells across";
  name += poissons_ratio > 0 ? "" : ", Poisson's ratio 0";
  Case each =
      make_case(name, testing::make_box({slenderness * cells, cells, cells}, kHeight / cells),
                neo_hookean(kYoungsModulus, poissons_ratio), static_cast<float>(gravity));
  each.scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 1e-6; });
  each.tip =
      vertices_where(each.scene, [&](const Eigen::Vector3d& x) { return x.x() > length - 1e-6; });
  each.drag = critical_drag_of_bending(kYoungsModulus, length, kHeight);
  // Timoshenko's beam under its weight, with Cowper's coefficient of shear (1966)
  const double section = kHeight * kHeight, second_moment = section * section / 12;
  const double weight = 1000 * gravity * section;  // N/m
  const double shear = 10 * (1 + poissons_ratio) / (12 + 11 * poissons_ratio) * kYoungsModulus /
                       (2 * (1 + poissons_ratio)) * section;
  each.closed_form = 1e3 * (weight * std::pow(length, 4) / (8 * kYoungsModulus * second_moment) +
                            weight * length * length / (2 * shear));
  return each;
}

std::vector<Case> cantilevers() {
  std::vector<Case> cases;
  for (const Index cells : {2, 4, 8}) {
    cases.push_back(cantilever(4, cells, 0));
  }
  cases.push_back(cantilever(4, 4, 0.45));
  for (const Index cells : {2, 4}) {
    cases.push_back(cantilever(10, cells, 0));
  }
  return cases;
}

// Without transverse strain it is a line of springs. Of 20 x 40 x 20 mm, which does not buckle.
Case standing_column() {
  constexpr double kEdge = 5e-3;
  constexpr double kYoungsModulus = 20e3;
  Case each =
      make_case("standing column of 20 kPa, Poisson's ratio 0", testing::make_box({4, 8, 4}, kEdge),
                neo_hookean(kYoungsModulus, 0), kGravity);
  const double height = 8 * kEdge;
  each.scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.y() < 1e-6; });
  each.tip =
      vertices_where(each.scene, [&](const Eigen::Vector3d& x) { return x.y() > height - 1e-6; });
  each.drag = critical_drag(kYoungsModulus, height);
  each.closed_form = 1e3 * 1000 * double{kGravity} * height * height / (2 * kYoungsModulus);
  return each;
}

Case ball_on_block() {
  constexpr double kEdge = 2e-3;
  Case each = make_case("ball of 15 mm, 1 mm deep in 10 kPa", testing::make_box({16, 8, 16}, kEdge),
                        neo_hookean(10e3, 0.45), 0);
  each.scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.y() < 1e-6; });
  const double top = 8 * kEdge;
  each.ball = Ball{15e-3, {16e-3, top + 15e-3 + 0.1e-3, 16e-3}, {0, -1.1e-3, 0}};
  each.drag = critical_drag(10e3, top);
  return each;
}

// Filled to the brim with what hardly changes its volume; walls and floor hold it.
Case bath(double poissons_ratio) {
  constexpr double kEdge = 5e-3;
  Case each = make_case(
      "bath of 5 kPa, Poisson's ratio 0." + std::to_string(std::lround(100 * poissons_ratio)),
      testing::make_box({8, 8, 8}, kEdge), neo_hookean(5e3, poissons_ratio), kGravity);
  const double side = 8 * kEdge;
  each.scene.fix_where(0, [&](const Eigen::Vector3d& x) {
    return x.y() < 1e-6 || std::min(x.x(), x.z()) < 1e-6 || std::max(x.x(), x.z()) > side - 1e-6;
  });
  each.tip = vertices_where(each.scene, [&](const Eigen::Vector3d& x) {
    return x.y() > side - 1e-6 && std::abs(x.x() - side / 2) < 11e-3 &&
           std::abs(x.z() - side / 2) < 11e-3;
  });
  each.drag = critical_drag(5e3, side);
  return each;
}

// A thousand times stiffer, hung on by links that hardly give.
Case linked_blocks() {
  constexpr double kEdge = 5e-3;
  const TetMesh upper = testing::make_box({4, 4, 4}, kEdge);
  std::vector<Eigen::Vector3d> lower(upper.positions().begin(), upper.positions().end());
  for (Eigen::Vector3d& x : lower) {
    x.y() -= 20e-3;
  }
  const auto count = static_cast<Index>(lower.size());
  Case each = make_case("5 MPa hung on 5 kPa by links of 1e-5 m/N", upper, neo_hookean(5e3, 0.45),
                        kGravity);
  each.scene.add_body("lower",
                      TetMesh(std::move(lower), {upper.tets().begin(), upper.tets().end()}),
                      neo_hookean(5e6, 0.45));
  each.scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.y() > 20e-3 - 1e-6; });
  for (Index v = 0; v < count; ++v) {
    const Eigen::Vector3d& x = each.scene.positions()[v];
    for (Index w = count; w < 2 * count && x.y() < 1e-6; ++w) {
      if ((each.scene.positions()[w] - x).norm() < 1e-6) {
        Link link{v, w, 0, {}};
        link.stiffness.compliance = 1e-5F;
        each.scene.add_link(link);
      }
    }
  }
  each.tip =
      vertices_where(each.scene, [](const Eigen::Vector3d& x) { return x.y() < -20e-3 + 1e-6; });
  each.drag = critical_drag(5e3, 40e-3);
  return each;
}

}  // namespace

std::vector<Case> make_cases(bool quick) {
  if (quick) {
    std::vector<Case> few{hanging_bar("20 kPa", neo_hookean(20e3, 0.45)), twisted_bar(2),
                          standing_column()};
    for (Case& each : few) {
      each.steps_ms = {0.2, 5};
    }
    return few;
  }
  std::vector<Case> cases = hanging_bars();
  cases.push_back(pulled_ellipsoid());
  for (const double kilopascals : {5, 50, 500}) {
    cases.push_back(stretched_block(1000 * kilopascals));
  }
  cases.push_back(sheared_slab());
  for (const Index cells : {4, 8}) {
    cases.push_back(twisted_bar(cells));
  }
  for (Case& each : cantilevers()) {
    cases.push_back(std::move(each));
  }
  cases.push_back(standing_column());
  cases.push_back(lifted_liver());
  cases.push_back(ball_on_block());
  for (const double ratio : {0.45, 0.49}) {
    cases.push_back(bath(ratio));
  }
  cases.push_back(linked_blocks());
  return cases;
}

}  // namespace pbdsurg::bench
