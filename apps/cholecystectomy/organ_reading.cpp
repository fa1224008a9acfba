// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/organ_reading.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <span>
#include <utility>

#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/topology.h"

namespace cholecystectomy {
namespace {

using pbdsurg::LengthUnit;
using pbdsurg::LengthUnitGuess;
using pbdsurg::MeshData;
using pbdsurg::Organ;
using pbdsurg::UnitOptions;
using OrganPoints = std::vector<Eigen::Vector3d>;

double longest_side(const OrganPoints& points) {
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
  OrganPoints points;
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
                      path, std::move(file), unit.is_guessed()});
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
      names += (names.empty() ? "" : ", ") + own.path.filename().string();
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

// Tetrahedra that share no vertex are not held together.
void check_parts(const OwnOrgan& own, std::vector<Warning>& warnings) {
  const std::vector<pbdsurg::Tet>& tets = own.file.mesh.tets;
  const pbdsurg::Components parts =
      pbdsurg::find_components(static_cast<pbdsurg::Index>(own.file.mesh.points.size()),
                               std::span<const pbdsurg::Tet>(tets));
  if (parts.count <= 1) {
    return;
  }
  std::vector<std::size_t> sizes(static_cast<std::size_t>(parts.count), 0);
  for (const pbdsurg::Tet& tet : tets) {
    ++sizes[static_cast<std::size_t>(parts.of_vertex[tet[0]])];
  }
  const std::size_t largest = *std::max_element(sizes.begin(), sizes.end());
  const std::string text = own.name + " is in " + std::to_string(parts.count) +
                           " parts that share no vertex; the largest has " +
                           std::to_string(largest) + " of " + std::to_string(tets.size()) +
                           " tetrahedra";
  if (2 * largest < tets.size()) {
    throw pbdsurg::InvalidMesh(text +
                               ", less than half. Is each point there several times? `pbdsurg mesh "
                               "check FILE` tells whether welding would join the parts");
  }
  warnings.push_back({"several_parts", text, parts.count});
}

}  // namespace

std::vector<OwnOrgan> read_organs(const std::map<Organ, std::filesystem::path>& paths,
                                  const UnitOptions& unit, std::vector<Warning>& warnings) {
  std::vector<OwnOrgan> organs = read_files(paths, unit);
  settle_units(organs, warnings);
  for (const OwnOrgan& own : organs) {
    if (!own.file.mesh.tets.empty()) {
      check_parts(own, warnings);
    }
  }
  return organs;
}

}  // namespace cholecystectomy
