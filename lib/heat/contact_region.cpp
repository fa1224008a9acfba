// SPDX-License-Identifier: Apache-2.0
#include "lib/heat/contact_region.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "pbdsurg/mesh/topology.h"

#include "lib/tissue/renumber.h"

namespace pbdsurg {
namespace {

// A region is kept while the patch stays in its middle, as shares of its radius, and this share of
// its elements is left.
constexpr double kMostShift = 0.2;
constexpr double kMostGrowth = 1.25;
constexpr double kLeastLeft = 0.75;

// Share of a body's longest side: what its vertices reach beyond from wherever the centre is.
constexpr double kLargestRadius = 0.45;

}  // namespace

double ContactPatch::guess(const Eigen::Vector3d& point) const {
  return std::max(0.0, 1 - std::atan((point - centre).norm() / radius) / std::atan(reach / radius));
}

ContactRegion::ContactRegion(const ThermalMesh& mesh, double radii) : mesh_(mesh), radii_(radii) {
  std::vector<Eigen::AlignedBox3d> boxes(mesh.tissues().size());
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    if (mesh.tissue_of_vertex(v) != kInvalidIndex) {
      boxes[mesh.tissue_of_vertex(v)].extend(mesh.rest_positions()[v]);
    }
  }
  for (const Eigen::AlignedBox3d& box : boxes) {
    sides_.push_back(box.sizes().maxCoeff());
  }
}

bool ContactRegion::set_patch(std::span<const PatchVertex> patch, double area) {
  const auto same = [](const PatchVertex& a, const PatchVertex& b) {
    return a.vertex == b.vertex && a.weight == b.weight;
  };
  if (area == area_ && std::equal(patch.begin(), patch.end(), patch_.begin(), patch_.end(), same)) {
    return false;
  }
  patch_.assign(patch.begin(), patch.end());
  area_ = area;
  ++patch_number_;
  return true;
}

void ContactRegion::set_ground(std::span<const Index> vertices) {
  ground_.assign(vertices.begin(), vertices.end());
  std::sort(ground_.begin(), ground_.end());
  is_found_ = false;
}

void ContactRegion::renumber(const std::vector<Index>& vertices) {
  for (PatchVertex& touched : patch_) {
    touched.vertex = new_id(touched.vertex, vertices);
  }
  for (Index& v : ground_) {  // what is gone stays in it, or the ball might take its place
    v = new_id(v, vertices);
  }
  std::erase_if(patch_, [](const PatchVertex& p) { return p.vertex == kInvalidIndex; });
  std::ranges::sort(patch_, {}, &PatchVertex::vertex);
  std::ranges::sort(ground_);
  ++patch_number_;
  leave();
}

bool ContactRegion::find(const ElementSpan& conductivities) {
  find_seeds(conductivities);
  if (seeds_.empty()) {
    return false;
  }
  contact_ = measure_contact();
  if (!serves(has_next_ ? next_ : region_, conductivities)) {
    search(conductivities);
  }
  return true;
}

void ContactRegion::enter() noexcept {
  std::swap(region_, next_);
  has_next_ = false;
}

void ContactRegion::leave() {
  region_.clear();
  has_next_ = false;
  is_found_ = false;
}

void ContactRegion::find_seeds(const ElementSpan& conductivities) {
  seeds_.clear();
  for (const PatchVertex& touched : patch_) {
    bool conducts = false;
    if (touched.vertex < mesh_.vertex_count()) {  // else an undo took it away
      mesh_.for_each_element(touched.vertex, [&](Index t) {
        check_conductivity(t, conductivities[t]);
        conducts |= conductivities[t] > 0;
      });
    }
    if (conducts) {
      seeds_.push_back(touched);
    }
  }
}

ContactPatch ContactRegion::measure_contact() const {
  const std::span<const Eigen::Vector3d> points = mesh_.rest_positions();
  ContactPatch now;
  double weights = 0, lengths = 0, edges = 0;
  for (const PatchVertex& seed : seeds_) {
    now.centre += seed.weight * points[seed.vertex];
    weights += seed.weight;
    mesh_.for_each_element(seed.vertex, [&](Index t) {
      const std::span<const Index> corners = mesh_.corners(t);
      for (std::size_t a = 0; a < corners.size(); ++a) {
        for (std::size_t b = a + 1; b < corners.size(); ++b) {
          lengths += (points[corners[a]] - points[corners[b]]).norm();
          ++edges;
        }
      }
    });
  }
  now.centre /= weights;
  now.edge = lengths / edges;
  now.radius = std::max(std::sqrt(area_ / std::numbers::pi), 0.5 * now.edge);
  now.reach = std::min(radii_ * now.radius,
                       kLargestRadius * sides_[mesh_.tissue_of_vertex(seeds_.front().vertex)]);
  for (const PatchVertex& seed : seeds_) {
    now.reach = std::max(now.reach, 1.5 * (points[seed.vertex] - now.centre).norm());
  }
  return now;
}

