// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/organ_files.h"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <sstream>
#include <utility>
#include <variant>

#include "pbdsurg/anatomy/organs.h"
#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/surface_distance.h"
#include "pbdsurg/mesh/topology.h"

#include "apps/cholecystectomy/organ_filling.h"
#include "apps/cholecystectomy/organ_reading.h"
#include "apps/cholecystectomy/placement.h"

namespace cholecystectomy {

using pbdsurg::Organ;

namespace {

using pbdsurg::CholecystectomyOptions;
using pbdsurg::ImplicitShape;
using pbdsurg::MeshData;
using pbdsurg::OrganSource;
using pbdsurg::TetMesh;

constexpr double kLowCoarsening = 1.5;   // 25,000 tetrahedra of 73,000
constexpr double kLargestRatio = 4;      // of the longest side to that of the organ replaced
constexpr double kFossaGap = 1e-3;       // m, as in the liver bed of the library
constexpr double kFossaRounding = 3e-3;  // m

ImplicitShape filled(const OrganSource& source) {
  const auto* mesh = std::get_if<TetMesh>(&source);
  return mesh != nullptr ? pbdsurg::filled_shape(*mesh) : std::get<ImplicitShape>(source);
}

// Moves a user's liver along z until its underside lies at the height of the gallbladder's middle.
void rest_on_gallbladder(std::vector<Eigen::Vector3d>& liver, const ImplicitShape& gallbladder) {
  const Eigen::AlignedBox3d box = gallbladder.bounds();
  double lowest = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& p : liver) {
    if (p.x() > box.min().x() && p.x() < box.max().x() && p.y() > box.min().y() &&
        p.y() < box.max().y()) {
      lowest = std::min(lowest, p.z());
    }
  }
  if (std::isfinite(lowest)) {
    for (Eigen::Vector3d& p : liver) {
      p.z() += box.center().z() - lowest;
    }
  }
}

void check_size(const OwnOrgan& own, const TetMesh& replaced) {
  const double replaced_side = pbdsurg::bounding_box(replaced).sizes().maxCoeff();
  const double ratio = own.file.longest_side / replaced_side;
  if (!(ratio < kLargestRatio) || !(ratio > 1 / kLargestRatio)) {
    throw pbdsurg::InvalidArgument(
        own.name + " is " + pbdsurg::describe_length(own.file.longest_side) + " long in " +
        pbdsurg::describe_unit(own.file) + "; the organ that it replaces is " +
        pbdsurg::describe_length(replaced_side) +
        " long, which must be within four times of that (is the unit right? see --unit, --scale)");
  }
}

// The motion of each organ: all the same, or each its own.
std::vector<Eigen::Isometry3d> motions_of(const std::vector<OwnOrgan>& organs,
                                          const std::map<Organ, TetMesh>& built_in,
                                          bool keeps_placement) {
  std::vector<Replacement> replacements;
  for (const OwnOrgan& own : organs) {
    replacements.push_back(
        {frame_of(own.file.mesh.points), frame_of(built_in.at(own.organ).positions())});
  }
  std::vector<Eigen::Isometry3d> motions;
  for (const Replacement& replacement : replacements) {
    motions.push_back(keeps_placement ? fit_motion(replacements) : fit_motion({&replacement, 1}));
  }
  return motions;
}

std::string note_of(const OwnOrgan& own, const Eigen::Isometry3d& motion) {
  const Eigen::Vector3d centre = frame_of(own.file.mesh.points).centre;
  std::ostringstream note;
  note << pbdsurg::name_of(own.organ) << ": " << own.path.filename().string() << ", "
       << own.file.format << ", in " << pbdsurg::describe_unit(own.file)
       << (own.is_guessed ? " (a guess)" : "") << ", " << own.file.mesh.tets.size()
       << " tetrahedra, " << own.file.mesh.triangles.size() << " triangles, moved by "
       << pbdsurg::describe_length((motion * centre - centre).norm()) << ", turned by "
       << std::lround(Eigen::AngleAxisd(motion.linear()).angle() * 180 / std::numbers::pi)
       << " degrees";
  if (own.organ == Organ::liver && !own.file.mesh.tets.empty()) {
    note << ", filled anew at the resolution of its tetrahedra, because the gallbladder's bed is "
            "carved";
  }
  return note.str();
}

// The organ as the anatomy takes it, in its place.
OrganSource make_source(OwnOrgan& own, const CholecystectomyOptions& others,
                        const OrganFiles& files, std::vector<Warning>& warnings) {
  MeshData& mesh = own.file.mesh;
  check_tet_count(
      mesh.tets.empty() ? estimate_tets(own.organ, mesh) : static_cast<double>(mesh.tets.size()),
      files.max_tets, own.name);
  ImplicitShape gallbladder = pbdsurg::gallbladder_outer();
  if (own.organ == Organ::liver) {
    const auto found = others.own.find(Organ::gallbladder);
    if (found != others.own.end()) {
      gallbladder = filled(found->second);
    }
    if (!files.keeps_placement) {
      rest_on_gallbladder(mesh.points, gallbladder);
    }
  }
  if (mesh.tets.empty()) {
    warn_of_gaps(mesh, own.name, warnings);
  }
  const ImplicitShape fossa = pbdsurg::offset_shape(gallbladder, kFossaGap);
  Eigen::AlignedBox3d extent;
  for (const Eigen::Vector3d& p : mesh.points) {
    if (own.organ != Organ::liver || fossa(p) > 0) {
      extent.extend(p);
    }
  }
  const pbdsurg::Index vertex_count =
      mesh.tets.empty() ? 0 : static_cast<pbdsurg::Index>(mesh.points.size());
  OrganSource source = [&]() -> OrganSource {
    if (!mesh.tets.empty()) {
      return pbdsurg::to_tet_mesh(std::move(mesh), own.path);
    }
    try {
      return pbdsurg::surface_shape(mesh.points, mesh.triangles);
    } catch (const pbdsurg::InvalidMesh& error) {
      throw pbdsurg::InvalidMesh(own.name + ": " + error.what());
    }
  }();
  if (own.organ == Organ::liver) {
    source = pbdsurg::smooth_difference(filled(source), fossa, kFossaRounding);
  }
  const auto* shape = std::get_if<ImplicitShape>(&source);
  return shape != nullptr
             ? fill({own.organ, own.name, *shape, extent, vertex_count}, files.max_tets, warnings)
             : source;
}

}  // namespace

