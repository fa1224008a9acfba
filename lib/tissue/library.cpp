// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/tissue/library.h"

#include <array>
#include <cmath>
#include <utility>

#include "pbdsurg/base/error.h"

#include "lib/tissue/usual_ranges.h"

namespace pbdsurg {
namespace {

constexpr float kPoissonsRatio = 0.45F;
constexpr float kDamping = 1e-3F;      // s
constexpr float kUsualStretch = 1.5F;  // an estimate

struct Elasticity {
  float youngs_modulus;  // Pa
  float max_stretch = kUsualStretch;
  bool is_tube = false;
};

struct Heat {
  double specific_heat;            // J/(kg K)
  double conductivity;             // W/(m K)
  double water_fraction;           // by mass
  double electrical_conductivity;  // S/m
  double perfusion;                // ml of blood per minute and kg
  double collagen_contraction;
  DamageKinetics damage;
  double coagulated_stiffness = 1;
};

TissueRecord make_tissue(const char* name, double density, const Elasticity& elasticity,
                         const Heat& heat, TissueLook look) {
  return {.name = name,
          .mechanics = {.density = static_cast<float>(density),
                        .model = ElasticModel::neo_hookean,
                        .has_volume_constraints = !elasticity.is_tube,
                        .youngs_modulus = elasticity.youngs_modulus,
                        .poissons_ratio = kPoissonsRatio,
                        .damping = kDamping,
                        .max_stretch = elasticity.max_stretch},
          .heat = {.density = density,
                   .specific_heat = heat.specific_heat,
                   .conductivity = heat.conductivity,
                   .water_fraction = heat.water_fraction,
                   .electrical_conductivity = heat.electrical_conductivity,
                   .perfusion = perfusion_per_second(heat.perfusion, density),
                   .collagen_contraction = heat.collagen_contraction,
                   .damage = heat.damage,
                   .coagulated_stiffness = heat.coagulated_stiffness},
          .look = std::move(look)};
}

enum Place : std::size_t {
  kLiver,
  kGallbladderWall,
  kFat,
  kBileDuct,
  kArtery,
  kMembrane,
  kAbdominalWall,
  kBlood,
  kTissueCount
};

using Records = std::array<TissueRecord, kTissueCount>;

// Sources, and why these: library.h.
Records make_records() {
  Records records;
  records[kLiver] = make_tissue("liver", 1079, {.youngs_modulus = 5.2e3F, .max_stretch = 1.46F},
                                {3540, 0.52, 0.72, 0.30, 860, 0, kLiverCoagulation, 7},
                                {.color = {0.53F, 0.28F, 0.24F},
                                 .mottle = {0.46F, 0.225F, 0.195F},
                                 .gloss = 0.75F,
                                 .detail_size = 0.0035F,
                                 .relief = 0.16F});
  records[kGallbladderWall] =
      make_tissue("gallbladder_wall", 1071, {.youngs_modulus = 250e3F, .max_stretch = 1.54F},
                  {3716, 0.52, 0.75, 0.90, 30, 0.3, kLiverCoagulation},
                  {.color = {0.62F, 0.68F, 0.56F},
                   .mottle = {0.47F, 0.58F, 0.52F},
                   .gloss = 0.9F,
                   .detail_size = 0.005F,
                   .relief = 0.16F,
                   .vessels = 0.75F});
  records[kFat] = make_tissue("fat", 911, {.youngs_modulus = 3.3e3F},
                              {2348, 0.21, 0.15, 0.044, 33, 0, kFatDamage},
                              {.color = {0.95F, 0.82F, 0.52F},
                               .mottle = {0.92F, 0.74F, 0.42F},
                               .gloss = 0.7F,
                               .detail_size = 0.0035F,
                               .relief = 0.2F,
                               .lobules = 1,
                               .vessels = 0.25F});
  records[kBileDuct] = records[kGallbladderWall];
  records[kBileDuct].name = "bile_duct";
  records[kBileDuct].mechanics.youngs_modulus = 480e3F;
  records[kBileDuct].mechanics.max_stretch = kUsualStretch;
  records[kBileDuct].mechanics.has_volume_constraints = false;
  records[kBileDuct].look = {.color = {0.80F, 0.78F, 0.52F},
                             .mottle = {0.70F, 0.70F, 0.44F},
                             .gloss = 0.8F,
                             .detail_size = 0.002F,
                             .relief = 0.15F,
                             .vessels = 0.3F};
  records[kArtery] =
      make_tissue("artery", 1102, {.youngs_modulus = 610e3F, .max_stretch = 1.88F, .is_tube = true},
                  {3306, 0.46, 0.67, 0.324, 150, 0.3, kCollagenDenaturation},
                  {.color = {0.74F, 0.30F, 0.26F},
                   .mottle = {0.62F, 0.20F, 0.18F},
                   .gloss = 0.8F,
                   .detail_size = 0.002F,
                   .relief = 0.15F});
  records[kMembrane] = make_tissue("membrane", 1027, {.youngs_modulus = 60e3F},
                                   {2372, 0.39, 0.62, 0.35, 37, 0.3, kCollagenDenaturation},
                                   {.color = {0.92F, 0.83F, 0.76F},
                                    .mottle = {0.88F, 0.66F, 0.60F},
                                    .gloss = 0.9F,
                                    .opacity = 0.45F,
                                    .detail_size = 0.003F,
                                    .relief = 0.25F,
                                    .vessels = 0.3F});
  records[kAbdominalWall] = make_tissue("abdominal_wall", 1090, {.youngs_modulus = 32e3F},
                                        {3421, 0.49, 0.75, 0.446, 37, 0, kLiverCoagulation},
                                        {.color = {0.80F, 0.52F, 0.47F},
                                         .mottle = {0.72F, 0.40F, 0.37F},
                                         .gloss = 0.55F,
                                         .detail_size = 0.010F,
                                         .relief = 0.3F,
                                         .vessels = 0.5F});
  records[kBlood] = make_tissue("blood", kDensityOfBlood, {.youngs_modulus = 1e3F},
                                {kSpecificHeatOfBlood, 0.52, 0.79, 0.748, 0, 0, kLiverCoagulation},
                                {.color = {0.42F, 0.04F, 0.04F},
                                 .mottle = {0.30F, 0.02F, 0.03F},
                                 .gloss = 0.95F,
                                 .relief = 0.05F});
  return records;
}

const Records& records() {
  static const Records made = make_records();
  return made;
}

}  // namespace

std::vector<std::string> find_unphysical(const TissueRecord& tissue) {
  std::vector<std::string> found = find_unphysical(tissue.heat);
  const Material& mechanics = tissue.mechanics;
  if (mechanics.density != static_cast<float>(tissue.heat.density)) {
    found.push_back(tissue_statement("density of mechanics", mechanics.density,
                                     "that of heat is " + std::to_string(tissue.heat.density)));
  }
  expect_usual(found, "Young's modulus", mechanics.youngs_modulus, 50, 1e8, "Pa");
  expect_usual(found, "Poisson's ratio", mechanics.poissons_ratio, 0.3, 0.5, "");
  expect_usual(found, "damping", mechanics.damping, 0, 1, "s");
  if (!std::isinf(mechanics.max_stretch)) {  // no limit
    expect_usual(found, "largest stretch", mechanics.max_stretch, 1.02, 5, "");
  }

  const TissueLook& look = tissue.look;
  for (const Eigen::Vector3f& color : {look.color, look.mottle}) {
    for (const float channel : color) {
      expect_usual(found, "channel of colour", channel, 0, 1, "");
    }
  }
  expect_usual(found, "gloss", look.gloss, 0, 1, "");
  expect_usual(found, "opacity", look.opacity, 0, 1, "");
  expect_usual(found, "size of detail", look.detail_size, 1e-5, 0.1, "m");
  expect_usual(found, "relief", look.relief, 0, 1, "");
  expect_usual(found, "lobules", look.lobules, 0, 1, "");
  expect_usual(found, "vessels", look.vessels, 0, 1, "");
  for (std::string& sentence : found) {
    sentence = tissue.name + ": " + sentence;
  }
  return found;
}

namespace tissues {

const TissueRecord& liver() {
  return records()[kLiver];
}

const TissueRecord& gallbladder_wall() {
  return records()[kGallbladderWall];
}

const TissueRecord& fat() {
  return records()[kFat];
}

const TissueRecord& bile_duct() {
  return records()[kBileDuct];
}

const TissueRecord& artery() {
  return records()[kArtery];
}

const TissueRecord& membrane() {
  return records()[kMembrane];
}

const TissueRecord& abdominal_wall() {
  return records()[kAbdominalWall];
}

const TissueRecord& blood() {
  return records()[kBlood];
}

std::span<const TissueRecord> all() {
  return records();
}

const TissueRecord& find(std::string_view name) {
  std::string names;
  for (const TissueRecord& tissue : records()) {
    if (tissue.name == name) {
      return tissue;
    }
    names += (names.empty() ? "" : ", ") + tissue.name;
  }
  throw InvalidArgument("there is no tissue '" + std::string(name) + "'; there are " + names);
}

}  // namespace tissues
}  // namespace pbdsurg
