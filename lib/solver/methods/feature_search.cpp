// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/feature_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <span>
#include <vector>

#include "lib/solver/methods/feature_meeting.h"
#include "lib/solver/methods/handed_force.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

using Vector = Vec3<float>;

// The search of one tool.
class FeatureSearch {
 public:
  FeatureSearch(const StepContext& step, ToolState& tool, const NearFeatures* near,
                const Substep<float>& lengths, StepReport& report)
      : step_(step),
        vertices_(moving_vertices(step)),
        tool_(tool),
        near_(near),
        inverse_dt_squared_(lengths.inverse_dt_squared),
        goes_on_(moves_vertices(step.data.options) && !is_explicit(step.data.options)),
        report_(report),
        displacement_(tool.spring.displacement),
        box_(swept_box(tool).moved(displacement_)) {}

  void run() {
    tool_.surface_contacts.clear();
    list_triangles();
    const auto count = static_cast<Index>(step_.copy.particles.size());
    const auto consider_free = [&](Index place) {
      if (vertices_.moving[place].w > 0) {
        consider(std::array{place});
      }
    };
    if (near_ != nullptr) {
      std::ranges::for_each(near_->vertices, consider_free);
    }
    for (Index place = 0; near_ == nullptr && place < count && !tool_.capsules.empty(); ++place) {
      consider_free(place);
    }
    if (tool_.is_coupled()) {
      list_walls();
      std::ranges::for_each(step_.scratch.walls_at_tool,
                            [&](Index place) { consider(std::array{place}); });
    }
    for (const HalfSpace& half_space : tool_.half_spaces) {
      const SweptHalfSpace swept = swept_half_space(tool_, half_space).moved(displacement_);
      for (Index place = 0; place < count; ++place) {
        consider(place, swept);
      }
    }
    std::ranges::for_each(step_.scratch.triangles_at_tool,
                          [&](const auto& triangle) { consider_all(triangle); });
    // equal ones are the same: edges that four triangles share, triangles with two sides
    std::vector<SurfaceContact>& found = tool_.surface_contacts;
    std::ranges::sort(found, {}, &SurfaceContact::feature);
    const auto same = [](const SurfaceContact& a, const SurfaceContact& b) {
      return a.feature == b.feature;
    };
    found.erase(std::unique(found.begin(), found.end(), same), found.end());
    if (goes_on_) {
      std::ranges::for_each(tool_.remembered, [&](const auto& gone) { hand_over(gone); });
    }
  }

 private:
  // All around each feature that it touches among them, for their boxes hold the feature's.
  void list_triangles() const {
    std::vector<TissueSurface::PlaceTriangle>& listed = step_.scratch.triangles_at_tool;
    listed.clear();
    const auto list = [&](const TissueSurface::PlaceTriangle& triangle) {
      if (box_of(corners_of(step_, triangle)).meets(box_)) {
        listed.push_back(triangle);
      }
    };
    if (near_ != nullptr) {
      std::ranges::for_each(near_->triangles, list);
    } else if (tool_.meets_triangles()) {
      step_.data.surface.for_each_triangle(list);
    }
  }

  // Fixed vertices of surfaces: others that do not move have no tissue.
  void list_walls() const {
    std::vector<Index>& walls = step_.scratch.walls_at_tool;
    walls.clear();
    for (const TissueSurface::PlaceTriangle& triangle : step_.scratch.triangles_at_tool) {
      std::ranges::copy_if(triangle, std::back_inserter(walls),
                           [&](Index place) { return !(vertices_.moving[place].w > 0); });
    }
    std::ranges::sort(walls);
    walls.erase(std::unique(walls.begin(), walls.end()), walls.end());
  }

  [[nodiscard]] Outward outward_at(const ContactFeature& feature, float share) const {
    Outward outward(feature);
    for (const TissueSurface::PlaceTriangle& triangle : step_.scratch.triangles_at_tool) {
      outward.add(triangle.data(), [&](Index place) {
        return at_share(start_of(step_, vertices_, place), vertices_.position(place), share);
      });
    }
    return outward;
  }

