// SPDX-License-Identifier: Apache-2.0
#include "bench/figure4/burn.h"

#include <array>

#include "pbdsurg/tissue/library.h"

namespace pbdsurg::bench {
namespace {

constexpr double kStep = 10e-3;    // s
constexpr Index kTexels = 7;       // along an edge of a triangle
constexpr double kPower = 30;      // W
constexpr double kCurrent = 0.15;  // A; the paper does not print its own

Scene scene_of(const TetMesh& gallbladder) {
  Scene scene;
  scene.add_body("gallbladder", gallbladder);
  return scene;
}

}  // namespace

BurnModel physical_burn() {
  return {"physical", {}, cut_settings(kPower)};
}

BurnModel paper_burn() {
  CauteryOptions options;
  options.model = ThermalModel::paper();
  options.electrode_cooling = 0;
  return {"paper", options, known_current_settings(kCurrent)};
}

Burn::Burn(const TetMesh& gallbladder, const Eigen::Vector3f& tip, const BurnModel& model)
    : electrode_{tip, tip},
      generator_(model.generator),
      solver_(scene_of(gallbladder)),
      cautery_(solver_.tissue(), std::array{ThermalBody{0, tissues::gallbladder_wall().heat}},
               model.cautery),
      surface_(shared_surface(solver_.tissue(), 0)),
      texture_(kTexels) {}

void Burn::run_to(double time) {
  for (; (steps_ + 0.5) * kStep < time; ++steps_) {
    report_ = cautery_.update(solver_, electrode_, generator_, kStep);
    removed_volume_ += report_.removed_volume;
  }
  // temperatures as they are now, as the paper's figure has them
  map_.update(*surface_,
              {field().temperatures(), field().survival(), field().water(), field().charred()});
  texture_.update(*surface_, map_);
}

}  // namespace pbdsurg::bench
