// SPDX-License-Identifier: Apache-2.0
#include "lib/contact/near_triangles.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pbdsurg {
namespace {

constexpr std::size_t kGroup = 256;                             // slots
constexpr float kAll = std::numeric_limits<float>::infinity();  // m: surfaces are whole

}  // namespace

NearTriangles::NearTriangles(const Tissue& tissue, std::span<const Index> bodies,
                             float fastest_tissue)
    : fastest_tissue_(fastest_tissue) {
  for (const Index body : bodies) {
    surfaces_.push_back({shared_surface(tissue, body)});
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
          is_solid ? material.poissons_ratio : 0};
}

void NearTriangles::add_near(const Tissue& tissue, std::vector<CulledSurface>& surfaces) const {
  for (std::size_t i = 0; i < surfaces_.size(); ++i) {
    surfaces.push_back(culled(tissue, i, surfaces_[i].near, positions_));
  }
}

void NearTriangles::note_reaches(std::span<const float> reaches) {
  for (std::size_t i = 0; i < reaches.size(); ++i) {
    reaches_[i] = reaches[i] + ContactPatch::kMargin;
  }
}

std::span<const Triangle> NearTriangles::triangles_of(const Surface& surface, std::size_t group) {
  const std::span<const Triangle> all = surface.triangles;
  return all.subspan(group * kGroup, std::min(kGroup, all.size() - group * kGroup));
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

// What an edit shows is near until its group is looked at.
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
  positions_.resize(vertices_.size());
  seen_at_.resize(vertices_.size());
}

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
  surface.triangles.resize(static_cast<std::size_t>(surface.live->slot_count()));
  const std::size_t known = surface.groups.size();
  surface.groups.resize((surface.triangles.size() + kGroup - 1) / kGroup);
  for (std::size_t group = known; group < surface.groups.size(); ++group) {
    take_turn(surface.groups[group]);
  }
  std::size_t changed = surface.groups.size();  // the last that was
  const auto sort_changed = [&] {
    if (changed < surface.groups.size()) {
      std::vector<Index>& near = surface.groups[changed].near;
      std::ranges::sort(near);
      near.erase(std::unique(near.begin(), near.end()), near.end());
    }
  };
  for (const SlotRange& range : ranges_) {
    for (Index slot = range.first; slot < range.end; ++slot) {
      const auto& [a, b, c] = surface.live->triangles()[slot];
      surface.triangles[slot] =
          a == b ? Triangle{0, 0, 0} : Triangle{place_of(a), place_of(b), place_of(c)};
      const std::size_t group = static_cast<std::size_t>(slot) / kGroup;
      if (group != changed) {
        sort_changed();
        changed = group;
      }
      surface.groups[group].near.push_back(slot);
    }
  }
  sort_changed();
  for (Group& group : surface.groups) {
    std::erase_if(group.near, [&](Index slot) {
      return static_cast<std::size_t>(slot) >= surface.triangles.size() ||
             surface.triangles[slot][0] == surface.triangles[slot][1];
    });
  }
}

// m, that a ball or tissue may have gone since the last step; infinite if nothing tells
float NearTriangles::way_of(std::span<const ToolPoint> balls, double time) const {
  if (!has_looked_ || !(time >= time_)) {
    return kAll;
  }
  float farthest = 0;
  for (std::size_t i = 0; i < balls.size(); ++i) {
    farthest = std::max(farthest, (balls[i].center - balls_[i].center).norm());
  }
  return farthest + fastest_tissue_ * static_cast<float>(time - time_);
}

void NearTriangles::take_turn(Group& group) {
  group.looked_at = travelled_;
  std::ranges::copy(reaches_, group.reaches.begin());
}

// Whether something that was too far when it was looked at may matter now.
bool NearTriangles::is_due(const Group& group) const {
  double gone = travelled_ - group.looked_at;
  float farther = 0;
  for (std::size_t i = 0; i < reaches_.size(); ++i) {
    farther = std::max(farther, reaches_[i] - group.reaches[i]);
  }
  return !(gone + double{farther} < double{kSlack});
}

