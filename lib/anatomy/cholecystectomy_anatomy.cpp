// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/anatomy/cholecystectomy_anatomy.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/surface_distance.h"

#include "lib/anatomy/wall_cells.h"
#include "lib/base/describe.h"
#include "lib/mesh/outer_surface.h"

namespace pbdsurg {
namespace {

constexpr int kBall = 1;  // Euler number of a solid organ
constexpr int kHollowBall = 2;

OrganRecipe recipe(const ImplicitShape& shape, double spacing) {
  TetrahedralizeOptions options;
  options.spacing = spacing;
  options.euler = kBall;
  return {[shape](double) { return shape; }, options};
}

OrganRecipe wall_recipe(const ImplicitShape& outer, double thickness) {
  if (!(thickness > 0) || !std::isfinite(thickness)) {
    throw InvalidArgument("the wall of the gallbladder is " + describe(thickness) +
                          " m thick; this must be positive and finite");
  }
  TetrahedralizeOptions options;
  options.spacing = kWallCellsPerThickness * thickness;
  options.euler = kHollowBall;
  const auto shape = [=](double spacing) {
    return shell_shape(outer, std::max(thickness, spacing / kWallCellsPerThickness));
  };
  return {shape, options};
}

TetMesh make_own(Organ organ, const OrganSource& source, double wall_thickness) {
  const auto* mesh = std::get_if<TetMesh>(&source);
  return mesh != nullptr ? *mesh
                         : fill_organ(organ, std::get<ImplicitShape>(source), wall_thickness).mesh;
}

TetMesh make_built_in(Organ organ, const ImplicitShape& gallbladder, bool is_own_gallbladder,
                      const CholecystectomyOptions& options) {
  OrganRecipe recipe = organ_recipe(organ, gallbladder, options.wall_thickness);
  recipe.options.spacing *= options.coarsening;
  if (is_own_gallbladder) {
    recipe.options.euler.reset();  // a strange gallbladder may cut its bed to pieces
  }
  return tetrahedralize(recipe.shape, recipe.options).mesh;
}

ImplicitShape outside_of(const OrganSource& source) {
  const auto* mesh = std::get_if<TetMesh>(&source);
  return mesh != nullptr ? filled_shape(*mesh) : std::get<ImplicitShape>(source);
}

}  // namespace

const char* name_of(Organ organ) {
  switch (organ) {
    case Organ::gallbladder:
      return "gallbladder";
    case Organ::liver:
      return "liver";
    case Organ::cystic_duct:
      return "cystic_duct";
    case Organ::cystic_artery:
      return "cystic_artery";
    case Organ::common_bile_duct:
      return "common_bile_duct";
    case Organ::calot_fat:
      return "calot_fat";
  }
  throw InvalidArgument("there is no organ " + std::to_string(static_cast<int>(organ)));
}

LengthRange plausible_length(Organ organ) {
  switch (organ) {
    case Organ::gallbladder:
      return {0.03, 0.25};
    case Organ::liver:
      return {0.06, 0.45};
    case Organ::cystic_duct:
    case Organ::cystic_artery:
      return {0.01, 0.095};
    case Organ::common_bile_duct:
      return {0.025, 0.2};
    case Organ::calot_fat:
      return {0.015, 0.12};
  }
  throw InvalidArgument("there is no organ " + std::to_string(static_cast<int>(organ)));
}

OrganRecipe organ_recipe(Organ organ, const ImplicitShape& gallbladder, double wall_thickness) {
  // Spacings that resolve the thinnest part of each organ, and that give liver and gallbladder the
  // sizes of the paper's largest meshes.
  switch (organ) {
    case Organ::gallbladder:
      return wall_recipe(gallbladder, wall_thickness);
    case Organ::liver:
      return recipe(liver_bed(gallbladder), 6.8e-3);
    case Organ::cystic_duct:
      return recipe(cystic_duct(), 1.05e-3);
    case Organ::cystic_artery:
      return recipe(cystic_artery(), 0.9e-3);
    case Organ::common_bile_duct:
      return recipe(common_bile_duct(), 1.8e-3);
    case Organ::calot_fat:
      return recipe(calot_fat(gallbladder), 1.9e-3);
  }
  throw InvalidArgument("there is no organ " + std::to_string(static_cast<int>(organ)));
}

Tetrahedralization fill_organ(Organ organ, const ImplicitShape& shape, double wall_thickness,
                              Index vertex_count) {
  OrganRecipe recipe = organ_recipe(organ, shape, wall_thickness);
  if (organ != Organ::gallbladder) {
    recipe.shape = [&shape](double) { return shape; };
  }
  recipe.options.euler.reset();
  recipe.options.vertex_count = vertex_count;
  return tetrahedralize(recipe.shape, recipe.options);
}

CholecystectomyAnatomy make_cholecystectomy_anatomy(const CholecystectomyOptions& options) {
  if (!(options.coarsening > 0) || !std::isfinite(options.coarsening)) {
    throw InvalidArgument("the coarsening of the organs is " + describe(options.coarsening) +
                          "; it must be positive and finite");
  }
  const auto own_gallbladder = options.own.find(Organ::gallbladder);
  const ImplicitShape outer = own_gallbladder != options.own.end()
                                  ? outside_of(own_gallbladder->second)
                                  : gallbladder_outer();
  CholecystectomyAnatomy anatomy;
  for (const Organ organ : kOrgans) {
    const auto own = options.own.find(organ);
    try {
      anatomy.organs[organ] =
          own != options.own.end()
              ? make_own(organ, own->second, options.wall_thickness)
              : make_built_in(organ, outer, own_gallbladder != options.own.end(), options);
    } catch (const InvalidMesh& error) {
      throw InvalidMesh(std::string(name_of(organ)) + ": " + error.what());
    }
  }
  anatomy.abdominal_wall = abdominal_wall();
  return anatomy;
}

ImplicitShape filled_shape(const TetMesh& mesh) {
  const MeshData surface = outer_surface(mesh.positions(), mesh.tets());
  return surface_shape(surface.points, surface.triangles);
}

}  // namespace pbdsurg
