// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/contact/contact_probe.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "pbdsurg/views/live_surface.h"

#include "lib/base/check.h"
#include "lib/contact/triangle_cull.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3f;

constexpr float kSlack = 3e-3F;  // m: how far things may go until all surfaces are looked at again

// Triangles of several surfaces, with the vertices that they are at.
struct Skin {
  std::vector<Index> vertices;      // of the scene
  std::vector<Vector3f> positions;  // [vertices] m
  std::vector<Triangle> triangles;  // corners in vertices
  std::vector<std::size_t> ends;    // [surface] in triangles

  void clear() {
    vertices.clear();
    positions.clear();
    triangles.clear();
    ends.clear();
  }
  void read(const Solver& solver) {
    positions.resize(vertices.size());
    if (!vertices.empty()) {  // a step may run, and reading would wait for it
      solver.read_positions(vertices, positions);
    }
  }
};

}  // namespace

struct ContactProbe::Data {
  static constexpr const char* kWho = "a contact probe";

  std::vector<std::shared_ptr<const LiveSurface>> surfaces;
  std::vector<ToolPoint> points;
  ContactPatch patch;  // of make_contact_packet()

  // of a solver's positions
  Skin all, near;                            // near: may be culled in place of all
  std::vector<std::uint64_t> seen_versions;  // [surface]
  std::vector<ToolPoint> scanned;            // [point] in the scene, when near was found
  double scan_time = 0;                      // s, likewise
  bool has_scanned = false;

  // scratch
  std::vector<ToolPoint> balls;
  std::vector<CulledSurface> culled;
  std::vector<Index> places;  // [vertex]
  TriangleCull cull;

  void begin(const Solver& solver, ToolId tool, GraspState grasp, std::uint64_t sequence,
             double time, ContactPatch& into);
  void end(ContactPatch& into) const;
  void add_culled(const Solver& solver, std::size_t surface, const TouchedSurface& as);
  void add_culled(const Solver& solver, const Skin& skin);
  void follow_edits(const Solver& solver);
  [[nodiscard]] bool has_slack(double time) const;
  void scan(const Solver& solver, double time);
};

// Refuses what is wrong, and says what is not triangles.
void ContactProbe::Data::begin(const Solver& solver, ToolId tool, GraspState grasp,
                               std::uint64_t sequence, double time, ContactPatch& into) {
  if (sequence == 0) {
    throw InvalidArgument("the sequence of a contact patch is 0; it must be positive");
  }
  check(std::isfinite(time), "the time of a contact patch", time, "finite");
  for (const std::shared_ptr<const LiveSurface>& surface : surfaces) {
    solver.tissue().check_follower(*surface, "a contact probe");
  }
  into.pose = solver.tool_pose(tool);
  into.force = solver.tool_force(tool);
  into.sequence = sequence;
  into.time = time;
  into.grasp = grasp;
  balls.assign(points.begin(), points.end());
  for (ToolPoint& ball : balls) {
    ball.center = into.pose * ball.center;
  }
  culled.clear();
}

void ContactProbe::Data::end(ContactPatch& into) const {
  into.points.clear();
  for (std::size_t i = 0; i < points.size(); ++i) {
    into.points.push_back({points[i], cull.reaches()[i]});
  }
  into.triangles.assign(cull.triangles().begin(), cull.triangles().end());
}

void ContactProbe::Data::add_culled(const Solver& solver, std::size_t surface,
                                    const TouchedSurface& as) {
  const Index body = surfaces[surface]->body();
  if (body == kInvalidIndex) {  // a compaction has left it out
    culled.push_back({});
    return;
  }
  const Material& material = solver.tissue().body(body).material;
  const bool is_solid = material.model == ElasticModel::neo_hookean;
  culled.push_back({as.triangles, as.positions, is_solid ? material.youngs_modulus : 0,
                    is_solid ? material.poissons_ratio : 0});
}

void ContactProbe::Data::add_culled(const Solver& solver, const Skin& skin) {
  std::size_t first = 0;
  for (std::size_t s = 0; s < surfaces.size(); ++s) {
    add_culled(solver, s,
               {std::span(skin.triangles).subspan(first, skin.ends[s] - first), skin.positions});
    first = skin.ends[s];
  }
}

void ContactProbe::Data::follow_edits(const Solver& solver) {
  const bool is_same = std::ranges::equal(surfaces, seen_versions, {},
                                          [](const auto& surface) { return surface->version(); });
  if (is_same) {
    return;
  }
  has_scanned = false;
  seen_versions.clear();
  all.clear();
  places.assign(static_cast<std::size_t>(solver.vertex_count()), kInvalidIndex);
  const auto place_in_all = [&](Index vertex) {
    if (places[vertex] == kInvalidIndex) {
      places[vertex] = static_cast<Index>(all.vertices.size());
      all.vertices.push_back(vertex);
    }
    return places[vertex];
  };
  for (const std::shared_ptr<const LiveSurface>& surface : surfaces) {
    for (const auto& [a, b, c] : surface->triangles()) {
      if (a != b) {
        all.triangles.push_back({place_in_all(a), place_in_all(b), place_in_all(c)});
      }
    }
    all.ends.push_back(all.triangles.size());
    seen_versions.push_back(surface->version());
  }
}

