// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/vertex_blocks.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/tissue/scene.h"

#include "lib/solver/host/lane_access.h"
#include "lib/solver/methods/vertex_kernel.h"
#include "tests/support/catch.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"

namespace pbdsurg {
namespace {

using testing::Approx;

// A box of which some vertices are fixed and all carry every kind of row, with damping.
struct Sample {
  TetMesh mesh = testing::make_box({5, 4, 3}, 1e-3, 0.1);
  std::vector<Edge> edges = find_edges(mesh.tets());
  std::vector<bool> moves;
  std::vector<VertexTet> tets;
  std::vector<VertexSpring> springs;
  std::vector<VertexHinge> hinges;
  std::vector<Particle> particles;

  Sample() {
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      moves.push_back(v % 7 != 3);
      const Eigen::Vector3d& x = mesh.positions()[v];
      const auto shake = [&](int axis) {
        return static_cast<float>(x[axis] + 2e-4 * (random_unit(5, v, axis) - 0.5));
      };
      particles.push_back({shake(0), shake(1), shake(2), 1});
    }
    for (Index t = 0; t < mesh.tet_count(); ++t) {
      VertexTet tet{mesh.tets()[t], {}, 0, 1e-10F, {}, 0};
      tet.edge_damping.fill(1e-4F);
      for (std::size_t e = 0; e < 6; ++e) {
        tet.weights[e] = static_cast<float>(random_unit(6, t, e)) - 0.2F;
      }
      tet.stiffness = static_cast<float>(1e12 * (1 + random_unit(7, t)));
      tet.volume_damping = 1e-4F * tet.stiffness;
      tets.push_back(tet);
    }
    for (const Edge& edge : edges) {
      springs.push_back({edge, 2.0F, 9e-4F, 1e-4F});
    }
    Scene scene;
    scene.add_body("box", mesh, testing::kSprings);
    scene.add_hinges(0, 1);
    for (const Hinge& hinge : scene.hinges()) {
      hinges.push_back({hinge.vertices, 1e-5F, 0.1F, 1e-9F});
    }
  }

  [[nodiscard]] VertexBlocks build() const {
    return {moves, tets, springs, hinges, {.repair = true}};
  }
};

struct Entry {
  VertexEnergy<float> energy;
  bool found = false;
};

// [vertex_count] the energy around each vertex that has a place in some block
std::vector<Entry> energies(const VertexBlocks& blocks, const std::vector<Particle>& particles) {
  std::vector<Entry> entries(particles.size());
  std::vector<FixedPoint> points;
  for (const Particle& p : particles) {
    points.push_back(fixed_point({p.x, p.y, p.z}, {}, blocks.unit()));
  }
  const VertexRows rows = blocks.rows();
  for (Index b = 0; b < blocks.block_count(); ++b) {
    const VertexBlock& block = rows.blocks[b];
    for (Index lane = 0; lane < block.lane_count; ++lane) {
      const Index v = place_at(block.corners[lane]);
      CHECK_FALSE(entries[v].found);
      entries[v].found = true;
      add_rows(rows, block, LaneAccess{points.data(), points[v], lane}, entries[v].energy);
    }
  }
  return entries;
}

void check_alike(const VertexEnergy<float>& a, const VertexEnergy<float>& b) {
  const auto close = [](float x, float y, float scale) { return std::abs(x - y) <= 1e-5F * scale; };
  const float stiffness = a.isotropic + a.xx + a.yy + a.zz;
  CHECK(close(a.isotropic, b.isotropic, stiffness));
  CHECK(close(a.xx, b.xx, stiffness));
  CHECK(close(a.yz, b.yz, stiffness));
  const float force = 1e-3F * stiffness;
  CHECK(close(a.force.x, b.force.x, force));
  CHECK(close(a.force.y, b.force.y, force));
  CHECK(close(a.force.z, b.force.z, force));
}

void check_equal(const VertexBlocks& changed, const VertexBlocks& made,
                 const std::vector<Particle>& particles) {
  const auto a = energies(changed, particles);
  const auto b = energies(made, particles);
  for (std::size_t v = 0; v < a.size(); ++v) {
    REQUIRE(a[v].found == b[v].found);
    if (a[v].found) {
      check_alike(a[v].energy, b[v].energy);
    }
  }
}

}  // namespace

