// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/world/surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

#include "pbdsurg/contact/contact_probe.h"
#include "pbdsurg/surgery/cut.h"
#include "pbdsurg/views/live_boundary.h"

#include "tests/support/catch.h"
#include "tests/support/inspect.h"
#include "tests/world/slab_world.h"

namespace pbdsurg {
namespace {

using testing::kDt;
using testing::SlabWorld;

Index count_live_surfaces(const Tissue& tissue, Index body) {
  Index count = 0;
  testing::inspect(tissue).followers->for_each([&](const FollowerList::Entry& entry) {
    const auto* surface = dynamic_cast<const LiveSurface*>(entry.follower);
    count += surface != nullptr && surface->body() == body ? 1 : 0;
  });
  return count;
}

// Against what is found afresh.
void check_surface(World& world, BodyId body, CauteryId burner) {
  const Surface& surface = world.surface(body);
  const Solver& solver = world.solver();
  const Tissue& tissue = solver.tissue();
  const Index own = world.body_in_tissue(body);
  const std::vector<Index> ids = tissue.vertices_of(own);
  REQUIRE(std::ranges::equal(surface.vertices(), ids));
  const std::vector<Eigen::Vector3f> positions = solver.positions();
  for (std::size_t i = 0; i < ids.size(); ++i) {
    REQUIRE(surface.positions()[i] == positions[ids[i]]);
    REQUIRE(surface.rest_positions()[i] == tissue.rest_positions()[ids[i]].cast<float>());
  }

  std::vector<Triangle> expected, shown;
  for (const BoundaryTriangle& triangle : find_live_boundary(tissue, own)) {
    expected.push_back(triangle.vertices);
  }
  std::vector<Eigen::Vector3f> normals(ids.size(), Eigen::Vector3f::Zero());
  for (const auto& [a, b, c] : surface.triangles()) {
    if (a == b) {
      REQUIRE(b == c);
      continue;
    }
    shown.push_back({ids[a], ids[b], ids[c]});
    for (const Index v : {a, b, c}) {
      normals[v] += (surface.positions()[b] - surface.positions()[a])
                        .cross(surface.positions()[c] - surface.positions()[a]);
    }
  }
  std::ranges::sort(expected);
  std::ranges::sort(shown);
  REQUIRE(shown == expected);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    REQUIRE((surface.normals()[i] - normals[i].normalized()).norm() < 1e-5F);
    REQUIRE((normals[i].isZero(0) || std::abs(surface.normals()[i].norm() - 1) < 1e-5F));
  }

  const HeatField& field = world.cautery(burner).field();
  SurfaceMap map;
  map.update(LiveSurface(tissue, own),
             {field.peak_temperatures(), field.survival(), field.water(), field.charred()});
  REQUIRE(surface.temperatures().size() == ids.size());
  REQUIRE(surface.peak_temperatures().size() == ids.size());
  for (const Triangle& triangle : surface.triangles()) {
    for (const Index v : triangle) {
      if (triangle[0] != triangle[1]) {
        REQUIRE(surface.peak_temperatures()[v] == map.temperatures()[ids[v]]);
        REQUIRE(surface.temperatures()[v] == static_cast<float>(field.temperatures()[ids[v]]));
        REQUIRE(surface.marks()[v] == map.marks()[ids[v]]);
      }
    }
  }
}

}  // namespace

TEST_CASE("surface: at rest, normals of a box point outwards", "[unit]") {
  World world;
  const BodyId body = world.add_body("box", testing::slab(0), tissues::liver());
  const Surface& surface = world.surface(body);
  const Eigen::Vector3f middle(6e-3F, 6e-3F, 2e-3F);
  Index on = 0;
  for (std::size_t i = 0; i < surface.vertices().size(); ++i) {
    const Eigen::Vector3f& normal = surface.normals()[i];
    on += normal.isZero(0) ? 0 : 1;
    CHECK((normal.isZero(0) || normal.dot(surface.positions()[i] - middle) > 0));
  }
  CHECK(on == 147 - 25);  // all but the inner ones
  CHECK(surface.temperatures().empty());
  CHECK(surface.marks().empty());
}

