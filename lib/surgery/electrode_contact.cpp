// SPDX-License-Identifier: Apache-2.0
#include "lib/surgery/electrode_contact.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "lib/mesh/closest_on_triangle.h"
#include "lib/tissue/renumber.h"

namespace pbdsurg {
namespace {

// How far around the contact is looked at, in contact radii.
constexpr double kMargin = 4;

// How deep in tissue, in contact radii, an electrode still touches the surface that it has passed.
constexpr double kDeepest = 4;

constexpr double kTie = 1e-9;       // relative
constexpr double kRounding = 1e-6;  // m, of single precision

// Of the cosine to the normal under the electrode: beyond is the far side of a thin wall.
constexpr double kLeastCosine = -0.5;

Eigen::Vector3d point_at(const Electrode& electrode, double share) {
  return electrode.tip.cast<double>() + share * (electrode.heel - electrode.tip).cast<double>();
}

double distance_to_segment(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                           const Eigen::Vector3d& x) {
  const Eigen::Vector3d along = b - a;
  const double length_squared = along.squaredNorm();
  const double share =
      length_squared > 0 ? std::clamp((x - a).dot(along) / length_squared, 0.0, 1.0) : 0;
  return (a + share * along - x).norm();
}

double distance_to(const Electrode& electrode, const Eigen::Vector3f& x) {
  return distance_to_segment(electrode.tip.cast<double>(), electrode.heel.cast<double>(),
                             x.cast<double>());
}

// Points along the electrode, half a radius apart.
int sample_count(const Electrode& electrode, double radius) {
  constexpr double kMost = 64;
  const double length = (electrode.heel - electrode.tip).norm();
  return 1 + static_cast<int>(std::min(kMost, std::ceil(2 * length / radius)));
}

double sample_share(int sample, int count) {
  return count > 1 ? static_cast<double>(sample) / (count - 1) : 0;
}

}  // namespace

void ScenePositions::read(const Solver& solver, std::span<const Index> vertices) {
  if (!is_held_) {
    take(solver, vertices);
  }
}

void ScenePositions::take(const Solver& solver, std::span<const Index> vertices) {
  if (vertices.empty()) {  // a step may run, and reading would wait for it
    return;
  }
  some_.resize(vertices.size());
  solver.read_positions(vertices, some_);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (some_[i].allFinite()) {
      values_[vertices[i]] = some_[i];
    }
  }
}

void ScenePositions::hold(const Solver& solver) {
  some_.resize(values_.size());
  solver.read_positions(some_);
  for (std::size_t v = 0; v < values_.size(); ++v) {
    if (some_[v].allFinite()) {
      values_[v] = some_[v];
    }
  }
  unread_ = static_cast<Index>(values_.size());
  is_held_ = true;
}

void ScenePositions::follow(const Solver& solver) {
  added_.clear();
  for (; unread_ < static_cast<Index>(values_.size()); ++unread_) {
    added_.push_back(unread_);
  }
  take(solver, added_);
}

void ScenePositions::resize(const Tissue& tissue) {
  values_.resize(static_cast<std::size_t>(tissue.vertex_count()), Eigen::Vector3f::Zero());
  unread_ = std::min(unread_, tissue.vertex_count());
}

void ScenePositions::renumber(const Tissue& tissue, const Renumbering& ids) {
  const bool has_read_all = unread_ == static_cast<Index>(values_.size());
  renumber_values(values_, ids.vertices, static_cast<std::size_t>(tissue.vertex_count()));
  unread_ = has_read_all ? tissue.vertex_count() : 0;
}

ElectrodeContact::ElectrodeContact(const Tissue& tissue, std::span<const ThermalBody> bodies,
                                   double radius)
    : radius_(radius) {
  for (const ThermalBody& body : bodies) {
    bodies_.push_back({shared_surface(tissue, body.body), 0, 0, {}, {}});
  }
}

// Of a disk that the edge of the contact crosses, about.
double ElectrodeContact::touched_share(const NearVertex& near, double reach) {
  return std::clamp(0.5 + (reach - near.distance) / (2 * near.radius), 0.0, 1.0);
}

void ElectrodeContact::find(const Solver& solver, const Electrode& electrode, double reach,
                            double dt, ScenePositions& positions) {
  slack_ -= kFastestTissue * dt;
  const double moved =
      std::max((electrode.tip - scanned_.tip).norm(), (electrode.heel - scanned_.heel).norm());
  if (!(moved < slack_) || seen_links_ != solver.tissue().links().size()) {
    scan(solver, electrode, positions);
  } else {
    for (Body& body : bodies_) {
      add_changed_slots(body);
    }
    collect_vertices(solver);
    positions.read(solver, vertices_);
  }
  nearest_ = {};
  area_ = 0;
  near_.clear();
  for (const Body& body : bodies_) {
    find_on(body, electrode, reach, positions.values());
  }
  find_links(solver, electrode, positions.values());
}

