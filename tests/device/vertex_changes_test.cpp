// SPDX-License-Identifier: Apache-2.0
// Rows of the vertex-block method follow edits on the host: what is here needs no device.
#include "lib/device/vertex_changes.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <span>
#include <vector>

#include "pbdsurg/tissue/tissue.h"

#include "lib/device/stage_plan.h"
#include "lib/solver/host/lane_access.h"
#include "lib/solver/methods/vertex_kernel.h"
#include "lib/solver/methods/vertex_method.h"
#include "lib/solver/methods/vertex_moves.h"
#include "tests/support/catch.h"
#include "tests/support/eventful_program.h"
#include "tests/support/fake_device.h"
#include "tests/support/inspect.h"
#include "tests/support/sheet_meshes.h"
#include "tests/support/small_steps.h"

namespace pbdsurg::cuda {
namespace {

using pbdsurg::testing::inspect;

constexpr Substep<float> kSubstep{1e3F, 1e6F};

/// Rows as a device holds them.
struct HostRows {
  explicit HostRows(const VertexBlocks& host) {
    const VertexBlocks::Arrays arrays = host.arrays();
    blocks.assign(arrays.blocks.begin(), arrays.blocks.end());
    pulls.assign(arrays.pulls.begin(), arrays.pulls.end());
    springs.assign(arrays.springs.begin(), arrays.springs.end());
    volumes.assign(arrays.volumes.begin(), arrays.volumes.end());
    damped_springs.assign(arrays.damped_springs.begin(), arrays.damped_springs.end());
    damped_volumes.assign(arrays.damped_volumes.begin(), arrays.damped_volumes.end());
    hinges.assign(arrays.hinges.begin(), arrays.hinges.end());
    triangles.assign(arrays.triangles.begin(), arrays.triangles.end());
    fibres.assign(arrays.fibres.begin(), arrays.fibres.end());
    damped_triangles.assign(arrays.damped_triangles.begin(), arrays.damped_triangles.end());
  }

  /// As the device writes words: but those of arrays that are not rows.
  void write(std::span<const WordChange> words) {
    for (const WordChange& change : words) {
      if (change.array == DeviceArray::lane_of_place) {
        continue;
      }
      const std::span<std::byte> bytes = bytes_of(change.array);
      const std::size_t first = sizeof change.value * static_cast<std::size_t>(change.word);
      REQUIRE(first + sizeof change.value <= bytes.size());
      std::memcpy(bytes.data() + first, &change.value, sizeof change.value);
    }
  }

  /// Moves all vertices of a stage, the last first, as if no tool were there.
  void solve(const Stage& stage, std::vector<FixedPoint>& points,
             std::vector<Particle>& displacements, const std::vector<Particle>& flights,
             float relaxation) {
    const VertexRows rows{blocks.data(), pulls.data(),     springs.data(), volumes.data(),
                          hinges.data(), triangles.data(), fibres.data()};
    for (Index b = stage.first + stage.count; b-- > stage.first;) {
      for (Index lane = blocks[b].lane_count; lane-- > 0;) {
        const ParticleOffset corner = blocks[b].corners[lane];
        Particle& p = at(displacements.data(), corner);
        if (!(p.w > 0)) {
          continue;
        }
        const Vec3<float> u = load(p);
        VertexEnergy<float> start;
        start.add_pull(kSubstep.inverse_dt_squared / p.w, load(at(flights.data(), corner)) - u);
        const auto alone = [&](const VertexEnergy<float>& energy) {
          return relaxation * VertexFactor<float>(energy).solve(energy.force);
        };
        FixedPoint& point = at(points.data(), corner);
        const LaneAccess access{points.data(), point, lane};
        const Vec3<float> moved = u + move_vertex(rows, blocks[b], access, start, alone);
        store(p, moved);
        point = moved_point(point, u, moved);
      }
    }
  }

  void prepare(const SolverData& data) {
    const DampedRows rows{blocks.data(),         springs.data(),         volumes.data(),
                          hinges.data(),         triangles.data(),       damped_springs.data(),
                          damped_volumes.data(), damped_triangles.data()};
    for (const VertexBlock& block : blocks) {
      for (Index lane = 0; block.is_damped && lane < block.lane_count; ++lane) {
        const StartAccess access{data.particles.data(), data.carries.data(),
                                 load(at(data.particles.data(), block.corners[lane])), lane};
        add_damping(rows, block, access, kSubstep.inverse_dt);
      }
    }
  }