// Would catch triangles, positions, normals, temperatures or marks that an event leaves behind; and
// a contact probe that sees another surface by itself.
TEST_CASE("surface: is that of the tissue after burns, edits, undo, cuts and compaction",
          "[property]") {
  SlabWorld slabs;
  World& world = slabs.world;
  const Surface &lower = world.surface(slabs.lower), &upper = world.surface(slabs.upper);
  slabs.burn();
  Index removed = 0;
  const std::array<Index, 2> bodies{0, 1};
  const std::array<ToolPoint, 2> points{{{{0, 0, 0}, 1e-3F}, {{0, 0, 4e-3F}, 1e-3F}}};
  ContactProbe reading(world.solver(), bodies, points), given(world.solver(), bodies, points);
  std::uint64_t checks = 0;
  std::uint32_t planes = 0;
  const auto check = [&] {
    check_surface(world, slabs.lower, slabs.burner);
    check_surface(world, slabs.upper, slabs.burner);
    const std::array<TouchedSurface, 2> surfaces{
        {{lower.triangles(), lower.positions()}, {upper.triangles(), upper.positions()}}};
    const double time = 1e-3 * static_cast<double>(++checks);
    ContactPatch read, touched;
    reading.collect_patch(world.solver(), slabs.hook, GraspState::open, checks, time, read);
    given.collect_patch(surfaces, world.solver(), slabs.hook, GraspState::open, checks, time,
                        touched);
    REQUIRE(read.triangles.size() == touched.triangles.size());
    for (std::size_t i = 0; i < read.triangles.size(); ++i) {
      REQUIRE(read.triangles[i].corners == touched.triangles[i].corners);
    }
    planes += make_contact_packet(read).plane_count;
  };
  check();
  for (int round = 0; round < 36; ++round) {
    if (round % 6 == 2) {
      const float x = 1e-3F + 2e-3F * static_cast<float>(round / 6);
      world.edit(plan_cut(world.solver(), testing::cut_at(x, -1e-3F, 2e-3F)).edit);
    }
    if (round % 6 == 4) {
      world.edit({.remove_tets = {world.tissue().tets_at(world.tissue().body(0).first_vertex)[0]}});
    }
    removed += world.step(kDt).removed_tets;
    check();
    if (round % 6 == 3) {
      world.tissue().apply({.remove_tets = {world.tissue().tets_of(1).back()}});
      world.undo();
      check();
    }
    if (round % 12 == 5) {
      world.compact();
      check();
    }
  }
  CHECK(removed > 10);
  CHECK(planes > checks);
  CHECK(std::ranges::any_of(lower.marks(), [](BurnBytes marks) { return marks.white > 0; }));
  CHECK(std::ranges::max(lower.temperatures()) > 60);
}

// Would catch a renderer that copies too little.
TEST_CASE("surface: ranges of changes keep a copy of the triangles", "[unit]") {
  SlabWorld slabs;
  const Surface& surface = slabs.world.surface(slabs.lower);
  std::vector<Triangle> copy;
  std::vector<SlotRange> ranges;
  std::uint64_t seen = 0;
  slabs.burn();
  for (int round = 0; round < 20; ++round) {
    slabs.world.step(kDt);
    surface.collect_changes(seen, ranges);
    seen = surface.version();
    copy.resize(surface.triangles().size());
    for (const auto [first, end] : ranges) {
      std::copy(surface.triangles().begin() + first, surface.triangles().begin() + end,
                copy.begin() + first);
    }
    REQUIRE(std::ranges::equal(copy, surface.triangles()));
  }
}

// Would catch marks that change unannounced, or announcements of all vertices at each step.
TEST_CASE("surface: ranges of changes keep a copy of the marks", "[unit]") {
  SlabWorld slabs;
  World& world = slabs.world;
  const Surface& surface = world.surface(slabs.upper);
  slabs.burn();
  std::vector<BurnBytes> copy;
  std::vector<float> peaks;
  std::uint64_t seen = 0;
  std::vector<SlotRange> ranges;
  std::size_t fewest = std::numeric_limits<std::size_t>::max(), copied = 0;
  for (int step = 0; step < 40; ++step) {
    world.step(kDt);
    if (step == 30) {
      world.energise(slabs.burner, off_settings());
    }
    surface.collect_mark_changes(seen, ranges);
    seen = surface.marks_version();
    copy.resize(surface.marks().size());
    peaks.resize(surface.marks().size());
    std::size_t count = 0;
    for (const SlotRange& range : ranges) {
      for (Index i = range.first; i < range.end; ++i) {
        copy[i] = surface.marks()[i];
        peaks[i] = surface.peak_temperatures()[i];
        ++count;
      }
    }
    fewest = std::min(fewest, count);
    copied = std::max(copied, count);
    REQUIRE(std::ranges::equal(copy, surface.marks()));
    REQUIRE(std::ranges::equal(peaks, surface.peak_temperatures()));
  }
  CHECK(copied > 0);
  CHECK(fewest < surface.marks().size() / 2);
}

// Would catch work done twice in every edit.
TEST_CASE("surface: that of a body is one, shared with the cautery", "[unit]") {
  SlabWorld slabs;
  World& world = slabs.world;
  CHECK(count_live_surfaces(world.tissue(), 0) == 1);  // the cautery's
  const Surface& first = world.surface(slabs.lower);
  CHECK(&world.surface(slabs.lower) == &first);
  CHECK(count_live_surfaces(world.tissue(), 0) == 1);
  CHECK(count_live_surfaces(world.tissue(), 1) == 1);

  World other;
  const BodyId body = other.add_body("box", testing::slab(0), tissues::liver());
  const Surface& surface = other.surface(body);  // the surface first
  other.add_cautery(other.add_tool({}), {body});
  CHECK(count_live_surfaces(other.tissue(), 0) == 1);
  CHECK(surface.temperatures().size() == surface.vertices().size());
  CHECK(surface.temperatures()[0] == 37);
}

// Would catch a surface that reads beyond what is left of its body.
TEST_CASE("surface: of a body that has gone there is nothing", "[unit]") {
  SlabWorld slabs;
  World& world = slabs.world;
  const Surface& surface = world.surface(slabs.upper);
  world.remove_body(slabs.upper);
  CHECK(world.step(kDt).ok());
  const auto is_empty = [](const Triangle& t) { return t[0] == t[1] && t[1] == t[2]; };
  CHECK(std::ranges::all_of(surface.triangles(), is_empty));
  world.compact();
  CHECK(surface.vertices().empty());
  CHECK(surface.positions().empty());
  CHECK(surface.normals().empty());
  CHECK(std::ranges::all_of(surface.triangles(), is_empty));
  CHECK(world.step(kDt).ok());
  world.compact();
  CHECK(surface.normals().empty());
}

}  // namespace pbdsurg
