// SPDX-License-Identifier: Apache-2.0
#include "bench/sizes/operation.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <string>

#include "pbdsurg/base/error.h"

#include "bench/sizes/memory.h"
#include "bench/support/timing.h"

namespace pbdsurg::bench {
namespace {

constexpr double kTimeStep = 5e-3;       // s
constexpr double kPower = 60;            // W
constexpr double kFixedShare = 0.4;      // of the liver's height
constexpr float kWait = 0.05F;           // m below the liver
constexpr std::size_t kRemovedTets = 4;  // a frame

ToolPose at(const Eigen::Vector3f& tip) {
  return ToolPose(Eigen::Translation3f(tip));
}

Eigen::Vector3f lowest_corner(const Surface& skin) {
  Eigen::Vector3f lowest = Eigen::Vector3f::Constant(std::numeric_limits<float>::max());
  for (const Triangle& triangle : skin.triangles()) {
    for (const Index v : triangle) {
      const bool is_empty = triangle[0] == triangle[1];  // see Surface::triangles()
      if (!is_empty && skin.positions()[v].z() < lowest.z()) {
        lowest = skin.positions()[v];
      }
    }
  }
  return lowest;
}

// Tetrahedra along x, the liver's long axis.
std::vector<Index> tets_along_x(const TetMesh& mesh) {
  std::vector<double> places;
  for (const Tet& tet : mesh.tets()) {
    double sum = 0;
    for (const Index v : tet) {
      sum += mesh.positions()[v].x();
    }
    places.push_back(sum);
  }
  std::vector<Index> tets(places.size());
  std::iota(tets.begin(), tets.end(), Index{0});
  std::ranges::stable_sort(tets, {}, [&](Index tet) { return places[tet]; });
  return tets;
}

}  // namespace

Operation::Operation(const TetMesh& liver, const SolverOptions& options,
                     const CauteryOptions& cautery)
    : world_(options), next_removed_(tets_along_x(liver)) {
  const BodyId body = world_.add_body("liver", liver, tissues::liver());
  const Eigen::AlignedBox3d box = bounding_box(liver);
  world_.fix(body, [&](const Eigen::Vector3d& x) {
    return x.z() > box.max().z() - kFixedShare * box.sizes().z();
  });
  world_.set_gravity({0, 0, -9.81F});
  const Eigen::Vector3f below(0, 0, static_cast<float>(box.min().z()) - kWait);
  hook_ = world_.add_tool({{{0, 0, 0}, {0, 0, -0.1F}, 0.5e-3F}}, at(below),
                          {ContactFeatures::vertices});

  const std::int64_t before_heat = heap_bytes();
  burner_ = world_.add_cautery(hook_, {body}, cautery);
  const std::int64_t before_surface = heap_bytes();
  skin_ = &world_.surface(body);
  heat_bytes_ = before_surface - before_heat;
  surface_bytes_ = heap_bytes() - before_surface;
}

Timed Operation::quiet_frame() {
  return step();
}

Timed Operation::burn_frame() {
  world_.move(hook_, at(lowest_corner(*skin_)));
  world_.energise(burner_, cut_settings(kPower));
  TopologyEdit edit;
  while (edit.remove_tets.size() < kRemovedTets && !next_removed_.empty()) {
    if (world_.tissue().is_tet_alive(next_removed_.back())) {
      edit.remove_tets.push_back(next_removed_.back());
    }
    next_removed_.pop_back();
  }
  world_.edit(edit);
  return step();
}

Timed Operation::step() {
  Timed timed;
  timed.ms = time_of([&] { timed.frame = world_.step(kTimeStep); });
  if (!timed.frame.ok()) {
    throw Error(std::string("a frame on backend ") + world_.solver().backend_name() + ": " +
                timed.frame.why());
  }
  return timed;
}

}  // namespace pbdsurg::bench
