// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/surgery/connective_tissue.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numbers>
#include <string>
#include <utility>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/tissue/renumbering.h"

#include "lib/base/check.h"
#include "lib/base/describe.h"
#include "lib/mesh/segment_crossing.h"

namespace pbdsurg {
namespace {

constexpr char kWho[] = "connective tissue";  // in errors

using Eigen::Vector3d;
using Eigen::Vector3f;

void check(const StrandOptions& options) {
  if (options.segments < 1) {
    throw InvalidArgument("segments is " + std::to_string(options.segments) +
                          "; a strand has one at least");
  }
  check_positive("stiffness", options.stiffness, " N");
  check_positive("least_length", options.least_length, " m");
  check_positive("particle_mass", options.particle_mass, " kg");
  if (!(options.tear_stretch > 1)) {
    throw InvalidArgument("tear_stretch is " + describe(options.tear_stretch) +
                          "; it must be > 1, or infinite for strands that never tear");
  }
  if (!(options.slack >= 0) || !(options.slack <= 1)) {
    throw InvalidArgument("slack is " + describe(options.slack) + "; it must be in [0, 1]");
  }
  if (options.particle_mass != StrandOptions{}.particle_mass && options.segments == 1) {
    throw InvalidArgument("particle_mass is " + describe(options.particle_mass) +
                          " kg, which nothing would read; it needs two segments or more");
  }
  if (options.slack > 0 && options.segments == 1) {
    throw InvalidArgument("slack is " + describe(options.slack) +
                          " in strands of one segment, which would push the organs apart");
  }
}

// Joints of a strand over a gap of length 1, along it and across: on an arc of a circle that makes
// it longer than the gap by the slack. [segments + 1]
std::vector<Eigen::Vector2d> make_bow(int segments, double slack) {
  // a segment turns by an angle against the one before it; the more, the shorter the gap
  const auto gap = [&](double turn) {
    return turn > 0 ? std::sin(segments * turn / 2) / std::sin(turn / 2) : segments;
  };
  double low = 0, high = slack > 0 ? 2 * std::numbers::pi / segments : 0;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (gap(middle) * (1 + slack) > segments ? low : high) = middle;
  }
  std::vector<Eigen::Vector2d> joints{{0, 0}};
  for (int k = 0; k < segments; ++k) {
    const double angle = ((segments - 1) / 2.0 - k) * low;
    joints.push_back(joints.back() + Eigen::Vector2d(std::cos(angle), std::sin(angle)) / gap(low));
  }
  return joints;
}

// A strand's longest link, if all together are too long; kInvalidIndex otherwise.
// @param ends  [2 link_count] m
Index find_torn_link(const Strand& strand, std::span<const Vector3f> ends) {
  float sum = 0, longest = 0;
  Index weakest = 0;
  for (Index k = 0; k < strand.link_count; ++k) {
    const float length = (ends[2 * k + 1] - ends[2 * k]).norm();
    sum += length;
    if (length > longest) {
      longest = length;
      weakest = k;
    }
  }
  return sum > strand.tear_length ? strand.first_link + weakest : kInvalidIndex;
}

bool crosses(const BladeSweep& blade, const Vector3f& first, const Vector3f& second) {
  Eigen::AlignedBox3f link(first), sweep(blade.now.first);
  link.extend(second);
  sweep.extend(blade.now.second).extend(blade.before.first).extend(blade.before.second);
  if (!link.intersects(sweep)) {
    return false;
  }
  const Vector3d a = first.cast<double>(), b = second.cast<double>();
  const std::array<Vector3d, 4> corners{
      blade.before.first.cast<double>(), blade.before.second.cast<double>(),
      blade.now.second.cast<double>(), blade.now.first.cast<double>()};
  return segment_crosses(a, b, corners[0], corners[1], corners[2]) ||
         segment_crosses(a, b, corners[0], corners[2], corners[3]);
}

Index find_cut_link(const Strand& strand, std::span<const Vector3f> ends,
                    std::span<const BladeSweep> blades) {
  for (Index k = 0; k < strand.link_count; ++k) {
    for (const BladeSweep& blade : blades) {
      if (crosses(blade, ends[2 * k], ends[2 * k + 1])) {
        return strand.first_link + k;
      }
    }
  }
  return kInvalidIndex;
}

void check(std::span<const BladeSweep> blades) {
  for (std::size_t i = 0; i < blades.size(); ++i) {
    for (const BladeEdge& edge : {blades[i].before, blades[i].now}) {
      if (!edge.first.allFinite() || !edge.second.allFinite()) {
        throw InvalidArgument("blade " + std::to_string(i) + " is not finite");
      }
    }
  }
}

// Which strand a link is of, kInvalidIndex for another link. Links ascend with strands.
Index find_strand(std::span<const Strand> strands, Index link) {
  const auto next =
      std::upper_bound(strands.begin(), strands.end(), link,
                       [](Index l, const Strand& strand) { return l < strand.first_link; });
  if (next == strands.begin()) {
    return kInvalidIndex;
  }
  const Strand& strand = *(next - 1);
  return link < strand.first_link + strand.link_count
             ? static_cast<Index>(next - strands.begin()) - 1
             : kInvalidIndex;
}

}  // namespace

