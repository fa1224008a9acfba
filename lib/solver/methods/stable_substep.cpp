// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/stable_substep.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "pbdsurg/constraints/bending.h"

#include "lib/solver/host/lane_access.h"
#include "lib/solver/methods/vertex_blocks.h"
#include "lib/solver/methods/vertex_kernel.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

// (b - a) x (c - a) of these is how six times the volume of a hinge changes with each vertex.
constexpr std::array<std::array<std::size_t, 3>, 4> kOpposite{
    {{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}}};

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// Infinite where the block is not finite: of what is as rigid as if it had no compliance.
double spectral_norm(const Eigen::Matrix3d& block) {
  if (!block.allFinite()) {
    return std::numeric_limits<double>::infinity();
  }
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> squares;
  squares.computeDirect(block.transpose() * block, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, squares.eigenvalues()[2]));
}

// How a spring resists: along it, and across under the tension that it has at rest.
Eigen::Matrix3d spring_block(const Eigen::Vector3d& d, double stiffness, double rest) {
  const double length = d.norm();
  if (!(length > 0) || !std::isfinite(stiffness)) {
    return stiffness * Eigen::Matrix3d::Identity();
  }
  const Eigen::Vector3d n = d / length;
  const double across = std::max(0.0, 1 - rest / length);
  return stiffness * ((1 - across) * (n * n.transpose()) + across * Eigen::Matrix3d::Identity());
}

}  // namespace

void StableSubstep::measure(const SolverData& data) {
  rest_.clear();
  squares_.clear();
  shares_.clear();
  ++revision_;
  fit(data);
  for (Index place = 0; place < static_cast<Index>(squares_.size()); ++place) {
    measure_vertex(data, place);
  }
}

void StableSubstep::fit(const SolverData& data) {
  const std::size_t count = data.particles.size();
  const std::span<const Eigen::Vector3d> rest = data.tissue->rest_positions();
  const std::size_t known = std::min(rest_.size(), count);
  rest_.resize(count);
  squares_.resize(count, 0);
  const VertexBlock* const blocks = data.vertex_blocks.rows().blocks;
  shares_.resize(static_cast<std::size_t>(data.vertex_blocks.block_count() * kBlockLanes), 0);
  for (Index block = 0; block < data.vertex_blocks.block_count(); ++block) {
    const auto first = shares_.begin() + block * kBlockLanes;
    std::fill(first + blocks[block].lane_count, first + kBlockLanes, 0.0F);
  }
  for (std::size_t v = known; v < count; ++v) {  // those that come have the last places
    rest_[data.place_of_vertex[v]] = rest[v];
  }
}

void StableSubstep::measure(const SolverData& data, std::span<const Index> places) {
  ++revision_;
  changed_.assign(places.begin(), places.end());
  for (const Index place : places) {
    measure_vertex(data, place);
    changed_.insert(changed_.end(), neighbors_.begin(), neighbors_.end());
  }
  std::ranges::sort(changed_);
  changed_.erase(std::unique(changed_.begin(), changed_.end()), changed_.end());
  for (const Index place : changed_) {
    measure_vertex(data, place);
  }
}

double StableSubstep::longest() const {
  return longest(0);
}

float StableSubstep::heading() const {
  return static_cast<float>(kHeading * longest());
}

double StableSubstep::longest(float stiffest) const {
  const double at_rest = squares_.empty() ? 0 : *std::ranges::max_element(squares_);
  if (!(at_rest > 0)) {
    return std::numeric_limits<double>::infinity();
  }
  double growth = kFirstGrowth;
  while (growth < kMostGrowth && growth * at_rest < double{stiffest}) {
    growth *= kNextGrowth;
  }
  return 2 / std::sqrt(growth * at_rest);
}

std::size_t StableSubstep::memory_bytes() const noexcept {
  const auto bytes = [](const auto&... lists) {
    return (... + (lists.capacity() * sizeof(lists[0])));
  };
  return bytes(rest_, squares_, shares_, changed_, neighbors_, blocks_);
}

Index StableSubstep::stiffest() const {
  return static_cast<Index>(std::ranges::max_element(squares_) - squares_.begin());
}

