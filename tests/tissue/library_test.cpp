// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/tissue/library.h"

#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/solver.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"

namespace pbdsurg {
namespace {

using testing::ContainsSubstring;

// Every function of the library beside the name that find() knows it by.
const std::array kNamed{std::pair{"liver", &tissues::liver},
                        std::pair{"gallbladder_wall", &tissues::gallbladder_wall},
                        std::pair{"fat", &tissues::fat},
                        std::pair{"bile_duct", &tissues::bile_duct},
                        std::pair{"artery", &tissues::artery},
                        std::pair{"membrane", &tissues::membrane},
                        std::pair{"abdominal_wall", &tissues::abdominal_wall},
                        std::pair{"blood", &tissues::blood}};

}  // namespace

// Would catch records in each other's place, and one that the enumeration leaves out or has twice.
TEST_CASE("library: every tissue is enumerated once and found by its name", "[unit]") {
  CHECK(tissues::all().size() == kNamed.size());
  std::set<std::string> names;
  for (const TissueRecord& tissue : tissues::all()) {
    CHECK(names.insert(tissue.name).second);
    CHECK(&tissues::find(tissue.name) == &tissue);
  }
  for (const auto& [name, function] : kNamed) {
    CHECK(function().name == name);
    CHECK(&tissues::find(name) == &function());
  }
}

TEST_CASE("library: an unknown name is refused with the names that there are", "[unit]") {
  for (const char* const wrong : {"spleen", "", "Liver", "liver "}) {
    CHECK_THROWS_AS(tissues::find(wrong), InvalidArgument);
    CHECK_THROWS_WITH(tissues::find(wrong),
                      ContainsSubstring("'" + std::string(wrong) + "'; there are liver, gall"));
  }
  CHECK_THROWS_WITH(tissues::find("spleen"), ContainsSubstring("abdominal_wall, blood"));
}

// Would catch a number in the wrong unit or column.
TEST_CASE("library: every tissue is valid and physical", "[unit]") {
  for (const TissueRecord& tissue : tissues::all()) {
    INFO(tissue.name);
    CHECK_NOTHROW(check_thermal_properties(tissue.heat));
    CHECK(find_unphysical(tissue) == std::vector<std::string>());
    CHECK(tissue.mechanics.density == tissue.heat.density);
    CHECK((tissue.heat.density > 900 && tissue.heat.density < 1150));
    CHECK(tissue.mechanics.model == ElasticModel::neo_hookean);
    CHECK((tissue.mechanics.youngs_modulus >= 500 && tissue.mechanics.youngs_modulus <= 1e6));
  }
  // from soft to stiff
  const TissueRecord* softer = &tissues::blood();
  for (const TissueRecord* stiffer :
       {&tissues::fat(), &tissues::liver(), &tissues::abdominal_wall(), &tissues::membrane(),
        &tissues::gallbladder_wall(), &tissues::bile_duct(), &tissues::artery()}) {
    INFO(stiffer->name);
    CHECK(softer->mechanics.youngs_modulus < stiffer->mechanics.youngs_modulus);
    softer = stiffer;
  }
  CHECK(tissues::membrane().look.opacity < 1);
}

// The sources' own numbers: shear moduli, and true strains at failure.
TEST_CASE("library: moduli and largest stretches are those of the review they come from",
          "[validation]") {
  const auto close = [](double value, double expected) {
    return std::abs(value - expected) < 0.02 * expected;
  };
  const auto shear = [](const TissueRecord& tissue) {
    return tissue.mechanics.youngs_modulus / (2 * (1 + tissue.mechanics.poissons_ratio));
  };
  CHECK(close(shear(tissues::liver()), 1.8e3));
  CHECK(close(shear(tissues::gallbladder_wall()), 85e3));
  CHECK(close(shear(tissues::bile_duct()), 166e3));
  CHECK(close(shear(tissues::artery()), 210e3));
  CHECK(close(std::log(tissues::liver().mechanics.max_stretch), 0.38));
  CHECK(close(std::log(tissues::gallbladder_wall().mechanics.max_stretch), 0.43));
  CHECK(close(std::log(tissues::artery().mechanics.max_stretch), 0.63));
}

// One value after the other gets out of range.
TEST_CASE("library: what is unphysical is told with the tissue's name", "[unit]") {
  const auto only = [](auto&& change) {
    TissueRecord tissue = tissues::liver();
    change(tissue);
    const auto found = find_unphysical(tissue);
    REQUIRE(found.size() == 1);
    CHECK_THAT(found[0], ContainsSubstring("liver: tissue "));
    return found[0];
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  CHECK(only([](TissueRecord& t) { t.mechanics.density = 1000; }) ==
        "liver: tissue density of mechanics is 1000; that of heat is 1079.000000");
  CHECK(only([](TissueRecord& t) { t.mechanics.youngs_modulus = 5.2F; }) ==
        "liver: tissue Young's modulus is 5.2; soft tissue has 50 to 1e+08 Pa");
  CHECK_THAT(only([&](TissueRecord& t) { t.mechanics.youngs_modulus = nan; }),
             ContainsSubstring("Young's modulus is nan"));
  CHECK_THAT(only([](TissueRecord& t) { t.mechanics.poissons_ratio = 0; }),
             ContainsSubstring("Poisson's ratio"));
  CHECK_THAT(only([](TissueRecord& t) { t.mechanics.damping = 2; }), ContainsSubstring("damping"));
  CHECK_THAT(only([](TissueRecord& t) { t.mechanics.max_stretch = 46; }),
             ContainsSubstring("largest stretch"));
  CHECK_THAT(only([](TissueRecord& t) { t.heat.perfusion = 860; }), ContainsSubstring("perfusion"));
  CHECK_THAT(only([](TissueRecord& t) { t.look.color.x() = 135; }), ContainsSubstring("135"));
  CHECK_THAT(only([&](TissueRecord& t) { t.look.mottle.y() = nan; }), ContainsSubstring("colour"));
  CHECK_THAT(only([](TissueRecord& t) { t.look.detail_size = 3.5F; }), ContainsSubstring("detail"));
  CHECK_THAT(only([](TissueRecord& t) { t.look.gloss = -1; }), ContainsSubstring("gloss"));
}

TEST_CASE("library: every tissue makes a body that steps, as a solid and as springs",
          "[unit][long]") {
  const TetMesh mesh = testing::make_box({4, 2, 2}, 2e-3);
  for (const TissueRecord& tissue : tissues::all()) {
    INFO(tissue.name);
    Scene scene;
    scene.add_body("solid", mesh, tissue.mechanics);
    scene.add_body("springs", mesh, springs(mesh, tissue.mechanics));
    for (const Index body : {0, 1}) {
      scene.fix_where(body, [](const Eigen::Vector3d& x) { return x.x() < 1e-3; });
    }
    Solver solver(scene);
    StepReport report;
    for (int i = 0; i < 50; ++i) {
      report = solver.step(0.01F);
    }
    CHECK(report.non_finite_vertices == 0);
    CHECK(report.inverted_tets == 0);
  }
  CHECK_FALSE(springs(mesh, tissues::artery().mechanics).has_volume_constraints);
  CHECK_FALSE(springs(mesh, tissues::bile_duct().mechanics).has_volume_constraints);
  CHECK(springs(mesh, tissues::liver().mechanics).has_volume_constraints);
}

}  // namespace pbdsurg
