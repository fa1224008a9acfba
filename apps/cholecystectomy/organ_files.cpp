// SPDX-License-Identifier: Apache-2.0
#include "organ_files.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>
#include <variant>

#include "pbdsurg/anatomy/organs.h"
#include "pbdsurg/core/error.h"
#include "pbdsurg/mesh/read.h"
#include "pbdsurg/mesh/surface_distance.h"
#include "pbdsurg/mesh/topology.h"

namespace cholecystectomy {

using pbdsurg::Organ;

namespace {

using pbdsurg::ImplicitShape;
using pbdsurg::MeshData;
using pbdsurg::OrganSource;
using pbdsurg::TetMesh;
using Points = std::vector<Eigen::Vector3d>;

constexpr double kLargestRatio = 4;      // of the longest side to that of the organ replaced
constexpr double kFossaGap = 1e-3;       // m, as in the liver bed of the library
constexpr double kFossaRounding = 3e-3;  // m

// Centre and axes of a cloud of points, the longest axis first, each pointing where the cloud is
// drawn out (positive third moment), so that blunt ends meet blunt ends.
struct Frame {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
};

Frame frame_of(const Points& points) {
  Frame frame;
  for (const Eigen::Vector3d& p : points) {
    frame.centre += p / static_cast<double>(points.size());
  }
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : points) {
    covariance += (p - frame.centre) * (p - frame.centre).transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  for (int i = 0; i < 3; ++i) {
    Eigen::Vector3d axis = solver.eigenvectors().col(2 - i);
    double moment = 0;
    for (const Eigen::Vector3d& p : points) {
      moment += std::pow((p - frame.centre).dot(axis), 3);
    }
    frame.axes.col(i) = moment < 0 ? Eigen::Vector3d(-axis) : axis;
  }
  frame.axes.col(2) = frame.axes.col(0).cross(frame.axes.col(1));
  return frame;
}

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

ImplicitShape filled(const OrganSource& source) {
  const auto* mesh = std::get_if<TetMesh>(&source);
  return mesh != nullptr ? pbdsurg::filled_shape(*mesh) : std::get<ImplicitShape>(source);
}

// Moves a user's liver along z until its underside lies at the height of the gallbladder's middle.
void rest_on_gallbladder(Points& liver, const ImplicitShape& gallbladder) {
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

MeshData place(const MeshData& mesh, Organ organ, const TetMesh& replaced) {
  const Points target(replaced.positions().begin(), replaced.positions().end());
  const double ratio = longest_side(mesh.points) / longest_side(target);
  if (!(ratio < kLargestRatio) || !(ratio > 1 / kLargestRatio)) {
    std::ostringstream text;
    text << "the " << pbdsurg::name_of(organ) << " given is " << longest_side(mesh.points)
         << " m long; it must be within " << kLargestRatio << " times of " << longest_side(target)
         << " m, that of the organ it replaces (is the unit right? see --unit)";
    throw pbdsurg::InvalidArgument(text.str());
  }
  const Frame from = frame_of(mesh.points);
  const Frame to = frame_of(target);
  const Eigen::Matrix3d rotation = to.axes * from.axes.transpose();
  MeshData placed = mesh;
  for (Eigen::Vector3d& p : placed.points) {
    p = rotation * (p - from.centre) + to.centre;
  }
  return placed;
}

OrganSource make_source(MeshData mesh, const std::string& path) {
  try {
    if (!mesh.tets.empty()) {
      return TetMesh(std::move(mesh.points), std::move(mesh.tets));
    }
    return pbdsurg::surface_shape(mesh.points, mesh.triangles);
  } catch (const pbdsurg::InvalidMesh& error) {
    throw pbdsurg::InvalidMesh(path + ": " + error.what());
  }
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

LoadedAnatomy load_anatomy(const std::map<Organ, std::filesystem::path>& files,
                           pbdsurg::LengthUnit unit) {
  LoadedAnatomy loaded;
  loaded.anatomy = pbdsurg::make_cholecystectomy_anatomy();
  if (files.empty()) {
    return loaded;
  }
  pbdsurg::CholecystectomyOptions options;
  for (const auto& [organ, path] : files) {  // the gallbladder comes first: the liver follows it
    pbdsurg::MeshFile read = pbdsurg::read_mesh_file(path, {unit});
    pbdsurg::orient_majority(read.mesh);
    if (!read.mesh.tets.empty()) {
      read.mesh.triangles.clear();  // a surface beside tetrahedra is theirs
    }
    drop_unused_points(read.mesh);
    if (read.mesh.points.empty()) {
      throw pbdsurg::InvalidMesh(path.string() + ": there are no tetrahedra and no triangles");
    }
    MeshData placed = place(read.mesh, organ, loaded.anatomy.organs.at(organ));
    std::ostringstream note;
    note << pbdsurg::name_of(organ) << ": " << path.filename().string() << ", " << read.format
         << ", in " << pbdsurg::name_of(read.unit) << (read.unit_ambiguous() ? " (a guess)" : "")
         << ", " << placed.tets.size() << " tetrahedra, " << placed.triangles.size()
         << " triangles";
    loaded.notes.push_back(note.str());
    if (organ == Organ::liver) {
      const auto own = options.own.find(Organ::gallbladder);
      const ImplicitShape gallbladder =
          own == options.own.end() ? pbdsurg::gallbladder_outer() : filled(own->second);
      rest_on_gallbladder(placed.points, gallbladder);
      const ImplicitShape liver = filled(make_source(std::move(placed), path.string()));
      options.own.emplace(
          organ, pbdsurg::smooth_difference(liver, pbdsurg::offset_shape(gallbladder, kFossaGap),
                                            kFossaRounding));
    } else {
      options.own.emplace(organ, make_source(std::move(placed), path.string()));
    }
  }
  loaded.anatomy = pbdsurg::make_cholecystectomy_anatomy(options);
  return loaded;
}

}  // namespace cholecystectomy
