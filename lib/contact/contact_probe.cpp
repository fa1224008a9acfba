// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/contact/contact_probe.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
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
constexpr float kAll = std::numeric_limits<float>::infinity();  // m: surfaces are whole

// A surface that the tool may touch.
struct Watched {
  std::shared_ptr<const LiveSurface> surface;
  std::uint64_t seen_version = 0;
  int seen_renumberings = 0;
  std::vector<Triangle> triangles{};       // [slot] corners in the probe's vertices
  std::vector<Index> near{};               // slots, ascending: all that can matter
  std::vector<Triangle> near_triangles{};  // [near]
};

}  // namespace

struct ContactProbe::Data {
  static constexpr const char* kWho = "a contact probe";

  std::vector<Watched> watched;
  std::vector<ToolPoint> points;
  ContactPatch patch;  // of make_contact_packet()

  // of a solver
  std::vector<Index> vertices;       // of surfaces, of the scene; some may have left them
  std::vector<Vector3f> positions;   // [vertices] m, those near as of now
  std::vector<Index> places;         // [vertex_count] in vertices, kInvalidIndex elsewhere
  std::vector<Index> near;           // in vertices
  std::vector<ToolPoint> scanned;    // [point] in the scene, when all was looked at
  std::vector<float> near_is_whole;  // [point] m, as `whole`
  double scan_time = 0;              // s
  bool has_scanned = false;

  // scratch
  std::vector<ToolPoint> balls;
  std::vector<float> whole;  // [point] m, see TriangleCull::find()
  std::vector<CulledSurface> culled;
  std::vector<Index> read_vertices;
  std::vector<Vector3f> read_positions;
  std::vector<std::uint32_t> seen_at;  // [vertices] the list that it was put on last
  std::uint32_t lists = 0;
  std::vector<SlotRange> ranges;
  TriangleCull cull;

  void begin(const Solver& solver, ToolId tool, GraspState grasp, std::uint64_t sequence,
             double time, ContactPatch& into);
  void end(ContactPatch& into);
  void add_culled(const Solver& solver, const Watched& of, const TouchedSurface& as);
  void forget();
  void follow_edits(const Solver& solver);
  void follow(Watched& each);
  [[nodiscard]] bool has_slack(double time) const;
  void list_near();
  void read_near(const Solver& solver);
  void scan(const Solver& solver, double time);
};