void StableSubstep::measure_vertex(const SolverData& data, Index place) {
  const VertexBlocks& vertices = data.vertex_blocks;
  neighbors_.clear();
  blocks_.clear();
  squares_[place] = 0;
  const auto [block, lane] = vertices.place_of(place);
  if (block == kInvalidIndex) {
    return;
  }
  float& share = shares_[static_cast<std::size_t>(block * kBlockLanes + lane)];
  share = 0;
  const float w = data.particles[place].w;
  if (!(w > 0)) {
    return;
  }
  double trace = 0;
  Eigen::Matrix3d own = Eigen::Matrix3d::Zero();
  const auto block_with = [&](Index other) -> Eigen::Matrix3d& {
    const auto found = std::ranges::find(neighbors_, other);
    const auto index = static_cast<std::size_t>(found - neighbors_.begin());
    if (found == neighbors_.end()) {
      neighbors_.push_back(other);
      blocks_.emplace_back(Eigen::Matrix3d::Zero());
    }
    return blocks_[index];
  };
  const auto add_pulls = [&](const auto& corners, const std::array<float, 6>& weights,
                             std::size_t corner) {
    for (std::size_t e = 0; e < kTetEdges.size(); ++e) {
      const std::size_t a = kTetEdges[e][0], b = kTetEdges[e][1];
      if (a == corner || b == corner) {
        const Eigen::Matrix3d pull = double{weights[e]} * Eigen::Matrix3d::Identity();
        own += pull;
        block_with(corners[a + b - corner]) -= pull;
      }
    }
  };
  for (const Index t : vertices.tets_at(place)) {
    const VertexTet& tet = vertices.tet(t);
    std::array<Eigen::Vector3d, 4> x, gradients;
    for (std::size_t k = 0; k < 4; ++k) {
      x[k] = rest_[tet.vertices[k]];
    }
    for (std::size_t k = 0; k < 4; ++k) {
      const auto& [a, b, c] = kTetTriangles[k];
      gradients[k] = (x[b] - x[a]).cross(x[c] - x[a]) / -6;
    }
    const double volume = (x[1] - x[0]).cross(x[2] - x[0]).dot(x[3] - x[0]) / 6;
    const double pressure = double{tet.stiffness} * (volume - double{tet.target});
    const auto corner =
        static_cast<std::size_t>(std::ranges::find(tet.vertices, place) - tet.vertices.begin());
    own += double{tet.stiffness} * gradients[corner] * gradients[corner].transpose();
    trace += double{tet.stiffness} * gradients[corner].squaredNorm();
    const auto& face = kTetTriangles[corner];
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Vector3d across = x[face[(i + 2) % 3]] - x[face[(i + 1) % 3]];
      block_with(tet.vertices[face[i]]) +=
          double{tet.stiffness} * gradients[corner] * gradients[face[i]].transpose() +
          pressure / -6 * skew(across);
    }
    add_pulls(tet.vertices, tet.weights, corner);
  }
  double fibres = 0;  // 1/s^2: as much in all directions, for wherever tissue turns them
  for (const Index t : vertices.tets_at(place)) {
    const VertexTet& tet = vertices.tet(t);
    const auto [s1, s2, s3] = tet.fibre_shares;
    const std::array<double, 4> shares{-(double{s1} + s2 + s3), s1, s2, s3};
    const auto corner =
        static_cast<std::size_t>(std::ranges::find(tet.vertices, place) - tet.vertices.begin());
    for (std::size_t k = 0; k < 4; ++k) {
      const double other = data.particles[tet.vertices[k]].w;
      fibres += tet.fibre_stiffness * std::abs(shares[corner] * shares[k]) * std::sqrt(w * other);
    }
  }
  for (const Index s : vertices.springs_at(place)) {
    const VertexSpring& spring = vertices.springs()[s];
    const Index other = spring.vertices[spring.vertices[0] == place ? 1 : 0];
    const Eigen::Vector3d d = rest_[other] - rest_[place];
    const Eigen::Matrix3d resistance =
        spring_block(d, spring.stiffness, spring.rest) +
        spring_block(d, spring.limit_stiffness, std::max(d.norm(), double{spring.limit}));
    own += resistance;
    block_with(other) -= resistance;
  }
  for (const Index h : vertices.hinges_at(place)) {
    const VertexHinge& hinge = vertices.hinges()[h];
    const auto corner =
        static_cast<std::size_t>(std::ranges::find(hinge.vertices, place) - hinge.vertices.begin());
    add_pulls(hinge.vertices, hinge.weights, corner);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& opposite = kOpposite[corner];
      const Eigen::Vector3d across = rest_[hinge.vertices[opposite[(i + 2) % 3]]] -
                                     rest_[hinge.vertices[opposite[(i + 1) % 3]]];
      block_with(hinge.vertices[opposite[i]]) += double{hinge.moment} * skew(across);
    }
    if (!(hinge.stiffness > 0)) {
      continue;
    }
    Vec3<double> corners[4];
    for (std::size_t k = 0; k < 4; ++k) {
      const Eigen::Vector3d& x = rest_[hinge.vertices[k]];
      corners[k] = {x.x(), x.y(), x.z()};
    }
    const auto turn = BendingConstraint::turn(corners, double{hinge.rest});
    const auto gradient = [&](std::size_t k) {
      const Vec3<double>& g = turn.gradient[k];
      return Eigen::Vector3d(g.x, g.y, g.z);
    };
    const Eigen::Vector3d force = double{hinge.stiffness} * gradient(corner);
    own += force * gradient(corner).transpose();
    for (std::size_t k = 0; k < 4; ++k) {
      if (k != corner) {
        block_with(hinge.vertices[k]) += force * gradient(k).transpose();
      }
    }
  }
  double sum = spectral_norm(own) * double{w} + fibres;
  for (std::size_t i = 0; i < neighbors_.size(); ++i) {
    const float other = data.particles[neighbors_[i]].w;
    sum += other > 0 ? spectral_norm(blocks_[i]) * std::sqrt(double{w} * double{other}) : 0;
  }
  squares_[place] = sum;
  share = trace > 0 && std::isfinite(sum) ? static_cast<float>(sum / trace) : 0.0F;
}

float stiffest_vertex(const SolverData& data, const CopyState& copy) {
  const VertexRows rows = data.vertex_blocks.rows();
  const std::span<const float> shares = data.stable_substep.shares();
  const float heading = data.stable_substep.heading();
  float largest = 0;
  for (Index b = 0; b < data.vertex_blocks.block_count(); ++b) {
    const VertexBlock& block = rows.blocks[b];
    for (Index lane = 0; lane < block.lane_count; ++lane) {
      const Vec3<float> base = load(at(copy.particles.data(), block.corners[lane]));
      const float share = shares[static_cast<std::size_t>(b * kBlockLanes + lane)];
      VolumeStiffness<float> stiffness;
      add_tree(rows, block,
               HeadingAccess{copy.particles.data(), copy.velocities.data(), base, heading, lane},
               stiffness);
      largest = stiffness.most(share, largest);
    }
  }
  return largest;
}

}  // namespace pbdsurg
