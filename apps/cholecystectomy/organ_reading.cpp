// SPDX-License-Identifier: Apache-2.0
#include "organ_reading.h"

#include <Eigen/Geometry>
#include <span>
#include <utility>

#include "pbdsurg/core/error.h"

namespace cholecystectomy {
namespace {

using pbdsurg::LengthUnit;
using pbdsurg::LengthUnitGuess;
using pbdsurg::MeshData;
using pbdsurg::Organ;
using pbdsurg::UnitOptions;
using Points = std::vector<Eigen::Vector3d>;

double longest_side(const Points& points) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : points) {
    box.extend(p);
  }
  return box.isEmpty() ? 0 : box.sizes().maxCoeff();
}

// Drops the points that neither tetrahedra nor triangles use.
void drop_unused_points(MeshData& mesh) {
  std::vector<bool> used(mesh.points.size(), false);
  for (const pbdsurg::Tet& tet : mesh.tets) {
    for (const pbdsurg::Index v : tet) {
      used[v] = true;
    }
  }
  for (const pbdsurg::Triangle& triangle : mesh.triangles) {
    for (const pbdsurg::Index v : triangle) {
      used[v] = true;
    }
  }
  std::vector<pbdsurg::Index> new_id(mesh.points.size(), pbdsurg::kInvalidIndex);
  Points points;
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (used[v]) {
      new_id[v] = static_cast<pbdsurg::Index>(points.size());
      points.push_back(mesh.points[v]);
    }
  }
  mesh.points = std::move(points);
  for (pbdsurg::Tet& tet : mesh.tets) {
    for (pbdsurg::Index& v : tet) {
      v = new_id[v];
    }
  }
  for (pbdsurg::Triangle& triangle : mesh.triangles) {
    for (pbdsurg::Index& v : triangle) {
      v = new_id[v];
    }
  }
}

std::vector<OwnOrgan> read_files(const std::map<Organ, std::filesystem::path>& paths,
                                 const UnitOptions& unit) {
  std::vector<OwnOrgan> organs;
  for (const auto& [organ, path] : paths) {  // in the order of kOrgans: gallbladder, liver ...
    pbdsurg::MeshFile file = pbdsurg::read_mesh_file(path, unit.read_options());
    pbdsurg::orient_majority(file.mesh);
    if (!file.mesh.tets.empty()) {
      file.mesh.triangles.clear();  // a surface beside tetrahedra is theirs
    }
    drop_unused_points(file.mesh);
    if (file.mesh.points.empty()) {
      throw pbdsurg::InvalidMesh(path.string() + ": there are no tetrahedra and no triangles");
    }
    file.longest_side = longest_side(file.mesh.points);
    organs.push_back({organ, std::string("the ") + pbdsurg::name_of(organ) + " of " + path.string(),
                      path.filename().string(), std::move(file), unit.is_guessed()});
  }
  return organs;
}

// Takes the unit that files state, or for all others the one that they share.
void settle_units(std::vector<OwnOrgan>& organs, std::vector<Warning>& warnings) {
  std::vector<pbdsurg::MeasuredLength> sides;
  for (OwnOrgan& own : organs) {
    if (own.is_guessed && own.file.stated_unit) {
      pbdsurg::set_unit(own.file, *own.file.stated_unit);
      own.is_guessed = false;
    } else if (own.is_guessed) {
      sides.push_back({own.file.longest_side, pbdsurg::plausible_length(own.organ)});
    }
  }
  if (sides.empty()) {
    return;
  }
  const LengthUnitGuess guess = pbdsurg::guess_length_unit(sides);
  std::string readings, names;
  for (OwnOrgan& own : organs) {
    if (own.is_guessed) {
      const std::span<const LengthUnit> units =
          guess.plausible.empty() ? std::span<const LengthUnit>(pbdsurg::kLengthUnits)
                                  : std::span<const LengthUnit>(guess.plausible);
      readings +=
          own.name + " would be " + pbdsurg::describe_readings(own.file.longest_side, units) + "; ";
      names += (names.empty() ? "" : ", ") + own.file_name;
    }
  }
  if (guess.ambiguous()) {
    throw pbdsurg::InvalidArgument(
        (guess.plausible.empty() ? "no one unit suits all files: " : "the unit is not sure: ") +
        readings +
        "give --unit mm, cm, dm or m, or --scale; `pbdsurg mesh convert IN OUT --unit` brings each "
        "file to metres");
  }
  for (OwnOrgan& own : organs) {
    if (own.is_guessed) {
      pbdsurg::set_unit(own.file, guess.unit);
    }
  }
  warnings.push_back({"unit_guessed",
                      "no unit is given for " + names + ": coordinates are taken for " +
                          pbdsurg::name_of(guess.unit) + " (see --unit)",
                      pbdsurg::metres_per(guess.unit)});
}

}  // namespace

std::vector<OwnOrgan> read_organs(const std::map<Organ, std::filesystem::path>& paths,
                                  const UnitOptions& unit, std::vector<Warning>& warnings) {
  std::vector<OwnOrgan> organs = read_files(paths, unit);
  settle_units(organs, warnings);
  return organs;
}

}  // namespace cholecystectomy