// Whether what was near then is all that can matter now.
bool ContactProbe::Data::has_slack(double time) const {
  const double since = time - scan_time;
  if (!has_scanned || !(since >= 0)) {
    return false;
  }
  const double left = double{kSlack} - double{kFastestTissue} * since;
  for (std::size_t i = 0; i < balls.size(); ++i) {
    if (!((balls[i].center - scanned[i].center).cast<double>().norm() < left)) {
      return false;
    }
  }
  return true;
}

void ContactProbe::Data::scan(const Solver& solver, double time) {
  all.read(solver);
  add_culled(solver, all);
  cull.find(culled, balls, ContactPatch::kMargin + kSlack);
  culled.clear();
  near.clear();
  places.assign(all.vertices.size(), kInvalidIndex);
  const auto place_in_near = [&](Index vertex) {
    if (places[vertex] == kInvalidIndex) {
      places[vertex] = static_cast<Index>(near.vertices.size());
      near.vertices.push_back(all.vertices[vertex]);
      near.positions.push_back(all.positions[vertex]);
    }
    return places[vertex];
  };
  auto place = cull.places().begin();
  for (const std::size_t end : all.ends) {
    for (; place != cull.places().end() && *place < end; ++place) {
      const auto& [a, b, c] = all.triangles[*place];
      near.triangles.push_back({place_in_near(a), place_in_near(b), place_in_near(c)});
    }
    near.ends.push_back(near.triangles.size());
  }
  scanned.assign(balls.begin(), balls.end());
  scan_time = time;
  has_scanned = true;
}

ContactProbe::ContactProbe(const Solver& solver, std::span<const Index> bodies,
                           std::span<const ToolPoint> points)
    : data_(std::make_unique<Data>()) {
  if (points.size() > ContactPacket::kLargestPlaneCount) {
    throw InvalidArgument("a contact probe has " + std::to_string(points.size()) +
                          " points; a packet has planes for " +
                          std::to_string(ContactPacket::kLargestPlaneCount));
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].center.allFinite() || !(points[i].radius > 0) ||
        !std::isfinite(points[i].radius)) {
      throw InvalidArgument("point " + std::to_string(i) + " of a contact probe has a radius of " +
                            std::to_string(points[i].radius) +
                            " m; center and radius must be finite, the radius positive");
    }
  }
  data_->points.assign(points.begin(), points.end());
  for (const Index body : bodies) {
    data_->surfaces.push_back(shared_surface(solver.tissue(), body));
  }
}
ContactProbe::~ContactProbe() = default;
ContactProbe::ContactProbe(ContactProbe&&) noexcept = default;
ContactProbe& ContactProbe::operator=(ContactProbe&&) noexcept = default;

void ContactProbe::collect_patch(const Solver& solver, ToolId tool, GraspState grasp,
                                 std::uint64_t sequence, double time, ContactPatch& patch) {
  Data& data = *data_;
  data.begin(solver, tool, grasp, sequence, time, patch);
  data.follow_edits(solver);
  if (data.has_slack(time)) {
    data.near.read(solver);
  } else {
    data.scan(solver, time);
  }
  data.add_culled(solver, data.near);
  data.cull.find(data.culled, data.balls, ContactPatch::kMargin);
  data.end(patch);
}

void ContactProbe::collect_patch(std::span<const TouchedSurface> surfaces, const Solver& solver,
                                 ToolId tool, GraspState grasp, std::uint64_t sequence, double time,
                                 ContactPatch& patch) {
  Data& data = *data_;
  if (surfaces.size() != data.surfaces.size()) {
    throw InvalidArgument("there are " + std::to_string(surfaces.size()) + " surfaces for " +
                          std::to_string(data.surfaces.size()) + " bodies; one each");
  }
  data.begin(solver, tool, grasp, sequence, time, patch);
  for (std::size_t s = 0; s < surfaces.size(); ++s) {
    data.add_culled(solver, s, surfaces[s]);
  }
  data.cull.find(data.culled, data.balls, ContactPatch::kMargin);
  data.end(patch);
}

ContactPacket make_contact_packet(ContactProbe& probe, const Solver& solver, ToolId tool,
                                  GraspState grasp, std::uint64_t sequence, double time) {
  ContactPatch& patch = probe.data_->patch;
  probe.collect_patch(solver, tool, grasp, sequence, time, patch);
  return make_contact_packet(patch);
}

}  // namespace pbdsurg