TEST_CASE("vertex blocks: each free vertex has one place, apart from its neighbours",
          "[property]") {
  const Sample sample;
  const VertexBlocks blocks = sample.build();
  const auto entries = energies(blocks, sample.particles);
  for (std::size_t v = 0; v < entries.size(); ++v) {
    CHECK(entries[v].found == sample.moves[v]);
  }

  std::vector<Index> color_of(entries.size(), kInvalidIndex);
  for (Index color = 0; color < blocks.color_count(); ++color) {
    const auto [first, count] = blocks.blocks(color);
    for (Index b = first; b < first + count; ++b) {
      const VertexBlock& block = blocks.rows().blocks[b];
      for (Index lane = 0; lane < block.lane_count; ++lane) {
        color_of[place_at(block.corners[lane])] = color;
      }
    }
  }
  for (const auto& [a, b] : sample.edges) {
    CHECK((color_of[a] == kInvalidIndex || color_of[a] != color_of[b]));
  }
  for (const VertexHinge& hinge : sample.hinges) {
    const Index a = hinge.vertices[2], b = hinge.vertices[3];
    CHECK((color_of[a] == kInvalidIndex || color_of[a] != color_of[b]));
  }
  CHECK(blocks.color_count() <= 11);
}

// Would catch two threads at one vertex: what fills a block up reads its own vertices alone.
TEST_CASE("vertex blocks: padding names the vertex itself, and idle lanes repeat the last",
          "[property]") {
  const Sample sample;
  const VertexBlocks blocks = sample.build();
  const VertexRows rows = blocks.rows();
  Index padded = 0, padded_hinges = 0;
  for (Index b = 0; b < blocks.block_count(); ++b) {
    const VertexBlock& block = rows.blocks[b];
    for (Index i = 0; i < block.volumes.count; ++i) {
      const VolumeRow& row = rows.volumes[block.volumes.first + i];
      for (Index lane = 0; lane < block.lane_count; ++lane) {
        if (row.stiffness[lane] == 0) {
          ++padded;
          CHECK(row.face[0][lane] == block.corners[lane]);
          CHECK(row.face[2][lane] == block.corners[lane]);
        }
      }
      for (Index lane = block.lane_count; lane < kBlockLanes; ++lane) {
        CHECK(block.corners[lane] == block.corners[block.lane_count - 1]);
        CHECK(row.face[1][lane] == row.face[1][block.lane_count - 1]);
        CHECK(row.stiffness[lane] == row.stiffness[block.lane_count - 1]);
      }
    }
    for (Index i = 0; i < block.hinges.count; ++i) {
      const HingeRow& row = rows.hinges[block.hinges.first + i];
      for (Index lane = 0; lane < block.lane_count; ++lane) {
        if (row.stiffness[lane] == 0) {
          ++padded_hinges;
          CHECK(row.neighbors[0][lane] == block.corners[lane]);
          CHECK(row.neighbors[2][lane] == block.corners[lane]);
        }
      }
      for (Index lane = block.lane_count; lane < kBlockLanes; ++lane) {
        CHECK(row.neighbors[1][lane] == row.neighbors[1][block.lane_count - 1]);
        CHECK(row.is_opposite[lane] == row.is_opposite[block.lane_count - 1]);
        CHECK(row.rest[lane] == row.rest[block.lane_count - 1]);
      }
    }
    for (Index i = 0; i < block.pulls.count; ++i) {
      const PullRow& row = rows.pulls[block.pulls.first + i];
      for (Index lane = block.lane_count; lane < kBlockLanes; ++lane) {
        CHECK(row.weights[lane] == row.weights[block.lane_count - 1]);
        CHECK(row.neighbors[lane] == row.neighbors[block.lane_count - 1]);
      }
    }
  }
  CHECK(padded > 0);
  CHECK(padded_hinges > 0);
}