// Looks at all surfaces and links, for those that may be touched soon.
void ElectrodeContact::scan(const Solver& solver, const Electrode& electrode,
                            ScenePositions& positions) {
  bool is_listed = listed_links_ == solver.tissue().links().size();
  for (Body& body : bodies_) {
    body.candidates.resize(static_cast<std::size_t>(body.surface->slot_count()));
    for (Index slot = 0; slot < body.surface->slot_count(); ++slot) {
      body.candidates[slot] = slot;
    }
    body.seen_version = body.surface->version();
    is_listed = is_listed && body.listed_version == body.seen_version;
    body.listed_version = body.seen_version;
  }
  candidate_links_.clear();
  for (Index link = 0; link < static_cast<Index>(solver.tissue().links().size()); ++link) {
    if (solver.tissue().is_link_alive(link)) {
      candidate_links_.push_back(link);
    }
  }
  if (!is_listed) {
    collect_vertices(solver);
    all_vertices_ = vertices_;
    listed_links_ = solver.tissue().links().size();
  }
  positions.read(solver, all_vertices_);

  slack_ = kMargin * radius_;
  const double far = radius_ + 2 * slack_;
  const std::span<const Eigen::Vector3f> x = positions.values();
  // a point of a triangle or a link lies within its longest edge of a corner, and the electrode
  // within its half length of its middle, which leaves out most at less cost
  const Eigen::Vector3f middle = 0.5F * (electrode.tip + electrode.heel);
  const double half = (electrode.heel - electrode.tip).norm() / 2 + kRounding;
  for (Body& body : bodies_) {
    body.is_candidate.assign(static_cast<std::size_t>(body.surface->slot_count()), 0);
    std::erase_if(body.candidates, [&](Index slot) {
      const auto [a, b, c] = body.surface->triangles()[slot];
      const float square = std::max((x[a] - x[b]).squaredNorm(), (x[a] - x[c]).squaredNorm());
      const double reach = far + std::sqrt(square);
      const bool is_near =
          a != b && (x[a] - middle).norm() < reach + half && distance_to(electrode, x[a]) < reach;
      body.is_candidate[slot] = is_near ? 1 : 0;
      return !is_near;
    });
  }
  std::erase_if(candidate_links_, [&](Index l) {
    const Link& link = solver.tissue().links()[l];
    return !(distance_to(electrode, x[link.first]) < far + (x[link.first] - x[link.second]).norm());
  });
  scanned_ = electrode;
  seen_links_ = solver.tissue().links().size();
}

void ElectrodeContact::add_changed_slots(Body& body) {
  if (body.seen_version == body.surface->version()) {
    return;
  }
  body.surface->collect_changes(body.seen_version, ranges_);
  body.seen_version = body.surface->version();
  body.is_candidate.resize(static_cast<std::size_t>(body.surface->slot_count()));
  std::erase_if(body.candidates, [&](Index slot) { return slot >= body.surface->slot_count(); });
  for (const SlotRange& range : ranges_) {
    for (Index slot = range.first; slot < range.end; ++slot) {
      if (body.is_candidate[slot] == 0) {
        body.is_candidate[slot] = 1;
        body.candidates.push_back(slot);
      }
    }
  }
}

// Of all candidates, each once.
void ElectrodeContact::collect_vertices(const Solver& solver) {
  seen_.resize(static_cast<std::size_t>(solver.vertex_count()));
  vertex_areas_.resize(seen_.size());
  ++round_;
  vertices_.clear();
  const auto add = [&](Index v) {
    if (seen_[v] != round_) {
      seen_[v] = round_;
      vertices_.push_back(v);
    }
  };
  for (const Body& body : bodies_) {
    for (const Index slot : body.candidates) {
      const Triangle& triangle = body.surface->triangles()[slot];
      if (triangle != LiveSurface::kEmptyTriangle) {
        std::for_each(triangle.begin(), triangle.end(), add);
      }
    }
  }
  for (const Index l : candidate_links_) {
    add(solver.tissue().links()[l].first);
    add(solver.tissue().links()[l].second);
  }
}

