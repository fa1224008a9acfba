// SPDX-License-Identifier: Apache-2.0
// The serial step against a plain loop over the same constraints: the mesh of table 2's second row,
// paper mode (fractions 0.4 and 1, 30 iterations, 0.2 ms), one rim fixed, stretched by 10 %.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <benchmark/benchmark.h>

#include "pbdsurg/anatomy/table2_family.h"
#include "pbdsurg/coloring/greedy.h"
#include "pbdsurg/core/random.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/solver/solver.h"

namespace pbdsurg {
namespace {

constexpr float kTimeStep = 2e-4F;  // s
constexpr int kIterations = 30;
constexpr float kStretch = 1.1F;

const TetMesh& mesh() {
  static const TetMesh row = table2_mesh(2);
  return row;
}

Scene make_scene() {
  Scene scene;
  const Index body = scene.add_body("gallbladder", mesh());
  const double low = bounding_box(mesh()).min().x();
  scene.fix_where(body, [&](const Eigen::Vector3d& x) { return x.x() < low + 3e-3; });
  return scene;
}

std::vector<Eigen::Vector3f> stretched() {
  std::vector<Eigen::Vector3f> x;
  for (const Eigen::Vector3d& p : mesh().positions()) {
    x.emplace_back(kStretch * p.x(), p.y(), p.z());
  }
  return x;
}

void report_work(benchmark::State& state, std::size_t edges) {
  state.counters["edges"] = static_cast<double>(edges);
  state.counters["tets"] = mesh().tet_count();
  state.counters["time_per_projection"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * kIterations *
                             (static_cast<double>(edges) + mesh().tet_count()),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void BM_serial_step(benchmark::State& state, PlanComposition composition) {
  SolverOptions options = SolverOptions::paper();
  options.composition = composition;
  Solver solver(make_scene(), options);
  state.SetLabel(solver.plan().name);
  state.counters["colors"] = static_cast<double>(solver.plan().phases.size());
  solver.write_positions(stretched());
  const Snapshot start = solver.snapshot();
  solver.step(kTimeStep);
  const std::uint64_t expected = solver.state_hash();
  for (auto _ : state) {
    state.PauseTiming();
    solver.restore(start);
    state.ResumeTiming();
    solver.step(kTimeStep);
  }
  if (solver.state_hash() != expected) {
    state.SkipWithError("the end state differs from that of the first run");
  }
  report_work(state, solver.edges().size());
}

// What anybody would write first: an array of vertices, all links, then all tetrahedra.
class PlainLoop {
 public:
  enum Order { sorted, shuffled, colored };

  explicit PlainLoop(Order order) {
    const Scene scene = make_scene();
    for (Index v = 0; v < scene.vertex_count(); ++v) {
      x_.push_back({0, 0, 0, scene.is_fixed(v) ? 0 : static_cast<float>(1 / scene.masses()[v])});
    }
    std::vector<Edge> edges = find_edges(mesh().tets());
    if (order == shuffled) {
      std::vector<std::pair<std::uint64_t, Edge>> keys;
      for (std::size_t e = 0; e < edges.size(); ++e) {
        keys.emplace_back(random_bits(1, e), edges[e]);
      }
      std::sort(keys.begin(), keys.end());
      for (std::size_t e = 0; e < edges.size(); ++e) {
        edges[e] = keys[e].second;
      }
    } else if (order == colored) {
      const Coloring coloring = color_greedy({std::span<const Edge>(edges), mesh().vertex_count()});
      std::vector<std::pair<Index, Edge>> keys;
      for (std::size_t e = 0; e < edges.size(); ++e) {
        keys.emplace_back(coloring.color_of[e], edges[e]);
      }
      std::sort(keys.begin(), keys.end());
      for (std::size_t e = 0; e < edges.size(); ++e) {
        edges[e] = keys[e].second;
      }
    }
    const auto positions = mesh().positions();
    for (const Edge& edge : edges) {
      links_.push_back(
          {edge[0], edge[1], static_cast<float>((positions[edge[0]] - positions[edge[1]]).norm())});
    }
    for (const Tet& tet : mesh().tets()) {
      tets_.push_back({tet, static_cast<float>(tet_volume(positions, tet))});
    }
    start_ = stretched();
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
        velocities_[v].y() -= 9.81F * kTimeStep;
        p.x += kTimeStep * velocities_[v].x();
        p.y += kTimeStep * velocities_[v].y();
        p.z += kTimeStep * velocities_[v].z();
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
      velocities_[v] = (Eigen::Vector3f(x_[v].x, x_[v].y, x_[v].z) - previous_[v]) / kTimeStep;
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
};

void BM_plain_loop(benchmark::State& state, PlainLoop::Order order) {
  PlainLoop loop(order);
  for (auto _ : state) {
    state.PauseTiming();
    loop.restart();
    state.ResumeTiming();
    loop.step();
  }
  if (!loop.is_finite()) {
    state.SkipWithError("the end state is not finite");
  }
  report_work(state, loop.link_count());
}

BENCHMARK_CAPTURE(BM_serial_step, separate, PlanComposition::separate)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_serial_step, joint, PlanComposition::joint)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_plain_loop, links_sorted, PlainLoop::sorted)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_plain_loop, links_shuffled, PlainLoop::shuffled)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_plain_loop, links_colored, PlainLoop::colored)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pbdsurg

BENCHMARK_MAIN();
