// SPDX-License-Identifier: Apache-2.0
#include "lib/contact/near_triangles.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pbdsurg {
namespace {

constexpr Index kGroup = 256;                                         // slots
constexpr float kUnbounded = std::numeric_limits<float>::infinity();  // m

}  // namespace

NearTriangles::NearTriangles(const Tissue& tissue, std::span<const Index> bodies,
                             float fastest_tissue)
    : fastest_tissue_(fastest_tissue) {
  for (const Index body : bodies) {
    surfaces_.push_back({shared_surface(tissue, body), tissue.body(body).thickness});
  }
}

void NearTriangles::check_tissue(const Tissue& tissue) const {
  for (const Surface& surface : surfaces_) {
    tissue.check_follower(*surface.live, "a contact probe");
  }
}

CulledSurface NearTriangles::culled(const Tissue& tissue, std::size_t body,
                                    std::span<const Triangle> triangles,
                                    std::span<const Eigen::Vector3f> positions) const {
  const Index index = surfaces_[body].live->body();
  if (index == kInvalidIndex) {
    return {};
  }
  const Material& material = tissue.body(index).material;
  const bool is_solid = material.model == ElasticModel::neo_hookean;
  return {triangles, positions, is_solid ? material.youngs_modulus : 0,
          is_solid ? material.poissons_ratio : 0, surfaces_[body].thickness};
}

void NearTriangles::add_near(const Tissue& tissue, std::vector<CulledSurface>& surfaces) const {
  for (std::size_t i = 0; i < surfaces_.size(); ++i) {
    for (const Group& group : surfaces_[i].groups) {
      if (!group.near.empty()) {
        surfaces.push_back(culled(tissue, i, group.near_triangles, positions_));
      }
    }
  }
}

void NearTriangles::note_reaches(std::span<const float> reaches) {
  for (std::size_t i = 0; i < reaches.size(); ++i) {
    reaches_[i] = reaches[i] + ContactPatch::kMargin;
  }
}

template <class Visit>
void NearTriangles::for_each_group(Visit visit) {
  for (Surface& surface : surfaces_) {
    for (Group& group : surface.groups) {
      visit(group);
    }
  }
}

void NearTriangles::forget() {
  vertices_.clear();
  places_.clear();
  has_looked_ = false;
  for (Surface& surface : surfaces_) {
    surface.seen_version = 0;
    surface.seen_renumberings = surface.live->renumberings();
    surface.groups.clear();
  }
}

void NearTriangles::follow_edits(const Solver& solver) {
  const auto vertex_count = static_cast<std::size_t>(solver.vertex_count());
  const bool has_old_ids =
      places_.size() > vertex_count || std::ranges::any_of(surfaces_, [](const Surface& surface) {
        return surface.seen_renumberings != surface.live->renumberings();
      });
  if (has_old_ids) {
    forget();
  }
  places_.resize(vertex_count, kInvalidIndex);
  for (Surface& surface : surfaces_) {
    if (surface.seen_version != surface.live->version()) {
      follow(surface);
    }
  }
}

// What an edit shows is near until its group is looked at.
void NearTriangles::follow(Surface& surface) {
  const auto place_of = [&](Index vertex) {
    if (places_[vertex] == kInvalidIndex) {
      places_[vertex] = static_cast<Index>(vertices_.size());
      vertices_.push_back(vertex);
    }
    return places_[vertex];
  };
  surface.live->collect_changes(surface.seen_version, ranges_);
  surface.seen_version = surface.live->version();
  const Index slots = surface.live->slot_count();
  surface.groups.resize(static_cast<std::size_t>((slots + kGroup - 1) / kGroup));
  for (std::size_t g = 0; g < surface.groups.size(); ++g) {
    Group& group = surface.groups[g];
    const Index first = static_cast<Index>(g) * kGroup;
    if (group.triangles.empty()) {  // new: all that it will have is near
      group.thickness = surface.thickness;
      group.looked_at = travelled_;
      group.slack = kSlack;
      std::ranges::copy(reaches_, group.reaches.begin());
    }
    const auto count = static_cast<std::size_t>(std::min(kGroup, slots - first));
    bool has_changed = group.triangles.size() != count;
    group.triangles.resize(count);
    for (const SlotRange& range : ranges_) {
      const Index end = std::min(range.end, first + kGroup);
      for (Index slot = std::max(range.first, first); slot < end; ++slot) {
        const auto& [a, b, c] = surface.live->triangles()[slot];
        group.triangles[slot - first] =
            a == b ? Triangle{0, 0, 0} : Triangle{place_of(a), place_of(b), place_of(c)};
        group.near.push_back(slot - first);
        has_changed = true;
      }
    }
    if (has_changed) {
      std::ranges::sort(group.near);
      group.near.erase(std::unique(group.near.begin(), group.near.end()), group.near.end());
      std::erase_if(group.near, [&](Index slot) {
        return static_cast<std::size_t>(slot) >= group.triangles.size() ||
               group.triangles[slot][0] == group.triangles[slot][1];
      });
      positions_.resize(vertices_.size());
      seen_at_.resize(vertices_.size());
      list_vertices(group.triangles, group.vertices);
      list_near(group);
    }
  }
}