void ElectrodeContact::find_on(const Body& body, const Electrode& electrode, double reach,
                               std::span<const Eigen::Vector3f> positions) {
  const auto corners = [&](const Triangle& triangle) {
    return std::array{positions[triangle[0]].cast<double>().eval(),
                      positions[triangle[1]].cast<double>().eval(),
                      positions[triangle[2]].cast<double>().eval()};
  };
  const double far = std::max(reach, kDeepest * radius_);
  close_.clear();
  for (const Index slot : body.candidates) {
    const Triangle& triangle = body.surface->triangles()[slot];
    if (triangle == LiveSurface::kEmptyTriangle) {
      continue;
    }
    const auto [a, b, c] = corners(triangle);
    const double size = std::max((a - b).norm(), (a - c).norm());
    // twice: neighbours of what is touched, for the areas of their vertices
    if (distance_to(electrode, positions[triangle[0]]) < far + 2 * size) {
      close_.push_back(slot);
    }
  }
  std::sort(close_.begin(), close_.end());  // whatever the candidates went through

  NearestPoint nearest;
  const bool is_sheet = body.surface->is_two_sided();
  const int samples = sample_count(electrode, radius_);
  int touching = 0;
  for (int i = 0; i < samples; ++i) {
    const Eigen::Vector3d sample = point_at(electrode, sample_share(i, samples));
    NearestPoint here;
    for (const Index slot : close_) {
      if (is_sheet && body.surface->origins()[slot].face != 0) {
        continue;  // the other side of another slot's
      }
      const Triangle& triangle = body.surface->triangles()[slot];
      const auto [a, b, c] = corners(triangle);
      const Eigen::Vector3d point = closest_on_triangle(a, b, c, sample).point;
      const double distance = (point - sample).norm();
      if (distance < (1 - kTie) * here.distance) {
        here = {distance, distance, point, Eigen::Vector3d::Zero(), triangle};
      }
      if (distance <= (1 + kTie) * here.distance) {  // on an edge, all that meet there count
        const Eigen::Vector3d normal = (b - a).cross(c - a).normalized();
        // a sheet is touched on the side where the electrode is
        here.outward +=
            is_sheet && normal.dot(sample - point) < 0 ? Eigen::Vector3d(-normal) : normal;
      }
    }
    const bool is_inside = here.distance <= far && (sample - here.point).dot(here.outward) < 0;
    here.gap = is_inside ? 0 : here.distance;
    touching += here.gap <= radius_ ? 1 : 0;
    if (here.gap < nearest.gap || (here.gap == nearest.gap && here.distance < nearest.distance)) {
      nearest = here;
    }
  }
  const double size = nearest.outward.norm();
  if (!(nearest.gap <= reach) || !(size > 0)) {
    return;
  }
  nearest.outward /= size;
  const double length = (electrode.heel - electrode.tip).norm();
  const double touching_length =
      samples > 1 ? length * std::max(0, touching - 1) / (samples - 1) : 0;
  area_ = std::max(area_, std::numbers::pi * radius_ * radius_ + 2 * radius_ * touching_length);

  const std::size_t first = near_.size();
  ++round_;
  for (const Index slot : close_) {
    const Triangle& triangle = body.surface->triangles()[slot];
    const auto [a, b, c] = corners(triangle);
    const Eigen::Vector3d normal = (b - a).cross(c - a);
    if (!(normal.dot(nearest.outward) > kLeastCosine * normal.norm())) {
      continue;
    }
    for (const Index v : triangle) {
      if (seen_[v] != round_) {
        seen_[v] = round_;
        vertex_areas_[v] = 0;
        near_.push_back({v, nearest.gap, 0, 0});
      }
      vertex_areas_[v] += normal.norm() / 6;
    }
  }
  for (auto near = near_.begin() + static_cast<std::ptrdiff_t>(first); near != near_.end();
       ++near) {
    const double distance = distance_to(electrode, positions[near->vertex]);
    near->distance =
        std::sqrt(std::max(0.0, distance * distance - nearest.distance * nearest.distance));
    near->radius = std::sqrt(vertex_areas_[near->vertex] / std::numbers::pi);
  }
  if (nearest.gap < nearest_.gap ||
      (nearest.gap == nearest_.gap && nearest.distance < nearest_.distance)) {
    nearest_ = nearest;
  }
}

void ElectrodeContact::find_links(const Solver& solver, const Electrode& electrode,
                                  std::span<const Eigen::Vector3f> positions) {
  links_.clear();
  const int samples = sample_count(electrode, radius_);
  for (const Index l : candidate_links_) {
    if (!solver.tissue().is_link_alive(l)) {
      continue;
    }
    const Eigen::Vector3d first = positions[solver.tissue().links()[l].first].cast<double>();
    const Eigen::Vector3d second = positions[solver.tissue().links()[l].second].cast<double>();
    double distance = std::numeric_limits<double>::infinity();
    for (int i = 0; i < samples; ++i) {
      distance = std::min(
          distance,
          distance_to_segment(first, second, point_at(electrode, sample_share(i, samples))));
    }
    if (distance < radius_) {
      links_.push_back({l, 1 - distance / radius_});
    }
  }
}

void ElectrodeContact::renumber(const Tissue& tissue, const Renumbering& ids) {
  const bool has_seen_links = seen_links_ == ids.links.size();
  renumber_list(candidate_links_, ids.links);
  seen_links_ = has_seen_links ? tissue.links().size() : kUnseen;
  listed_links_ = kUnseen;
  nearest_ = {};
  area_ = 0;
  near_.clear();
  links_.clear();
}

}  // namespace pbdsurg