  std::vector<VertexBlock> blocks;
  std::vector<PullRow> pulls;
  std::vector<SpringRow> springs;
  std::vector<VolumeRow> volumes;
  std::vector<HingeRow> hinges;
  std::vector<TriangleRow> triangles;
  std::vector<FibreRow> fibres;
  std::vector<DampedRow> damped_springs, damped_volumes, damped_triangles;

 private:
  std::span<std::byte> bytes_of(DeviceArray array) {
    const auto bytes = [](auto& rows) { return std::as_writable_bytes(std::span(rows)); };
    switch (array) {
      case DeviceArray::vertex_blocks:
        return bytes(blocks);
      case DeviceArray::pull_rows:
        return bytes(pulls);
      case DeviceArray::spring_rows:
        return bytes(springs);
      case DeviceArray::volume_rows:
        return bytes(volumes);
      case DeviceArray::damped_spring_rows:
        return bytes(damped_springs);
      case DeviceArray::damped_volume_rows:
        return bytes(damped_volumes);
      case DeviceArray::hinge_rows:
        return bytes(hinges);
      case DeviceArray::triangle_rows:
        return bytes(triangles);
      case DeviceArray::fibre_rows:
        return bytes(fibres);
      case DeviceArray::damped_triangle_rows:
        return bytes(damped_triangles);
      case DeviceArray::distances:
      case DeviceArray::distance_damping:
      case DeviceArray::volumes:
      case DeviceArray::joints:
      case DeviceArray::neo_hookeans:
      case DeviceArray::fibres:
      case DeviceArray::membranes:
      case DeviceArray::strain_limits:
      case DeviceArray::bendings:
      case DeviceArray::stiff_links:
      case DeviceArray::tubes:
      case DeviceArray::particles:
      case DeviceArray::velocities:
      case DeviceArray::cluster:
      case DeviceArray::lane_of_place:
      case DeviceArray::stiffness_shares:
      case DeviceArray::tile_blocks:
      case DeviceArray::tile_neighbors:
      case DeviceArray::coarse_vertices:
      case DeviceArray::coarse_own_counts:
      case DeviceArray::coarse_own_places:
      case DeviceArray::coarse_member_counts:
      case DeviceArray::coarse_member_places:
      case DeviceArray::coarse_member_shares:
        break;
    }
    return {};
  }
};

bool same_bits(const std::vector<Particle>& a, const std::vector<Particle>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Particle)) == 0;
}

// One substep's sweeps of vertices from a state far from rest, by the stages and serially.
bool have_serial_bits(HostRows& rows, const StagePlan& plan, SolverData& data) {
  StepScratch& scratch = data.step_scratch;
  scratch.fit(data);
  const StepContext step{data, data, scratch};
  for (std::size_t v = 0; v < data.particles.size(); ++v) {
    const Particle& p = data.particles[v];
    const float share = v % 3 == 0 ? 0.1F : -0.03F;
    scratch.displacements[v] = {share * p.x, share * p.y, share * p.z, p.w};
    data.carries[v] = {1e-3F * p.z, -1e-3F * p.x, 2e-3F * p.y, 1};
    scratch.fixed_points[v] =
        fixed_point(load(p), load(scratch.displacements[v]), data.vertex_blocks.unit());
  }
  const std::vector<Particle> flights = scratch.flights = scratch.displacements;
  std::vector<Particle> displacements = flights;
  std::vector<FixedPoint> points = scratch.fixed_points;
  damp_rows(step, kSubstep.inverse_dt);
  rows.prepare(data);
  for (const float relaxation : {1.6F, 1.0F}) {
    const VertexState state = vertex_state(step, kSubstep, relaxation);
    for (const Phase& phase : data.plan.phases) {
      if (phase.kind == PhaseKind::vertex) {
        solve_vertices(step, state, phase.color);
      }
    }
    for (const Stage& stage : plan.stages()) {
      if (stage.kind == PhaseKind::vertex) {
        rows.solve(stage, points, displacements, flights, relaxation);
      }
    }
  }
  return same_bits(displacements, scratch.displacements) && !same_bits(displacements, flights);
}

}  // namespace