Index ConnectiveTissue::join(Scene& scene, Index first, Index second,
                             std::span<const MembraneLink> links, const StrandOptions& options) {
  check(options);
  const Body from = scene.body(first), to = scene.body(second);
  if (first == second) {
    throw InvalidArgument("body '" + from.name + "' (" + std::to_string(first) +
                          ") would be joined to itself; strands join two bodies");
  }
  for (std::size_t i = 0; i < links.size(); ++i) {
    const MembraneLink& link = links[i];
    for (const auto& [body, vertex] : {std::pair(&from, link.first), std::pair(&to, link.second)}) {
      if (vertex < 0 || vertex >= body->vertex_count) {
        throw InvalidArgument("link " + std::to_string(i) + ": body '" + body->name +
                              "' has no vertex " + std::to_string(vertex) +
                              "; ids must be in [0, " + std::to_string(body->vertex_count) + ")");
      }
    }
    if (!(link.rest_length >= 0) || !std::isfinite(link.rest_length) || link.fibres < 1) {
      throw InvalidArgument("link " + std::to_string(i) + " has rest length " +
                            describe(link.rest_length) + " m and " + std::to_string(link.fibres) +
                            " fibres; these must be >= 0 and >= 1");
    }
  }

  Scene joined = scene;
  const Index particles_each = options.segments - 1;
  if (particles_each > 0 && !links.empty()) {
    const std::vector<Eigen::Vector2d> bow = make_bow(options.segments, options.slack);
    std::vector<Vector3d> particles;
    for (std::size_t i = 0; i < links.size(); ++i) {
      const Vector3d& start = scene.positions()[from.first_vertex + links[i].first];
      const Vector3d way = scene.positions()[to.first_vertex + links[i].second] - start;
      Vector3d across = Vector3d::Zero();  // as long as the way
      if (way.norm() > 0) {
        const double turn = 2 * std::numbers::pi * random_unit(options.seed, i);
        across = Eigen::AngleAxisd(turn, way.normalized()) * (way.norm() * way.unitOrthogonal());
      }
      for (Index k = 1; k <= particles_each; ++k) {
        particles.push_back(start + bow[k].x() * way + bow[k].y() * across);
      }
    }
    joined.add_particles("strands from " + from.name + " to " + to.name, particles,
                         options.particle_mass);
  }

  const auto first_strand = static_cast<Index>(strands_.size());
  std::vector<Strand> strands = strands_;
  Index next_particle = scene.vertex_count();
  for (const MembraneLink& link : links) {
    const double rest = link.rest_length * (1 + options.slack) / options.segments;
    const double elastic = std::max(rest, options.least_length);
    const Stiffness stiffness{options.fraction,
                              static_cast<float>(elastic / (options.stiffness * link.fibres))};
    strands.push_back(
        {static_cast<Index>(joined.links().size()), options.segments, link.fibres,
         static_cast<float>(options.segments * (rest + (options.tear_stretch - 1) * elastic))});
    Index end = from.first_vertex + link.first;
    for (Index k = 0; k < options.segments; ++k) {
      const Index start = end;
      end = k < particles_each ? next_particle++ : to.first_vertex + link.second;
      joined.add_link({start, end, static_cast<float>(rest), stiffness});
    }
  }
  scene = std::move(joined);
  strands_ = std::move(strands);
  is_whole_.resize(strands_.size(), true);
  events_.reserve(strands_.size());
  collect_whole(scene.links());
  return first_strand;
}

