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
      const bool is_flat = hinges.size() % 3 == 0;
      hinges.push_back({hinge.vertices,
                        {-0.1F, 0.3F, 0.2F, 0.3F, 0.2F, 0.05F},
                        hinges.size() % 2 == 0 ? 0.0F : 2e-3F,
                        is_flat ? 0.0F : 1e-5F,
                        is_flat ? 0.0F : 0.1F,
                        is_flat ? 0.0F : 1e-9F});
    }
  }

  [[nodiscard]] VertexBlocks build() const {
    return {moves, tets, springs, hinges, {.repair = true}};
  }
};

const Edge& vertices_of(const Edge& edge) {
  return edge;
}
template <class Element>
const auto& vertices_of(const Element& element) {
  return element.vertices;
}

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

// None of an element's vertices has the colour of another.
template <class Element>
void check_colors(const VertexBlocks& blocks, const std::vector<Element>& elements) {
  std::vector<Index> color_of(static_cast<std::size_t>(blocks.vertex_count()), kInvalidIndex);
  for (Index color = 0; color < blocks.color_count(); ++color) {
    const auto [first, count] = blocks.blocks(color);
    for (Index b = first; b < first + count; ++b) {
      const VertexBlock& block = blocks.rows().blocks[b];
      for (Index lane = 0; lane < block.lane_count; ++lane) {
        color_of[place_at(block.corners[lane])] = color;
      }
    }
  }
  for (const Element& element : elements) {
    std::vector<Index> colors;
    for (const Index v : vertices_of(element)) {
      if (color_of[v] != kInvalidIndex) {
        colors.push_back(color_of[v]);
      }
    }
    std::ranges::sort(colors);
    CHECK(std::ranges::adjacent_find(colors) == colors.end());
  }
}

struct Padding {
  Index volumes = 0, hinges = 0;  // rows of a lane
};

