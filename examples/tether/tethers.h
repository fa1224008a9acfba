// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Tethers: constraints of a program's own, that pull where they are too long.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "pbdsurg/solver/custom_constraints.h"
#include "pbdsurg/tissue/renumbering.h"

/// From a vertex to another, or to a point.
struct Tether {
  pbdsurg::Index vertex;
  pbdsurg::Index other = pbdsurg::kInvalidIndex;    ///< or none, and
  Eigen::Vector3f point = Eigen::Vector3f::Zero();  ///< m, in its place
  float length = 0;                                 ///< m, up to which it is slack
  float compliance = 0;                             ///< m/N, of what is beyond; 0: rigid
};

class Tethers final : public pbdsurg::CustomConstraints {
 public:
  explicit Tethers(std::vector<Tether> tethers) : tethers_(std::move(tethers)) { list_vertices(); }

  /// N, in the last substep
  [[nodiscard]] float tension(std::size_t tether, pbdsurg::Index copy = 0) const {
    return 0 - multipliers_.at(static_cast<std::size_t>(copy)).at(tether);
  }
  [[nodiscard]] const std::vector<Tether>& all() const { return tethers_; }

  [[nodiscard]] std::string name() const override { return "tethers"; }
  [[nodiscard]] std::span<const pbdsurg::Index> vertices() const override { return vertices_; }

  void begin_step(pbdsurg::Index copies) override {
    multipliers_.resize(static_cast<std::size_t>(copies));
    for (std::vector<float>& own : multipliers_) {
      own.resize(tethers_.size(), 0);
    }
  }
  void begin_substep(const pbdsurg::ConstraintSweep& sweep) override {
    std::ranges::fill(multipliers_[sweep.copy()], 0.0F);
  }
  void project(pbdsurg::ConstraintSweep& sweep) override {
    float* multiplier = multipliers_[sweep.copy()].data();
    for (const Tether& tether : tethers_) {
      project(sweep, tether, *multiplier++);
    }
  }

  // Whether a vertex has tissue is asked in each sweep, so edits and their undo change nothing
  // here.
  void follow(const pbdsurg::Tissue&, const pbdsurg::TissueChange&) noexcept override {}
  void undo(const pbdsurg::Tissue&, const pbdsurg::TissueChange&) noexcept override {}
  void renumber(const pbdsurg::Tissue&, const pbdsurg::Renumbering& ids) noexcept override {
    std::erase_if(tethers_, [&](Tether& tether) {
      tether.vertex = ids.vertices[tether.vertex];
      const bool has_other = tether.other != pbdsurg::kInvalidIndex;
      tether.other = has_other ? ids.vertices[tether.other] : tether.other;
      return tether.vertex == pbdsurg::kInvalidIndex ||
             (has_other && tether.other == pbdsurg::kInvalidIndex);
    });
    multipliers_.clear();
    list_vertices();
  }

 private:
  // Of C = |d| - length <= 0, d from the vertex to the other end.
  static void project(pbdsurg::ConstraintSweep& sweep, const Tether& tether, float& multiplier) {
    const bool has_other = tether.other != pbdsurg::kInvalidIndex;
    const Eigen::Vector3f d = has_other ? sweep.way(tether.vertex, tether.other)
                                        : sweep.way_to(tether.vertex, tether.point);
    const float length = d.norm();
    const bool is_there =
        sweep.has_tissue(tether.vertex) && (!has_other || sweep.has_tissue(tether.other));
    if (length == 0 || !is_there) {
      return;
    }
    const Eigen::Vector3f n = d / length;
    const std::array<pbdsurg::ConstraintSweep::Corner, 2> corners{
        {{tether.vertex, -n}, {tether.other, n}}};
    multiplier = sweep.satisfy({corners.data(), has_other ? 2U : 1U}, length - tether.length,
                               tether.compliance, multiplier, {.most = 0});
  }

  void list_vertices() {
    vertices_.clear();
    for (const Tether& tether : tethers_) {
      vertices_.push_back(tether.vertex);
      if (tether.other != pbdsurg::kInvalidIndex) {
        vertices_.push_back(tether.other);
      }
    }
  }

  std::vector<Tether> tethers_;
  std::vector<pbdsurg::Index> vertices_;
  std::vector<std::vector<float>> multipliers_;  // [copy][tether] N, at most 0
};