ConnectiveTissue::ConnectiveTissue(std::vector<Strand> strands, std::vector<StrandEvent> events,
                                   const Tissue& tissue)
    : strands_(std::move(strands)),
      is_whole_(strands_.size(), true),
      events_(std::move(events)),
      undone_events_(events_.size()) {
  const std::span<const Link> links = tissue.links();
  std::int64_t end = 0;
  for (std::size_t s = 0; s < strands_.size(); ++s) {
    const Strand& strand = strands_[s];
    const std::int64_t next = std::int64_t{strand.first_link} + strand.link_count;
    if (strand.first_link < end || strand.link_count < 0 || next > std::ssize(links)) {
      throw InvalidArgument("strand " + std::to_string(s) + " is of links " +
                            std::to_string(strand.first_link) + " to " + std::to_string(next) +
                            "; they must be in [" + std::to_string(end) + ", " +
                            std::to_string(links.size()) + ")");
    }
    end = next;
  }
  for (std::size_t i = 0; i < events_.size(); ++i) {
    check_id("strand", events_[i].strand, strands_.size());
    if (!is_whole_[events_[i].strand]) {
      throw InvalidArgument("event " + std::to_string(i) + " is of strand " +
                            std::to_string(events_[i].strand) +
                            ", which had parted before; a strand parts once");
    }
    is_whole_[events_[i].strand] = false;
  }
  events_.reserve(strands_.size());
  collect_whole(links);
}

// Allocates in join() and in the constructor alone: later the whole strands are never more than
// they were then.
void ConnectiveTissue::collect_whole(std::span<const Link> links) noexcept {
  whole_.clear();
  ends_.clear();
  for (std::size_t s = 0; s < strands_.size(); ++s) {
    if (!is_whole_[s]) {
      continue;
    }
    whole_.push_back(static_cast<Index>(s));
    for (Index k = 0; k < strands_[s].link_count; ++k) {
      const Link& link = links[strands_[s].first_link + k];
      ends_.push_back(link.first);
      ends_.push_back(link.second);
    }
  }
}

bool ConnectiveTissue::is_whole(Index strand) const {
  check_id("strand", strand, is_whole_.size());
  return is_whole_[strand];
}

double ConnectiveTissue::share_lost(StrandLoss cause) const noexcept {
  if (strands_.empty()) {
    return 0;
  }
  const auto count = std::count_if(events_.begin(), events_.end(),
                                   [&](const StrandEvent& event) { return event.cause == cause; });
  return static_cast<double>(count) / static_cast<double>(strands_.size());
}

void ConnectiveTissue::read_ends(const Solver& solver) {
  solver.tissue().check_follower(*this, kWho);
  events_.reserve(strands_.size());  // follow() allocates nothing
  positions_.resize(ends_.size());
  solver.read_positions(ends_, positions_);
}

// Calls visit(strand, ends) for each whole strand.
template <class Visit>
void ConnectiveTissue::visit_whole(Visit visit) const {
  std::size_t next = 0;
  for (const Index s : whole_) {
    const auto count = static_cast<std::size_t>(2 * strands_[s].link_count);
    visit(strands_[s], std::span(positions_).subspan(next, count));
    next += count;
  }
}

void ConnectiveTissue::find_torn(const Solver& solver, std::vector<Index>& links) {
  read_ends(solver);
  visit_whole([&](const Strand& strand, std::span<const Vector3f> ends) {
    const Index torn = find_torn_link(strand, ends);
    if (torn != kInvalidIndex) {
      links.push_back(torn);
    }
  });
}

