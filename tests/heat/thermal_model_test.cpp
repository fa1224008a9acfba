// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/heat/thermal_model.h"

#include <cmath>
#include <limits>

#include "pbdsurg/base/error.h"

#include "tests/support/catch.h"

namespace pbdsurg {

using testing::Approx;
using testing::ContainsSubstring;

// Would catch a preset that is refused, and one whose tissue is not the one printed in the paper.
TEST_CASE("thermal model: presets are valid and say what is unphysical in them", "[unit]") {
  CHECK_NOTHROW(check_model(ThermalModel::physical()));
  CHECK_FALSE(ThermalModel::physical().tissue.has_value());

  const ThermalModel paper = ThermalModel::paper();
  CHECK_NOTHROW(check_model(paper));
  // 0.57 mm^2/s, four times that of tissue
  CHECK(paper.tissue->conductivity / (paper.tissue->density * paper.tissue->specific_heat) ==
        Approx(0.57e-6).epsilon(0.01));
  CHECK(paper.tissue->electrical_conductivity == 0.9);
  CHECK(find_unphysical(*paper.tissue).size() == 1);  // specific heat

  ThermalModel literal = paper;  // as printed
  literal.tissue->density = 3;
  literal.tissue->specific_heat = 0.3;
  CHECK_NOTHROW(check_model(literal));
  CHECK(literal.tissue->density * literal.tissue->specific_heat == Approx(0.9));
  CHECK(find_unphysical(*literal.tissue).size() == 3);  // density, specific heat, diffusivity
}

TEST_CASE("thermal model: bad settings are refused by name", "[unit]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto with = [](auto setting, auto value) {
    ThermalModel model;
    model.*setting = value;
    return model;
  };
  for (const double bad : {0.49, 1.01, nan}) {
    CHECK_THROWS_WITH(check_model(with(&ThermalModel::theta, bad)), ContainsSubstring("theta"));
  }
  for (const double bad : {0.0, 1.0, nan}) {
    CHECK_THROWS_WITH(check_model(with(&ThermalModel::dry_water, bad)),
                      ContainsSubstring("dry_water"));
  }
  CHECK_THROWS_WITH(check_model(with(&ThermalModel::surface_transfer, -1.0)),
                    ContainsSubstring("surface_transfer"));
  CHECK_THROWS_WITH(check_model(with(&ThermalModel::ambient_temperature, nan)),
                    ContainsSubstring("ambient_temperature"));
  CHECK_THROWS_WITH(check_model(with(&ThermalModel::has_latent_heat, false)),
                    ContainsSubstring("has_latent_heat"));
  CHECK_THROWS_WITH(check_model(with(&ThermalModel::tissue, ThermalProperties{0, 1, 1, 0})),
                    ContainsSubstring("density"));
}

}  // namespace pbdsurg