// Those that are due, and so many in turn that few will be.
void NearTriangles::choose_groups(float way) {
  chosen_.clear();
  std::size_t count = 0;
  for (const Surface& surface : surfaces_) {
    count += surface.groups.size();
  }
  const auto turns =
      static_cast<std::size_t>(std::ceil(std::min(1.0F, way / kSlack) * static_cast<float>(count)));
  next_ = next_ < count ? next_ : 0;
  std::size_t place = 0;
  for (std::size_t s = 0; s < surfaces_.size(); ++s) {
    for (std::size_t g = 0; g < surfaces_[s].groups.size(); ++g, ++place) {
      const std::size_t wait = place < next_ ? place + count - next_ : place - next_;
      if (wait < turns || is_due(surfaces_[s].groups[g])) {
        chosen_.push_back({s, g});
      }
    }
  }
  next_ = count == 0 ? 0 : (next_ + turns) % count;
}

// The vertices of what is near and of chosen groups.
void NearTriangles::read(const Solver& solver) {
  ++lists_;
  read_.clear();
  read_vertices_.clear();
  const auto add = [&](const Triangle& triangle) {
    for (const Index vertex : triangle) {
      if (seen_at_[vertex] != lists_) {
        seen_at_[vertex] = lists_;
        read_.push_back(vertex);
        read_vertices_.push_back(vertices_[vertex]);
      }
    }
  };
  for (const Surface& surface : surfaces_) {
    for (const Group& group : surface.groups) {
      for (const Index slot : group.near) {
        add(surface.triangles[slot]);
      }
    }
  }
  for (const GroupPlace& chosen : chosen_) {
    for (const Triangle& triangle : triangles_of(surfaces_[chosen.surface], chosen.group)) {
      if (triangle[0] != triangle[1]) {
        add(triangle);
      }
    }
  }
  if (read_.empty()) {  // a step may run, and reading would wait for it
    return;
  }
  read_positions_.resize(read_.size());
  solver.read_positions(read_vertices_, read_positions_);
  for (std::size_t i = 0; i < read_.size(); ++i) {
    positions_[read_[i]] = read_positions_[i];
  }
}

// Gives what was found, by its places in all triangles of chosen groups, to these.
void NearTriangles::share_found() {
  auto place = cull_.places().begin();
  std::size_t first = 0;
  for (const GroupPlace& chosen : chosen_) {
    Surface& surface = surfaces_[chosen.surface];
    Group& group = surface.groups[chosen.group];
    group.near.clear();
    const std::size_t end = first + triangles_of(surface, chosen.group).size();
    for (; place != cull_.places().end() && *place < end; ++place) {
      group.near.push_back(static_cast<Index>(*place - first + chosen.group * kGroup));
    }
    first = end;
    take_turn(group);
  }
}

void NearTriangles::look_at_chosen(std::span<const ToolPoint> balls) {
  culled_.clear();
  for (const GroupPlace& chosen : chosen_) {
    culled_.push_back({triangles_of(surfaces_[chosen.surface], chosen.group), positions_, 0, 0});
  }
  distances_.clear();
  for (const float reach : reaches_) {
    distances_.push_back(reach + kSlack);
  }
  cull_.find_within(culled_, balls, distances_);
  share_found();
}

// Which balls are deep in tissue, and how deep, is known of this alone.
void NearTriangles::look_at_all(const Solver& solver, std::span<const ToolPoint> balls) {
  solver.read_positions(vertices_, positions_);
  culled_.clear();
  chosen_.clear();
  for (std::size_t s = 0; s < surfaces_.size(); ++s) {
    culled_.push_back({surfaces_[s].triangles, positions_, 0, 0});
    for (std::size_t g = 0; g < surfaces_[s].groups.size(); ++g) {
      chosen_.push_back({s, g});
    }
  }
  distances_.assign(balls.size(), kAll);
  cull_.find(culled_, balls, distances_, ContactPatch::kMargin + kSlack);
  reaches_.resize(balls.size());
  note_reaches(cull_.reaches());
  share_found();
  has_looked_ = true;
}

void NearTriangles::list_near() {
  for (Surface& surface : surfaces_) {
    surface.near.clear();
    for (const Group& group : surface.groups) {
      for (const Index slot : group.near) {
        surface.near.push_back(surface.triangles[slot]);
      }
    }
  }
}

void NearTriangles::update(const Solver& solver, std::span<const ToolPoint> balls, double time) {
  follow_edits(solver);
  const float way = way_of(balls, time);
  if (way < kSlack) {
    travelled_ += double{way};
    for (float& reach : reaches_) {
      reach += way;
    }
    choose_groups(way);
    read(solver);
    look_at_chosen(balls);
  } else {
    look_at_all(solver, balls);
  }
  list_near();
  balls_.assign(balls.begin(), balls.end());
  time_ = time;
}

}  // namespace pbdsurg