void ConnectiveTissue::find_cut(const Solver& solver, std::span<const BladeSweep> blades,
                                std::vector<Index>& links) {
  check(blades);
  read_ends(solver);
  visit_whole([&](const Strand& strand, std::span<const Vector3f> ends) {
    const Index cut = find_cut_link(strand, ends, blades);
    if (cut != kInvalidIndex) {
      links.push_back(cut);
    }
  });
}

void ConnectiveTissue::find_parting(const Solver& solver, std::span<const BladeSweep> blades,
                                    TopologyEdit& edit) {
  check(blades);
  read_ends(solver);
  causes_.clear();
  named_.clear();
  for (const Index link : edit.remove_links) {
    named_.push_back(find_strand(strands_, link));
  }
  std::ranges::sort(named_);
  visit_whole([&](const Strand& strand, std::span<const Vector3f> ends) {
    if (std::ranges::binary_search(named_, static_cast<Index>(&strand - strands_.data()))) {
      return;
    }
    const Index cut = find_cut_link(strand, ends, blades);
    const Index link = cut != kInvalidIndex ? cut : find_torn_link(strand, ends);
    if (link != kInvalidIndex) {
      edit.remove_links.push_back(link);
      causes_.emplace_back(link, link == cut ? StrandLoss::blade : StrandLoss::torn);
    }
  });
}

const TissueChange* ConnectiveTissue::separate(Solver& solver, std::span<const BladeSweep> blades) {
  edit_.remove_links.clear();
  find_parting(solver, blades, edit_);
  return edit_.remove_links.empty() ? nullptr : &solver.tissue().apply(edit_);
}

void ConnectiveTissue::renumber(const Tissue& tissue, const Renumbering& ids) noexcept {
  const auto count_left = [&](Index first, Index end) {
    return static_cast<Index>(std::count_if(ids.links.begin() + first, ids.links.begin() + end,
                                            [](Index id) { return id != kInvalidIndex; }));
  };
  Index end = 0, left = 0;  // before and after, of the links that were counted
  for (Strand& strand : strands_) {
    left += count_left(end, strand.first_link);
    end = strand.first_link + strand.link_count;
    const Index links = count_left(strand.first_link, end);
    strand.first_link = left;
    strand.link_count = links;
    left += links;
  }
  for (StrandEvent& event : events_) {
    event.link = kInvalidIndex;
  }
  collect_whole(tissue.links());
}

void ConnectiveTissue::follow(const Tissue& tissue, const TissueChange& change) noexcept {
  undone_events_ = events_.size();
  for (std::size_t i = 0; i < change.removed_links.size(); ++i) {
    const Index strand = find_strand(strands_, change.removed_links[i]);
    if (strand == kInvalidIndex || !is_whole_[strand]) {
      continue;
    }
    StrandLoss cause = StrandLoss::without_tissue;
    if (i < change.edit.remove_links.size()) {  // as asked; consequences follow
      const auto known = std::ranges::lower_bound(causes_, change.removed_links[i], {},
                                                  &std::pair<Index, StrandLoss>::first);
      cause = known != causes_.end() && known->first == change.removed_links[i]
                  ? known->second
                  : StrandLoss::removed;
    }
    is_whole_[strand] = false;
    events_.push_back({strand, change.removed_links[i], cause, change.version});
  }
  causes_.clear();
  if (events_.size() > undone_events_ || !change.edit.link_moves.empty()) {
    collect_whole(tissue.links());
  }
}

void ConnectiveTissue::undo(const Tissue& tissue, const TissueChange& change) noexcept {
  for (std::size_t i = undone_events_; i < events_.size(); ++i) {
    is_whole_[events_[i].strand] = true;
  }
  const bool has_changed = events_.size() > undone_events_ || !change.edit.link_moves.empty();
  events_.erase(events_.begin() + static_cast<std::ptrdiff_t>(undone_events_), events_.end());
  if (has_changed) {
    collect_whole(tissue.links());
  }
}

}  // namespace pbdsurg