// Whether a region is what a search would find, but for a shift of the ball.
bool ContactRegion::serves(const PotentialRegion& region, const ElementSpan& conductivities) {
  const bool is_at_most_less = version_ == mesh_.version() || growth_ == mesh_.growth();
  if (!is_found_ || !is_at_most_less || !collect_gone(region, conductivities)) {
    return false;
  }
  version_ = mesh_.version();
  growth_ = mesh_.growth();
  if (!gone_.empty()) {
    for (const Index i : gone_) {
      is_gone_[i] = 1;
    }
    gone_count_ += gone_.size();
    if (static_cast<double>(gone_count_) >
            (1 - kLeastLeft) * static_cast<double>(region.elements.size()) ||
        !joints_.hold_without(gone_, mesh_, region, search_, conductivities)) {
      return false;
    }
  } else if (found_patch_ == patch_number_) {
    return true;
  }
  return region.piece_count == 1 && is_in_middle(region);
}

// Returns whether all that did not conduct does not do so yet.
bool ContactRegion::collect_gone(const PotentialRegion& region, const ElementSpan& conductivities) {
  const auto conductivity = [&](Index t) {
    const double alive = conductivities[t];
    return mesh_.is_alive(t) ? alive : 0.0;
  };
  bool is_valid = true, is_same = true;  // without branches, for mostly nothing has gone
  for (std::size_t i = 0; i < region.elements.size(); ++i) {
    const double now = conductivity(region.elements[i]);
    found_conductivities_[i] = now;
    is_valid &= is_conductivity(now);
    is_same &= (now == 0) == (is_gone_[i] != 0);
  }
  gone_.clear();
  for (std::size_t i = 0; i < region.elements.size() && !(is_valid && is_same); ++i) {
    const bool is_gone = found_conductivities_[i] == 0;
    check_conductivity(region.elements[i], found_conductivities_[i]);
    if (is_gone && is_gone_[i] == 0) {
      gone_.push_back(static_cast<Index>(i));
    } else if (!is_gone && is_gone_[i] != 0) {
      return false;
    }
  }
  return std::ranges::none_of(region.insulators, [&](Index t) {
    check_conductivity(t, conductivity(t));
    return conductivity(t) > 0;
  });
}

bool ContactRegion::is_in_middle(const PotentialRegion& region) const {
  if (ground_.empty()) {
    const double growth = contact_.reach / found_contact_.reach;
    const double shift = (contact_.centre - found_contact_.centre).norm();
    if (growth > kMostGrowth || growth < 1 / kMostGrowth ||
        shift > kMostShift * found_contact_.reach) {
      return false;
    }
  } else if (has_overridden_ground_ || overrides_ground()) {
    return false;
  }
  return std::all_of(seeds_.begin(), seeds_.end(), [&](const PatchVertex& seed) {
    const Index row = search_.row_of(seed.vertex);
    return row != kInvalidIndex && region.is_ground[row] == 0;
  });
}

bool ContactRegion::is_seed(Index vertex) const {
  const auto found =
      std::lower_bound(seeds_.begin(), seeds_.end(), vertex,
                       [](const PatchVertex& seed, Index v) { return seed.vertex < v; });
  return found != seeds_.end() && found->vertex == vertex;
}

bool ContactRegion::is_given_ground(Index vertex) const {
  return std::binary_search(ground_.begin(), ground_.end(), vertex);
}

bool ContactRegion::overrides_ground() const {
  return std::any_of(seeds_.begin(), seeds_.end(),
                     [&](const PatchVertex& seed) { return is_given_ground(seed.vertex); });
}

void ContactRegion::search(const ElementSpan& conductivities) {
  is_found_ = false;  // its rows are lost if the search throws
  const std::span<const Eigen::Vector3d> points = mesh_.rest_positions();
  search_.find(
      mesh_, seeds_,
      [&](Index v) {
        return ground_.empty() ? (points[v] - contact_.centre).norm() >= contact_.reach
                               : is_given_ground(v) && !is_seed(v);
      },
      conductivities, next_);
  has_next_ = true;
  is_found_ = true;
  version_ = mesh_.version();
  growth_ = mesh_.growth();
  found_patch_ = patch_number_;
  found_contact_ = contact_;
  has_overridden_ground_ = overrides_ground();
  found_conductivities_.resize(next_.elements.size());
  std::ranges::transform(next_.elements, found_conductivities_.begin(),
                         [&](Index t) { return conductivities[t]; });
  is_gone_.assign(next_.elements.size(), 0);
  gone_count_ = 0;
}

}  // namespace pbdsurg