// Refuses what is wrong, and says what is not triangles.
void ContactProbe::Data::begin(const Solver& solver, ToolId tool, GraspState grasp,
                               std::uint64_t sequence, double time, ContactPatch& into) {
  if (sequence == 0) {
    throw InvalidArgument("the sequence of a contact patch is 0; it must be positive");
  }
  check(std::isfinite(time), "the time of a contact patch", time, "finite");
  for (const Watched& each : watched) {
    solver.tissue().check_follower(*each.surface, "a contact probe");
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

// Takes from the surfaces that may be culled what matters.
void ContactProbe::Data::end(ContactPatch& into) {
  cull.find(culled, balls, whole, ContactPatch::kMargin);
  cull.tighten(ContactPatch::kMargin);
  into.points.clear();
  for (std::size_t i = 0; i < points.size(); ++i) {
    into.points.push_back({points[i], cull.reaches()[i]});
  }
  into.triangles.assign(cull.triangles().begin(), cull.triangles().end());
}

void ContactProbe::Data::add_culled(const Solver& solver, const Watched& of,
                                    const TouchedSurface& as) {
  const Index body = of.surface->body();
  if (body == kInvalidIndex) {  // a compaction has left it out
    culled.push_back({});
    return;
  }
  const Material& material = solver.tissue().body(body).material;
  const bool is_solid = material.model == ElasticModel::neo_hookean;
  culled.push_back({as.triangles, as.positions, is_solid ? material.youngs_modulus : 0,
                    is_solid ? material.poissons_ratio : 0});
}

void ContactProbe::Data::forget() {
  vertices.clear();
  places.clear();
  has_scanned = false;
  for (Watched& each : watched) {
    each.seen_version = 0;
    each.seen_renumberings = each.surface->renumberings();
    each.near.clear();
  }
}

// What an edit shows is near until all is looked at again.
void ContactProbe::Data::follow_edits(const Solver& solver) {
  const auto vertex_count = static_cast<std::size_t>(solver.vertex_count());
  const bool has_old_ids =
      places.size() > vertex_count || std::ranges::any_of(watched, [](const Watched& each) {
        return each.seen_renumberings != each.surface->renumberings();
      });
  if (has_old_ids) {
    forget();
  }
  places.resize(vertex_count, kInvalidIndex);
  bool has_changed = false;
  for (Watched& each : watched) {
    if (each.seen_version != each.surface->version()) {
      follow(each);
      has_changed = true;
    }
  }
  positions.resize(vertices.size());
  seen_at.resize(vertices.size());
  if (has_changed && has_scanned) {
    list_near();
  }
}

void ContactProbe::Data::follow(Watched& each) {
  const auto place_of = [&](Index vertex) {
    if (places[vertex] == kInvalidIndex) {
      places[vertex] = static_cast<Index>(vertices.size());
      vertices.push_back(vertex);
    }
    return places[vertex];
  };
  each.surface->collect_changes(each.seen_version, ranges);
  each.seen_version = each.surface->version();
  each.triangles.resize(static_cast<std::size_t>(each.surface->slot_count()));
  for (const SlotRange& range : ranges) {
    for (Index slot = range.first; slot < range.end; ++slot) {
      const auto& [a, b, c] = each.surface->triangles()[slot];
      each.triangles[slot] =
          a == b ? Triangle{0, 0, 0} : Triangle{place_of(a), place_of(b), place_of(c)};
      each.near.push_back(slot);
    }
  }
  std::ranges::sort(each.near);
  each.near.erase(std::unique(each.near.begin(), each.near.end()), each.near.end());
  std::erase_if(each.near, [&](Index slot) {
    return slot >= each.surface->slot_count() || each.triangles[slot][0] == each.triangles[slot][1];
  });
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

void ContactProbe::Data::list_near() {
  ++lists;
  near.clear();
  read_vertices.clear();
  for (Watched& each : watched) {
    each.near_triangles.clear();
    for (const Index slot : each.near) {
      each.near_triangles.push_back(each.triangles[slot]);
      for (const Index vertex : each.triangles[slot]) {
        if (seen_at[vertex] != lists) {
          seen_at[vertex] = lists;
          near.push_back(vertex);
          read_vertices.push_back(vertices[vertex]);
        }
      }
    }
  }
}

void ContactProbe::Data::read_near(const Solver& solver) {
  if (near.empty()) {  // a step may run, and reading would wait for it
    return;
  }
  read_positions.resize(near.size());
  solver.read_positions(read_vertices, read_positions);
  for (std::size_t i = 0; i < near.size(); ++i) {
    positions[near[i]] = read_positions[i];
  }
}

void ContactProbe::Data::scan(const Solver& solver, double time) {
  solver.read_positions(vertices, positions);
  for (const Watched& each : watched) {
    add_culled(solver, each, {each.triangles, positions});
  }
  whole.assign(points.size(), kAll);
  cull.find(culled, balls, whole, ContactPatch::kMargin + kSlack);
  culled.clear();
  auto place = cull.places().begin();
  std::size_t first = 0;
  for (Watched& each : watched) {
    each.near.clear();
    const std::size_t end = first + each.triangles.size();
    for (; place != cull.places().end() && *place < end; ++place) {
      each.near.push_back(static_cast<Index>(*place - first));
    }
    first = end;
  }
  list_near();
  scanned.assign(balls.begin(), balls.end());
  near_is_whole.clear();
  for (const float reach : cull.reaches()) {  // at any pose within slack and margin
    near_is_whole.push_back(reach + ContactPatch::kMargin);
  }
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
    data_->watched.push_back({shared_surface(solver.tissue(), body)});
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
    data.read_near(solver);
  } else {
    data.scan(solver, time);
  }
  for (const Watched& each : data.watched) {
    data.add_culled(solver, each, {each.near_triangles, data.positions});
  }
  data.whole = data.near_is_whole;
  data.end(patch);
}

void ContactProbe::collect_patch(std::span<const TouchedSurface> surfaces, const Solver& solver,
                                 ToolId tool, GraspState grasp, std::uint64_t sequence, double time,
                                 ContactPatch& patch) {
  Data& data = *data_;
  if (surfaces.size() != data.watched.size()) {
    throw InvalidArgument("there are " + std::to_string(surfaces.size()) + " surfaces for " +
                          std::to_string(data.watched.size()) + " bodies; one each");
  }
  data.begin(solver, tool, grasp, sequence, time, patch);
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    data.add_culled(solver, data.watched[i], surfaces[i]);
  }
  data.whole.assign(data.points.size(), kAll);
  data.end(patch);
}

ContactPacket make_contact_packet(ContactProbe& probe, const Solver& solver, ToolId tool,
                                  GraspState grasp, std::uint64_t sequence, double time) {
  ContactPatch& patch = probe.data_->patch;
  probe.collect_patch(solver, tool, grasp, sequence, time, patch);
  return make_contact_packet(patch);
}

}  // namespace pbdsurg