// What fills a block up reads its own vertices alone; idle lanes repeat the last.
Padding check_padding(const VertexBlocks& blocks) {
  const VertexRows rows = blocks.rows();
  Padding padding;
  for (Index b = 0; b < blocks.block_count(); ++b) {
    const VertexBlock& block = rows.blocks[b];
    for (Index i = 0; i < block.volumes.count; ++i) {
      const VolumeRow& row = rows.volumes[block.volumes.first + i];
      for (Index lane = 0; lane < block.lane_count; ++lane) {
        if (row.stiffness[lane] == 0) {
          ++padding.volumes;
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
        if (row.stiffness[lane] == 0 && row.moment[lane] == 0) {
          ++padding.hinges;
          CHECK(row.neighbors[0][lane] == block.corners[lane]);
          CHECK(row.neighbors[2][lane] == block.corners[lane]);
        }
      }
      for (Index lane = block.lane_count; lane < kBlockLanes; ++lane) {
        CHECK(row.neighbors[1][lane] == row.neighbors[1][block.lane_count - 1]);
        CHECK(row.is_opposite[lane] == row.is_opposite[block.lane_count - 1]);
        CHECK(row.rest[lane] == row.rest[block.lane_count - 1]);
        CHECK(row.moment[lane] == row.moment[block.lane_count - 1]);
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
  return padding;
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

  check_colors(blocks, sample.edges);
  check_colors(blocks, sample.hinges);
  CHECK(blocks.color_count() <= 11);
}

// Would catch two threads at one vertex: what fills a block up reads its own vertices alone.
TEST_CASE("vertex blocks: padding names the vertex itself, and idle lanes repeat the last",
          "[property]") {
  const Padding padding = check_padding(Sample().build());
  CHECK(padding.volumes > 0);
  CHECK(padding.hinges > 0);
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

// A sample whose vertices, and what joins them, come in several edits.
class Growth {
 public:
  explicit Growth(bool at_once) : at_once_(at_once) {
    count_ = vertex_count(0);
    blocks = VertexBlocks({sample_.moves.begin(), sample_.moves.begin() + count_},
                          take(sample_.tets, tets_), take(sample_.springs, springs_),
                          take(sample_.hinges, hinges_), {.repair = true}, kUsualUnit, at_once);
  }

  static constexpr int kEdits = 6;

  // Some tetrahedra go, others get their last corner from where a sliver would take it.
  void grow(int edit) {
    blocks.begin_edit();
    before_ = count_;
    count_ = vertex_count(edit);
    for (std::size_t t = static_cast<std::size_t>(edit); t < tets_.size(); t += 9) {
      tets_[t] = {.vertices = tets_[t].vertices};
      blocks.remove_tet(static_cast<Index>(t));
    }
    blocks.add_vertices(count_);
    for (Index v = before_; v < count_; ++v) {
      if (sample_.moves[v]) {
        blocks.set_free(v);
      }
    }
    for (const VertexTet& tet : take(sample_.tets, tets_)) {
      blocks.add_tet(tet);
    }
    for (const VertexSpring& spring : take(sample_.springs, springs_)) {
      blocks.add_spring(spring);
    }
    for (const VertexHinge& hinge : take(sample_.hinges, hinges_)) {
      blocks.add_hinge(hinge);
    }
    for (std::size_t t = static_cast<std::size_t>(edit) + 4; t < tets_.size(); t += 31) {
      const Index other = (tets_[t].vertices[3] + 11) % count_;
      if (std::ranges::find(tets_[t].vertices, other) == tets_[t].vertices.end()) {
        tets_[t].vertices[3] = other;
        blocks.set_tet(static_cast<Index>(t), tets_[t]);
      }
    }
    blocks.refresh();
  }

  void check() const {
    const std::vector<Particle> particles{sample_.particles.begin(),
                                          sample_.particles.begin() + count_};
    const VertexBlocks made({sample_.moves.begin(), sample_.moves.begin() + count_}, tets_,
                            springs_, hinges_, {.repair = true}, kUsualUnit, at_once_);
    check_equal(blocks, made, particles);
    check_padding(blocks);
    if (!at_once_) {
      std::vector<VertexTet> live = tets_;
      std::erase_if(live, [](const VertexTet& tet) { return !(tet.stiffness > 0); });
      check_colors(blocks, live);
      check_colors(blocks, springs_);
      check_colors(blocks, hinges_);
      CHECK(blocks.color_count() <= made.color_count() + 3);
    }
    for (Index v = 0; v < count_; ++v) {
      CHECK(std::ranges::is_sorted(blocks.tets_at(v)));
    }
  }

  VertexBlocks blocks;

 private:
  [[nodiscard]] Index vertex_count(int edit) const {
    return sample_.mesh.vertex_count() * (edit + 3) / (kEdits + 3);
  }

  // Elements with a vertex that has just come; adds them to the known.
  template <class Element>
  std::vector<Element> take(const std::vector<Element>& all, std::vector<Element>& known) const {
    std::vector<Element> found;
    for (const Element& element : all) {
      const Index last = std::ranges::max(element.vertices);
      if (last < count_ && last >= before_) {
        found.push_back(element);
      }
    }
    known.insert(known.end(), found.begin(), found.end());
    return found;
  }
  Sample sample_;
  bool at_once_;
  Index count_ = 0, before_ = 0;
  std::vector<VertexTet> tets_;
  std::vector<VertexSpring> springs_;
  std::vector<VertexHinge> hinges_;
};

// Would catch a vertex in two lanes or none, a colour that a new neighbour has, rows of one that
// left its lane, lists that an undo leaves behind.
TEST_CASE("vertex blocks: what edits bring is laid out as if it had been there", "[property]") {
  Growth growth(GENERATE(false, true));
  growth.check();
  for (int edit = 1; edit <= Growth::kEdits; ++edit) {
    const Growth before = growth;
    growth.grow(edit);
    growth.check();
    Growth undone = growth;
    undone.blocks.undo();
    undone.blocks.refresh();
    Growth back = before;
    back.blocks = undone.blocks;
    back.check();
    CHECK(back.blocks.color_count() == before.blocks.color_count());
    back.grow(edit);
    back.check();
  }
}

// Would catch one new colour for all that find none, and one that stays open without vertices.
TEST_CASE("vertex blocks: vertices that are all joined get as many colours, and undo closes them",
          "[unit]") {
  constexpr Index kCount = 9, kBefore = 3;
  std::vector<bool> moves(kCount, false);
  std::fill_n(moves.begin(), kBefore, true);
  VertexBlocks blocks(moves, {}, {{{0, 1}, 1, 1, 0}, {{1, 2}, 1, 1, 0}}, {}, {});
  REQUIRE(blocks.color_count() == 2);
  for (const bool is_again : {false, true}) {
    INFO(is_again);
    blocks.begin_edit();
    for (Index v = kBefore; v < kCount; ++v) {
      blocks.set_free(v);
      for (Index other = 0; other < v; ++other) {
        blocks.add_spring({{other, v}, 1, 1, 0});
      }
    }
    blocks.refresh();
    CHECK(blocks.color_count() == kCount - 1);
    std::vector<bool> is_taken(kCount, false);
    for (Index v = kBefore; v < kCount; ++v) {
      CHECK_FALSE(is_taken[blocks.color_of(v)]);
      is_taken[blocks.color_of(v)] = true;
      for (Index other = 0; other < kBefore; ++other) {
        CHECK(blocks.color_of(v) != blocks.color_of(other));
      }
    }
    blocks.undo();
    blocks.refresh();
    CHECK(blocks.color_count() == 2);
  }
}

// Would catch one who keeps a copy of the lanes and goes on with that of a vertex which has none.
TEST_CASE("vertex blocks: what an undo leaves without a block is told", "[unit]") {
  const std::vector<VertexSpring> springs{{{0, 1}, 1, 1, 0}};
  VertexBlocks blocks({true, true, false}, {}, springs, {}, {});
  blocks.begin_edit();
  blocks.set_free(2);
  blocks.add_spring({{1, 2}, 1, 1, 0});
  blocks.refresh();
  REQUIRE(blocks.place_of(2).block != kInvalidIndex);
  CHECK(std::ranges::count(blocks.refreshed(), 2) > 0);

  blocks.undo();
  blocks.refresh();

  CHECK(blocks.place_of(2).block == kInvalidIndex);
  CHECK(std::ranges::count(blocks.refreshed(), 2) > 0);
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

}  // namespace pbdsurg