  void add(const FeatureCorners& corners, const MetFeature& met, const RememberedContact* known) {
    if (!(met.gap < kInfinity)) {
      return;
    }
    if (tool_.surface_contacts.size() >=
        static_cast<std::size_t>(step_.data.options.contact_capacity)) {
      ++report_.dropped_contacts.at_surfaces;
      return;
    }
    SurfaceContact contact = contact_of(
        corners, met, [&](Index place) { return vertices_.base(place); },
        [&](Index place) { return own_start(step_, vertices_, place); });
    contact.takes_over = met.capsule != kInvalidIndex &&
                         may_take_over(known != nullptr,
                                       swept_capsule(tool_, static_cast<std::size_t>(met.capsule)));
    if (known != nullptr && goes_on_) {
      recall(*known, inverse_dt_squared_, contact);
    }
    tool_.surface_contacts.push_back(contact);
  }

  // What is above a plane with all vertices is above it.
  void consider(Index place, const SweptHalfSpace& half_space) {
    if (!(vertices_.moving[place].w > 0)) {
      return;
    }
    const FeatureCorners corners = corners_of(step_, std::array{place});
    MetFeature met;
    meet_half_space(corners, half_space, met);
    if (met.gap < kInfinity) {
      add(corners, met, find_remembered(feature_of(corners)));
    }
  }

  // Edges of a closed surface run from smaller to larger places in one of two triangles.
  void consider_all(const std::array<Index, 3>& triangle) {
    for (int k = 0; k < 3; ++k) {
      const Index first = triangle[k], second = triangle[(k + 1) % 3];
      if (first < second) {
        consider(std::array{first, second});
      }
    }
    if (triangle[1] == triangle[2]) {  // a link
      return;
    }
    std::array<Index, 3> places = triangle;
    std::ranges::sort(places);
    consider(places);
  }

  template <std::size_t kCount>
  void consider(const std::array<Index, kCount>& places) {
    FeatureCorners corners = corners_of(step_, places);
    const bool gives_way = tool_.is_coupled() || std::ranges::any_of(places, [&](Index p) {
                             return vertices_.moving[p].w > 0;
                           });
    if (!gives_way || !box_of(corners).meets(box_)) {
      return;
    }
    if (tool_.is_coupled()) {
      corners.take_as_free();
    }
    const RememberedContact* const known = find_remembered(feature_of(corners));
    const auto outward = [&](float share) { return outward_at(feature_of(corners), share); };
    MetFeature deepest;
    for (std::size_t c = 0; c < tool_.placed_capsules.size(); ++c) {
      meet_capsule(corners, swept_capsule(tool_, c).moved(displacement_), static_cast<Index>(c),
                   known != nullptr ? &known->normal : nullptr, outward, deepest);
    }
    add(corners, deepest, known);
  }

  [[nodiscard]] const RememberedContact* find_remembered(const ContactFeature& feature) const {
    const auto found =
        std::ranges::lower_bound(tool_.remembered, feature, {}, &RememberedContact::feature);
    return found != tool_.remembered.end() && found->feature == feature ? &*found : nullptr;
  }

  // Of a contact that is not met any more.
  void hand_over(const RememberedContact& gone) const {
    std::vector<SurfaceContact>& contacts = tool_.surface_contacts;
    if (!(gone.force > 0) ||
        std::ranges::binary_search(contacts, gone.feature, {}, &SurfaceContact::feature)) {
      return;
    }
    HandedForce handed;
    for (std::size_t c = 0; c < contacts.size(); ++c) {
      handed.consider(gone, contacts[c], static_cast<Index>(c));
    }
    if (handed.taker != kInvalidIndex) {
      contacts[static_cast<std::size_t>(handed.taker)].multiplier +=
          handed.share * gone.force / inverse_dt_squared_;
    }
  }