TEST_CASE("vertex blocks: changed rows are those of blocks made that way", "[property]") {
  Sample sample;
  VertexBlocks changed = sample.build();
  std::vector<VertexTet> kept;
  for (Index t = 0; t < static_cast<Index>(sample.tets.size()); ++t) {
    if (t % 5 == 2) {
      changed.remove_tet(t);
      continue;
    }
    if (t % 5 == 3) {
      sample.tets[t].target = 2e-10F;
      sample.tets[t].weights[1] = 3;
      changed.set_tet(t, sample.tets[t]);
    }
    kept.push_back(sample.tets[t]);
  }
  std::vector<VertexSpring> springs;
  for (Index s = 0; s < static_cast<Index>(sample.springs.size()); ++s) {
    if (s % 4 == 1) {
      changed.remove_spring(s);
      continue;
    }
    if (s % 4 == 2) {
      sample.springs[s].rest = 5e-4F;
      changed.set_spring_rest(s, 5e-4F);
    }
    springs.push_back(sample.springs[s]);
  }
  std::vector<VertexHinge> hinges;
  for (Index h = 0; h < static_cast<Index>(sample.hinges.size()); ++h) {
    if (h % 3 == 1) {
      changed.remove_hinge(h);
    } else {
      hinges.push_back(sample.hinges[h]);
    }
  }
  changed.refresh();
  VertexBlocks made(sample.moves, kept, springs, hinges, {.repair = true});
  check_equal(changed, made, sample.particles);

  // and so are those that a substep makes of them
  std::vector<Particle> start = sample.particles;
  for (std::size_t v = 0; v < start.size(); ++v) {
    start[v].x *= 1.02F;
  }
  const std::vector<Carry> carries(start.size());
  add_damping(changed.damped_rows(), changed.block_count(), start, carries, 1e4F);
  add_damping(made.damped_rows(), made.block_count(), start, carries, 1e4F);
  check_equal(changed, made, sample.particles);
}

TEST_CASE("vertex blocks: rows that no vertex of a block needs any more go", "[unit]") {
  const Sample sample;
  VertexBlocks blocks = sample.build();
  for (Index t = 0; t < static_cast<Index>(sample.tets.size()); ++t) {
    blocks.remove_tet(t);
  }
  for (Index s = 0; s < static_cast<Index>(sample.springs.size()); ++s) {
    blocks.remove_spring(s);
  }
  for (Index h = 0; h < static_cast<Index>(sample.hinges.size()); ++h) {
    blocks.remove_hinge(h);
  }
  blocks.refresh();

  for (Index b = 0; b < blocks.block_count(); ++b) {
    const VertexBlock& block = blocks.rows().blocks[b];
    CHECK(block.pulls.count + block.springs.count + block.volumes.count + block.hinges.count == 0);
  }
}

// A dashpot's force is its coefficient times the rate of its length; at the start there is none.
TEST_CASE("vertex blocks: damping resists what has changed since the start", "[unit]") {
  const std::vector<bool> moves{true, false};
  const float damping = 3e-3F, inverse_dt = 1e3F;
  VertexBlocks blocks(moves, {}, {{{0, 1}, 2.0F, 0.01F, damping}}, {}, {});
  std::vector<Particle> particles{{0, 0, 0, 1}, {0.012F, 0, 0, 0}};
  add_damping(blocks.damped_rows(), 1, particles, std::vector<Carry>(2), inverse_dt);

  CHECK(energies(blocks, particles)[0].energy.force.x == Approx(2 * 0.002).epsilon(1e-4));
  particles[1].x = 0.013F;
  CHECK(energies(blocks, particles)[0].energy.force.x ==
        Approx(2 * 0.003 + damping * 0.001 * inverse_dt).epsilon(1e-4));
}

// Would catch a dashpot of tangents, which is none where they grow: near half a turn.
TEST_CASE("vertex blocks: a damped hinge is drawn to rest from where it starts", "[unit]") {
  const double rest = GENERATE(-3.0, -0.4, 0.0, 0.7, 3.0);  // rad
  const double bent = GENERATE(-3.1, -0.2, 1.5, 3.1);
  const double share = GENERATE(0.0, 0.25, 1.0);
  const double pi = std::acos(-1.0);
  const auto turn_of = [](double angle) { return 4 * std::tan(angle / 4); };
  const auto way = [&](double angle) { return std::remainder(angle, 2 * pi); };
  const double start = turn_of(way(bent - rest));
  const double target = 4 * std::atan(turned_rest(turn_of(rest), share * start) / 4);
  const double expected = rest + 4 * std::atan(share * start / 4);
  CHECK(std::abs(target) <= pi + 1e-9);
  CHECK(std::abs(way(target - expected)) < 1e-9);
}

}  // namespace pbdsurg