// Would catch rows that an edit changes and nobody writes, and vertices of one stage that meet.
TEST_CASE("cuda vertex blocks: a sweep by stages has the serial bits, and after edits, too",
          "[equivalence]") {
  const float damping = GENERATE(0.0F, 0.01F);
  const auto composition = GENERATE(PlanComposition::separate, PlanComposition::nested);
  Scene scene = pbdsurg::testing::make_eventful_scene(ProjectionMode::compliance, damping);
  const auto sheet = pbdsurg::testing::make_sheet({7, 6}, 4e-3, 0.2);
  scene.add_sheet("sheet", sheet.positions, sheet.triangles, {.damping = damping});
  pbdsurg::testing::give_solid_fibres(scene);
  Solver solver(scene, pbdsurg::testing::small_steps({.method = SolverMethod::vertex_block,
                                                      .executor = pbdsurg::testing::fake_device(),
                                                      .composition = composition}));
  SolverData& data = inspect(solver);
  StageRecords records;
  StagePlan plan(data, records);
  REQUIRE(plan.stages().front().kind == PhaseKind::vertex);
  REQUIRE(plan.stages().back().kind == PhaseKind::stiff_link);
  HostRows rows(data.vertex_blocks);
  REQUIRE(have_serial_bits(rows, plan, data));

  const auto follow = [&] {
    std::vector<WordChange> words;
    REQUIRE(plan.follow(data, data.changes, words));
    std::erase_if(words, [](const WordChange& change) {
      return change.array < DeviceArray::vertex_blocks;  // of constraints, for the report
    });
    CHECK(!words.empty());
    rows.write(words);
    REQUIRE(have_serial_bits(rows, plan, data));
    data.changes.clear();
  };
  data.changes.clear();
  for (Index round = 0; round < 24; ++round) {
    INFO("damping " << damping << ", round " << round);
    TopologyEdit edit = pbdsurg::testing::eventful_edit(solver, round);
    edit.remove_triangles = {3 * round, 3 * round + 1};
    if (const Index t = scene.body(2).first_tet + 4 * round;
        solver.tissue().is_tet_alive(t) && std::ranges::count(edit.remove_tets, t) == 0) {
      edit.fibres = {{t, round % 3 == 0 ? Fibre{} : Fibre{{0, 1, 0}, 50e3F}}};
    }
    if (round < 12) {
      edit.remove_links.push_back(2 * round);
      if (!solver.tissue().is_link_alive(2 * round)) {
        edit.remove_links.clear();
      }
    }
    const TissueChange result = solver.tissue().apply(edit);
    follow();
    if (round % 3 == 1) {
      solver.tissue().undo();
      follow();
    }
  }
}

// Would catch rows of whole blocks, or of all, that are written for one vertex.
TEST_CASE("cuda vertex blocks: what is written for an edit does not grow with the body", "[unit]") {
  const auto count_words = [](Index cells, bool springs) {
    const TetMesh mesh = pbdsurg::testing::make_box({cells, cells, cells}, 4e-3, 0.1);
    Scene scene;
    scene.add_body("block", mesh,
                   springs ? elastic_material(mesh, 1000, 20e3)
                           : Material{.model = ElasticModel::neo_hookean});
    Solver solver(scene,
                  pbdsurg::testing::small_steps({.method = SolverMethod::vertex_block,
                                                 .executor = pbdsurg::testing::fake_device()}));
    SolverData& data = inspect(solver);
    StageRecords records;
    StagePlan plan(data, records);
    data.changes.clear();
    solver.tissue().apply({.remove_tets = {mesh.tet_count() / 2}});
    std::vector<WordChange> words;
    REQUIRE(plan.follow(data, data.changes, words));
    return words.size();
  };
  for (const bool springs : {true, false}) {
    INFO((springs ? "springs" : "Neo-Hookean"));
    CHECK(count_words(12, springs) < 1200);  // four vertices
    CHECK(count_words(12, springs) < 2 * count_words(4, springs));
  }
}

}  // namespace pbdsurg::cuda