Organ find_organ(const std::string& name) {
  std::string known;
  for (const Organ organ : pbdsurg::kOrgans) {
    if (name == pbdsurg::name_of(organ)) {
      return organ;
    }
    known += std::string(" ") + pbdsurg::name_of(organ);
  }
  throw pbdsurg::InvalidArgument("there is no organ '" + name + "'; there are:" + known);
}

LoadedAnatomy load_anatomy(const OrganFiles& files, Detail detail) {
  LoadedAnatomy loaded;
  loaded.detail = detail;
  if (files.paths.empty() && detail == Detail::full) {
    loaded.anatomy = pbdsurg::make_cholecystectomy_anatomy();
    return loaded;
  }
  std::vector<OwnOrgan> organs = read_organs(files.paths, files.unit, loaded.warnings);
  loaded.built_in = pbdsurg::make_cholecystectomy_anatomy().organs;
  for (const OwnOrgan& own : organs) {
    check_size(own, loaded.built_in.at(own.organ));
  }
  const std::vector<Eigen::Isometry3d> motions =
      motions_of(organs, loaded.built_in, files.keeps_placement);
  CholecystectomyOptions options;
  options.coarsening = detail == Detail::low ? kLowCoarsening : 1;
  for (std::size_t i = 0; i < organs.size(); ++i) {
    OwnOrgan& own = organs[i];
    loaded.own.insert(own.organ);
    loaded.notes.push_back(note_of(own, motions[i]));
    for (Eigen::Vector3d& p : own.file.mesh.points) {
      p = motions[i] * p;
    }
    options.own.emplace(own.organ, make_source(own, options, files, loaded.warnings));
  }
  loaded.anatomy = pbdsurg::make_cholecystectomy_anatomy(options);
  return loaded;
}

}  // namespace cholecystectomy