void NearTriangles::list_vertices(std::span<const Triangle> triangles,
                                  std::vector<Index>& vertices) {
  ++lists_;
  vertices.clear();
  for (const Triangle& triangle : triangles) {
    for (const Index vertex : triangle) {
      if (triangle[0] != triangle[1] && seen_at_[vertex] != lists_) {
        seen_at_[vertex] = lists_;
        vertices.push_back(vertex);
      }
    }
  }
}

void NearTriangles::list_near(Group& group) {
  group.near_triangles.clear();
  for (const Index slot : group.near) {
    group.near_triangles.push_back(group.triangles[slot]);
  }
  list_vertices(group.near_triangles, group.near_vertices);
}

// m, that a ball or tissue may have gone since the last step; infinite if nothing tells
float NearTriangles::way_of(std::span<const ToolPoint> balls, double time) const {
  if (!has_looked_ || !(time >= time_)) {
    return kUnbounded;
  }
  float farthest = 0;
  for (std::size_t i = 0; i < balls.size(); ++i) {
    farthest = std::max(farthest, (balls[i].center - balls_[i].center).norm());
  }
  return farthest + fastest_tissue_ * static_cast<float>(time - time_);
}

// Whether something that was too far when it was looked at may matter now.
bool NearTriangles::is_due(const Group& group) const {
  float farther = 0;
  for (std::size_t i = 0; i < reaches_.size(); ++i) {
    farther = std::max(farther, reaches_[i] - group.reaches[i]);
  }
  return !(travelled_ - group.looked_at + double{farther} < double{group.slack});
}

// The vertices of what is near, and of groups that are due.
void NearTriangles::read(const Solver& solver) {
  read_.clear();
  for_each_group([&](const Group& group) {
    read_.insert(read_.end(), group.near_vertices.begin(), group.near_vertices.end());
  });
  for (const Group* group : looked_at_) {
    read_.insert(read_.end(), group->vertices.begin(), group->vertices.end());
  }
  if (read_.empty()) {  // a step may run, and reading would wait for it
    return;
  }
  read_vertices_.clear();
  for (const Index vertex : read_) {
    read_vertices_.push_back(vertices_[vertex]);
  }
  read_positions_.resize(read_.size());
  solver.read_positions(read_vertices_, read_positions_);
  for (std::size_t i = 0; i < read_.size(); ++i) {
    positions_[read_[i]] = read_positions_[i];
  }
}

// Gives groups what was found of them.
void NearTriangles::note_found() {
  auto place = cull_.places().begin();
  std::size_t first = 0;
  for (std::size_t i = 0; i < looked_at_.size(); ++i) {
    Group& group = *looked_at_[i];
    group.near.clear();
    const std::size_t end = first + group.triangles.size();
    for (; place != cull_.places().end() && *place < end; ++place) {
      group.near.push_back(static_cast<Index>(*place - first));
    }
    first = end;
    list_near(group);
    group.looked_at = travelled_;
    group.slack = std::min(kSlack + cull_.gaps()[i], kMostSlack);
    std::ranges::copy(reaches_, group.reaches.begin());
  }
}

void NearTriangles::look_at_due(std::span<const ToolPoint> balls) {
  culled_.clear();
  for (const Group* group : looked_at_) {
    culled_.push_back({group->triangles, positions_, 0, 0, group->thickness});
  }
  distances_.clear();
  for (const float reach : reaches_) {
    distances_.push_back(reach + kSlack);
  }
  cull_.find_within(culled_, balls, distances_);
  note_found();
}

// Which balls are deep in tissue, and how deep, is known of this alone.
void NearTriangles::look_at_all(const Solver& solver, std::span<const ToolPoint> balls) {
  solver.read_positions(vertices_, positions_);
  culled_.clear();
  looked_at_.clear();
  for_each_group([&](Group& group) {
    looked_at_.push_back(&group);
    culled_.push_back({group.triangles, positions_, 0, 0, group.thickness});
  });
  distances_.assign(balls.size(), kUnbounded);
  cull_.find(culled_, balls, distances_, ContactPatch::kMargin + kSlack);
  reaches_.resize(balls.size());
  note_reaches(cull_.reaches());
  note_found();
  constexpr double kGoldenRatio = 0.6180339887;
  double turn = 0;
  for (Group* group : looked_at_) {  // so that they are not all due at once
    turn += kGoldenRatio;
    group->slack *= static_cast<float>(0.5 + 0.5 * (turn - std::floor(turn)));
  }
  has_looked_ = true;
}

void NearTriangles::update(const Solver& solver, std::span<const ToolPoint> balls, double time) {
  follow_edits(solver);
  const float way = way_of(balls, time);
  if (way < kSlack) {
    travelled_ += double{way};
    for (float& reach : reaches_) {
      reach += way;
    }
    looked_at_.clear();
    for_each_group([&](Group& group) {
      if (is_due(group)) {
        looked_at_.push_back(&group);
      }
    });
    read(solver);
    look_at_due(balls);
  } else {
    look_at_all(solver, balls);
  }
  balls_.assign(balls.begin(), balls.end());
  time_ = time;
}

}  // namespace pbdsurg
