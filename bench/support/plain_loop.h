// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What anybody would write first, as a yardstick: an array of vertices, all links, then all
/// tetrahedra, with the paper's fractions.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/coloring/greedy.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/tissue/scene.h"

#include "bench/support/paper_step.h"

namespace pbdsurg::bench {

class PlainLoop {
 public:
  enum Order { sorted, shuffled, colored };
  static constexpr int kIterations = 30;

  PlainLoop(const Scene& scene, Order order)
      : start_(stretched_positions(scene)), gravity_(scene.gravity()) {
    for (Index v = 0; v < scene.vertex_count(); ++v) {
      x_.push_back({0, 0, 0, scene.is_fixed(v) ? 0 : static_cast<float>(1 / scene.masses()[v])});
    }
    const auto positions = scene.positions();
    for (const auto& [a, b] : find_edges(scene.tets())) {
      links_.push_back({a, b, static_cast<float>((positions[a] - positions[b]).norm())});
    }
    for (const Link& link : scene.links()) {
      links_.push_back({link.first, link.second, link.rest_length});
    }
    if (order == shuffled) {
      sort_links([](std::size_t link) { return random_bits(1, link); });
    } else if (order == colored) {
      std::vector<Edge> ends;
      for (const LinkRecord& link : links_) {
        ends.push_back({link.a, link.b});
      }
      const Coloring coloring = color_greedy({std::span<const Edge>(ends), scene.vertex_count()});
      sort_links([&](std::size_t link) { return coloring.color_of[link]; });
    }
    for (const Tet& tet : scene.tets()) {
      tets_.push_back({tet, static_cast<float>(tet_volume(positions, tet))});
    }
    previous_.resize(start_.size());
    velocities_.resize(start_.size());
  }

  void restart() {
    for (std::size_t v = 0; v < x_.size(); ++v) {
      x_[v] = {start_[v].x(), start_[v].y(), start_[v].z(), x_[v].w};
      velocities_[v].setZero();
    }
  }

  void step() {
    for (std::size_t v = 0; v < x_.size(); ++v) {
      Vertex& p = x_[v];
      previous_[v] = {p.x, p.y, p.z};
      if (p.w > 0) {
        velocities_[v] += kPaperTimeStep * gravity_;
        p.x += kPaperTimeStep * velocities_[v].x();
        p.y += kPaperTimeStep * velocities_[v].y();
        p.z += kPaperTimeStep * velocities_[v].z();
      }
    }
    for (int i = 0; i < kIterations; ++i) {
      for (const LinkRecord& link : links_) {
        project(link);
      }
      for (const TetRecord& tet : tets_) {
        project(tet);
      }
    }
    for (std::size_t v = 0; v < x_.size(); ++v) {
      velocities_[v] = (Eigen::Vector3f(x_[v].x, x_[v].y, x_[v].z) - previous_[v]) / kPaperTimeStep;
    }
  }

  [[nodiscard]] std::size_t link_count() const { return links_.size(); }

  [[nodiscard]] bool is_finite() const {
    return std::all_of(x_.begin(), x_.end(), [](const Vertex& p) {
      return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
    });
  }

 private:
  struct alignas(16) Vertex {
    float x, y, z, w;
  };
  struct LinkRecord {
    Index a, b;
    float length;
  };
  struct TetRecord {
    Tet v;
    float volume;
  };

  template <class KeyOf>
  void sort_links(KeyOf key_of) {
    std::vector<std::pair<decltype(key_of(0)), std::size_t>> keys;
    for (std::size_t link = 0; link < links_.size(); ++link) {
      keys.emplace_back(key_of(link), link);
    }
    std::sort(keys.begin(), keys.end());
    std::vector<LinkRecord> sorted_links;
    for (const auto& [key, link] : keys) {
      sorted_links.push_back(links_[link]);
    }
    links_ = std::move(sorted_links);
  }

  void project(const LinkRecord& link) {
    Vertex& p = x_[link.a];
    Vertex& q = x_[link.b];
    const float w = p.w + q.w;
    const float dx = p.x - q.x, dy = p.y - q.y, dz = p.z - q.z;
    const float length = std::sqrt(dx * dx + dy * dy + dz * dz);
    if (w == 0 || length == 0) {
      return;
    }
    const float s = 0.4F * (length - link.length) / (length * w);
    p.x -= p.w * s * dx, p.y -= p.w * s * dy, p.z -= p.w * s * dz;
    q.x += q.w * s * dx, q.y += q.w * s * dy, q.z += q.w * s * dz;
  }

  void project(const TetRecord& tet) {
    Vertex& p0 = x_[tet.v[0]];
    Vertex& p1 = x_[tet.v[1]];
    Vertex& p2 = x_[tet.v[2]];
    Vertex& p3 = x_[tet.v[3]];
    const float ax = p1.x - p0.x, ay = p1.y - p0.y, az = p1.z - p0.z;
    const float bx = p2.x - p0.x, by = p2.y - p0.y, bz = p2.z - p0.z;
    const float cx = p3.x - p0.x, cy = p3.y - p0.y, cz = p3.z - p0.z;
    const float g1x = by * cz - bz * cy, g1y = bz * cx - bx * cz, g1z = bx * cy - by * cx;
    const float g2x = cy * az - cz * ay, g2y = cz * ax - cx * az, g2z = cx * ay - cy * ax;
    const float g3x = ay * bz - az * by, g3y = az * bx - ax * bz, g3z = ax * by - ay * bx;
    const float g0x = -(g1x + g2x + g3x), g0y = -(g1y + g2y + g3y), g0z = -(g1z + g2z + g3z);
    const float sum =
        p0.w * (g0x * g0x + g0y * g0y + g0z * g0z) + p1.w * (g1x * g1x + g1y * g1y + g1z * g1z) +
        p2.w * (g2x * g2x + g2y * g2y + g2z * g2z) + p3.w * (g3x * g3x + g3y * g3y + g3z * g3z);
    if (sum == 0) {
      return;
    }
    const float s = (ax * g1x + ay * g1y + az * g1z - 6 * tet.volume) / sum;
    p0.x -= p0.w * s * g0x, p0.y -= p0.w * s * g0y, p0.z -= p0.w * s * g0z;
    p1.x -= p1.w * s * g1x, p1.y -= p1.w * s * g1y, p1.z -= p1.w * s * g1z;
    p2.x -= p2.w * s * g2x, p2.y -= p2.w * s * g2y, p2.z -= p2.w * s * g2z;
    p3.x -= p3.w * s * g3x, p3.y -= p3.w * s * g3y, p3.z -= p3.w * s * g3z;
  }

  std::vector<Vertex> x_;
  std::vector<LinkRecord> links_;
  std::vector<TetRecord> tets_;
  std::vector<Eigen::Vector3f> start_, previous_, velocities_;
  Eigen::Vector3f gravity_;
};

}  // namespace pbdsurg::bench