  const StepContext& step_;
  MovingVertices vertices_;
  ToolState& tool_;
  const NearFeatures* near_;
  float inverse_dt_squared_;
  bool goes_on_;  // from the forces of the substep before
  StepReport& report_;
  Vector displacement_;
  ContactBox box_;
};

}  // namespace

Vec3<float> start_of(const StepContext& step, const MovingVertices& vertices, Index place) {
  return vertices.bases == nullptr ? load(step.scratch.previous[place])
                                   : load(vertices.bases[place]);
}

FeatureCorners corners_of(const StepContext& step, std::span<const Index> places) {
  const MovingVertices vertices = moving_vertices(step);
  FeatureCorners corners;
  corners.count = static_cast<int>(places.size());
  for (std::size_t k = 0; k < places.size(); ++k) {
    corners.places[k] = places[k];
    corners.start[k] = start_of(step, vertices, places[k]);
    corners.end[k] = vertices.position(places[k]);
    corners.is_fixed[k] = !(vertices.moving[places[k]].w > 0);
  }
  return corners;
}

Vec3<float> told_way(const ToolState& tool) {
  return load(Eigen::Vector3f(tool.placed.translation() - tool.placed_before.translation()));
}

float way_of(const ToolState& tool) {
  float longest = 0;
  for (std::size_t c = 0; c < tool.placed_capsules.size(); ++c) {
    longest = std::max(longest, swept_capsule(tool, c).way());
  }
  return longest;
}

ContactBox swept_box(const ToolState& tool) {
  ContactBox box;
  for (std::size_t c = 0; c < tool.placed_capsules.size(); ++c) {
    const SweptCapsule swept = swept_capsule(tool, c);
    box.add(swept.now);
    box.add(swept.before);
  }
  return box;
}

SweptHalfSpace swept_half_space(const ToolState& tool, const HalfSpace& half_space) {
  const Eigen::Matrix3d now = tool.placed.linear().cast<double>();
  const Eigen::Matrix3f turn =
      (Eigen::Matrix3d::Identity() - tool.placed_before.linear().cast<double>() * now.transpose())
          .cast<float>();
  SweptHalfSpace swept{
      load(Eigen::Vector3f(tool.placed.linear() * half_space.normal)),
      load(Eigen::Vector3f(tool.placed * half_space.point)),
      {},
      load(Eigen::Vector3f(tool.placed.translation())),
      load(Eigen::Vector3f(tool.placed.translation() - tool.placed_before.translation()))};
  for (int row = 0; row < 3; ++row) {
    swept.turn[row] = load(Eigen::Vector3f(turn.row(row)));
  }
  return swept;
}

void find_surface_contacts(const StepContext& step, ToolState& tool, const NearFeatures* near,
                           const Substep<float>& lengths, StepReport& report) {
  FeatureSearch(step, tool, near, lengths, report).run();
}

void follow_feature(const StepContext& step, const ToolState& tool, SurfaceContact& contact) {
  if (contact.capsule == kInvalidIndex) {
    return;
  }
  const MovingVertices vertices = moving_vertices(step);
  const auto& [displacement, shift, yield] = tool.spring;
  const std::span<const Index> places(contact.feature.places);
  const auto count = static_cast<std::size_t>(contact.feature.count());
  FeatureCorners corners = corners_of(step, places.first(count));
  if (tool.is_coupled()) {
    corners.take_as_free();
  }
  turn_to(
      corners,
      swept_capsule(tool, static_cast<std::size_t>(contact.capsule)).moved(displacement + shift),
      shift, [&](Index place) { return vertices.base(place); },
      [&](Index place) { return own_start(step, vertices, place); }, contact);
}

void remember_contacts(ToolState& tool, float inverse_dt_squared) {
  tool.remembered.clear();
  for (const SurfaceContact& contact : tool.surface_contacts) {
    tool.remembered.push_back(remembered(contact, inverse_dt_squared));
  }
}

}  // namespace pbdsurg
