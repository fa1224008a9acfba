// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/heat/surface_map.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/heat/surface_texture.h"
#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/tissue/thermal_properties.h"

#include "tests/support/catch.h"
#include "tests/support/cuts.h"
#include "tests/support/meshes.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;

// A field that changes at random, as a heat field would.
struct Fields {
  std::vector<double> temperatures, survival, water, charred;

  [[nodiscard]] SurfaceFields view() const { return {temperatures, survival, water, charred}; }

  void resize(Index vertex_count) {
    const auto size = static_cast<std::size_t>(vertex_count);
    temperatures.resize(size, kBodyTemperature);
    survival.resize(size, 1);
    water.resize(size, 1);
    charred.resize(size, 0);
  }

  void burn(Index vertex, std::uint64_t seed) {
    temperatures[vertex] = 37 + 300 * random_unit(seed, vertex, 0);
    survival[vertex] *= random_unit(seed, vertex, 1);
    water[vertex] *= random_unit(seed, vertex, 2);
    charred[vertex] = 1 - (1 - charred[vertex]) * random_unit(seed, vertex, 3);
  }
};

struct Setup {
  TetMesh mesh = testing::make_box({5, 5, 5}, 1e-3, 0.1);
  Solver solver = make_solver(mesh);
  LiveSurface surface{solver.tissue(), 1};
  Fields fields;

  Setup() { fields.resize(solver.vertex_count()); }

  void compact() {
    Compaction compaction(solver);
    compaction.build();
    const Renumbering ids = compaction.finish(solver);
    const Fields before = std::exchange(fields, {});
    fields.resize(solver.vertex_count());
    for (std::size_t v = 0; v < ids.vertices.size(); ++v) {
      if (const Index id = ids.vertices[v]; id != kInvalidIndex) {
        fields.temperatures[id] = before.temperatures[v];
        fields.survival[id] = before.survival[v];
        fields.water[id] = before.water[v];
        fields.charred[id] = before.charred[v];
      }
    }
  }

  static Solver make_solver(const TetMesh& mesh) {
    Scene scene;
    scene.add_body("other", testing::make_box({1, 1, 1}, 1e-3));
    scene.add_body("block", mesh);
    return Solver(scene, {.executor = executor::serial()});
  }

  [[nodiscard]] std::vector<Index> surface_vertices() const {
    std::vector<Index> result;
    for (const Triangle& triangle : surface.triangles()) {
      if (triangle != LiveSurface::kEmptyTriangle) {
        result.insert(result.end(), triangle.begin(), triangle.end());
      }
    }
    std::sort(result.begin(), result.end());
    result.erase(std::unique(result.begin(), result.end()), result.end());
    return result;
  }
};

// Whether a map and a texture that followed equal ones made afresh, wherever they are of use.
void check_afresh(const Setup& setup, const SurfaceMap& map, const SurfaceTexture& texture) {
  SurfaceMap fresh;
  SurfaceTexture fresh_texture(texture.texels());
  fresh.update(setup.surface, setup.fields.view());
  fresh_texture.update(setup.surface, fresh);
  Index wrong = 0;
  for (const Index v : setup.surface_vertices()) {
    wrong += map.temperatures()[v] != fresh.temperatures()[v] || map.marks()[v] != fresh.marks()[v];
  }
  REQUIRE(wrong == 0);
  const auto tile = static_cast<std::size_t>(texture.texels() * texture.texels());
  for (std::size_t i = 0; i < texture.marks().size(); ++i) {
    if (setup.surface.triangles()[i / tile] != LiveSurface::kEmptyTriangle) {
      wrong += texture.temperatures()[i] != fresh_texture.temperatures()[i] ||
               texture.marks()[i] != fresh_texture.marks()[i];
    }
  }
  REQUIRE(wrong == 0);
}

// A renderer's buffers, which see nothing but ranges.
template <class T>
void copy_ranges(std::span<const T> from, const std::vector<SlotRange>& ranges, Index each,
                 std::vector<T>& to) {
  to.resize(from.size());
  for (const auto [first, end] : ranges) {
    std::copy(from.begin() + first * each, from.begin() + end * each, to.begin() + first * each);
  }
}

struct Mirror {
  std::uint64_t map_version = 0, texture_version = 0;
  std::vector<float> temperatures{};
  std::vector<BurnBytes> texels{};
  std::vector<SlotRange> ranges{};

  void update(const SurfaceMap& map, const SurfaceTexture& texture) {
    map.collect_changes(map_version, ranges);
    map_version = map.version();
    copy_ranges(map.temperatures(), ranges, 1, temperatures);
    texture.collect_changes(texture_version, ranges);
    texture_version = texture.version();
    copy_ranges(texture.marks(), ranges, texture.texels() * texture.texels(), texels);
  }

  void check(const Setup& setup, const SurfaceMap& map, const SurfaceTexture& texture) const {
    Index wrong = 0;
    for (const Index v : setup.surface_vertices()) {
      wrong += temperatures[v] != map.temperatures()[v];
    }
    const auto tile = static_cast<std::size_t>(texture.texels() * texture.texels());
    for (std::size_t i = 0; i < texels.size(); ++i) {
      wrong += texels[i] != texture.marks()[i] &&
               setup.surface.triangles()[i / tile] != LiveSurface::kEmptyTriangle;
    }
    REQUIRE(wrong == 0);
  }
};

// The value at a point of a tetrahedron of the field there.
double interpolate(const Setup& setup, Index tet, const Eigen::Vector3d& point,
                   const std::vector<double>& field) {
  Eigen::Matrix4d corners;
  Eigen::Vector4d values;
  for (int k = 0; k < 4; ++k) {
    const Index v = setup.solver.tissue().tets()[tet][k];
    corners.col(k) << setup.solver.positions()[v].cast<double>(), 1;
    values[k] = field[v];
  }
  return values.dot(corners.inverse() * Eigen::Vector4d(point.x(), point.y(), point.z(), 1));
}

}  // namespace

// Would catch texels that lie elsewhere than they say, channels that are swapped, and rounding
// beyond what it says.
TEST_CASE("surface map: texels hold what the field in the tetrahedron has there", "[validation]") {
  Setup setup;
  for (Index v = 0; v < setup.solver.vertex_count(); ++v) {
    setup.fields.burn(v, 3);
  }
  SurfaceMap map;
  const Index n = GENERATE(2, 5, 8);
  SurfaceTexture texture(n);
  map.update(setup.surface, setup.fields.view());
  texture.update(setup.surface, map);

  constexpr double kByte = 1.001 / 255;  // rounded twice
  double worst_temperature = 0, worst_mark = 0;
  for (Index slot = 0; slot < setup.surface.slot_count(); ++slot) {
    const Triangle& triangle = setup.surface.triangles()[slot];
    const Index tet = setup.surface.origins()[slot].tet;
    const auto corner = [&](int k) -> Eigen::Vector3d {
      return setup.solver.positions()[triangle[k]].cast<double>();
    };
    for (Index j = 0; j < n; ++j) {
      for (Index i = 0; i + j < n; ++i) {
        const double u = double(i) / (n - 1), v = double(j) / (n - 1);
        const Eigen::Vector3d point =
            corner(0) + u * (corner(1) - corner(0)) + v * (corner(2) - corner(0));
        const Index texel = n * n * slot + i + n * j;
        const auto at = [&](const std::vector<double>& field) {
          return interpolate(setup, tet, point, field);
        };
        const BurnBytes marks = texture.marks()[texel];
        worst_temperature = std::max(worst_temperature, std::abs(texture.temperatures()[texel] -
                                                                 at(setup.fields.temperatures)));
        worst_mark =
            std::max({worst_mark, std::abs(marks.white / 255.0 - 1 + at(setup.fields.survival)),
                      std::abs(marks.brown / 255.0 - 1 + at(setup.fields.water)),
                      std::abs(marks.charred / 255.0 - at(setup.fields.charred))});
      }
    }
  }
  CHECK(worst_temperature < 0.51 * SurfaceMap::kTemperatureStep);
  CHECK(worst_mark < kByte);
}

// Would catch a vertex that an edit bares and nobody samples, one that is sampled once and then
// forgotten, what an undo leaves behind, ids used again, those that a compaction changed, and a
// reader that is not told.
TEST_CASE("surface map: it equals one made afresh after any heat, edits and undos", "[property]") {
  const std::uint64_t seed = GENERATE(range(1, 13));
  Setup setup;
  SurfaceMap map;
  SurfaceTexture texture(3);
  Mirror eager, lazy;
  for (std::uint64_t i = 0; i < 40; ++i) {
    TopologyEdit edit;
    if (i % 3 == 0) {
      const auto vertex =
          static_cast<Index>(random_unit(seed, i, 1) * setup.mesh.vertex_count()) + 8;
      edit = testing::part_vertex(setup.solver, vertex, seed + i);
    } else if (i % 3 == 1) {
      const Index edge = static_cast<Index>(
          random_unit(seed, i, 2) * static_cast<double>(setup.solver.tissue().edges().size()));
      edit = testing::split_edge(setup.solver, edge, 0.4F);
      if (edit.new_tets.empty()) {
        edit = {};
      }
    } else {
      for (Index t = 0; t < static_cast<Index>(setup.solver.tissue().tets().size()); ++t) {
        if (setup.solver.tissue().is_tet_alive(t) && random_unit(seed, i, t) < 0.05) {
          edit.remove_tets.push_back(t);
        }
      }
    }
    const Fields before = setup.fields;
    setup.solver.tissue().apply(edit);
    setup.fields.resize(setup.solver.vertex_count());
    for (Index v = static_cast<Index>(before.water.size()); v < setup.solver.vertex_count(); ++v) {
      setup.fields.burn(v, 7 * seed + i);  // tells a vertex from another that had its id
    }
    if (random_bits(seed, i, 4) % 2 == 0) {
      if (random_bits(seed, i, 5) % 2 == 0) {
        map.update(setup.surface, setup.fields.view(), {});
        texture.update(setup.surface, map);
      }
      setup.solver.tissue().undo();
      setup.fields = before;
    }
    std::vector<Index> changed;
    for (int k = 0; k < 8; ++k) {
      changed.push_back(static_cast<Index>(random_unit(seed, i, 10 + k) *
                                           static_cast<double>(setup.fields.water.size())));
      setup.fields.burn(changed.back(), seed + 100 * i);
    }
    if (i % 10 == 9) {
      setup.compact();
      changed.clear();
    }
    map.update(setup.surface, setup.fields.view(), changed);
    texture.update(setup.surface, map);
    check_afresh(setup, map, texture);
    eager.update(map, texture);
    eager.check(setup, map, texture);
    if (i % 4 == 3) {
      lazy.update(map, texture);
      lazy.check(setup, map, texture);
    }
  }
}

// Would catch a map that draws everything in every frame: one hot vertex changes itself and the
// tiles around it, and nothing is sent that looks the same.
TEST_CASE("surface map: texels keep their bits where nothing changed", "[unit]") {
  Setup setup;
  SurfaceMap map;
  SurfaceTexture texture;
  map.update(setup.surface, setup.fields.view());
  texture.update(setup.surface, map);
  const std::vector<float> before(texture.temperatures().begin(), texture.temperatures().end());
  std::uint64_t map_version = map.version(), texture_version = texture.version();

  const Index hot = setup.surface.triangles()[10][0];
  setup.fields.temperatures[hot] = 90;
  std::vector<Index> everywhere;
  for (Index v = 0; v < setup.solver.vertex_count(); ++v) {
    everywhere.push_back(v);
  }
  map.update(setup.surface, setup.fields.view(), everywhere);
  texture.update(setup.surface, map);

  CHECK(map.version() - map_version == 1);
  std::uint64_t touched = 0;
  const auto tile = static_cast<std::size_t>(texture.texels() * texture.texels());
  for (Index slot = 0; slot < setup.surface.slot_count(); ++slot) {
    const Triangle& triangle = setup.surface.triangles()[slot];
    const bool is_touched = std::find(triangle.begin(), triangle.end(), hot) != triangle.end();
    touched += is_touched ? 1 : 0;
    const auto first = static_cast<std::ptrdiff_t>(tile) * slot;
    CHECK(std::equal(before.begin() + first,
                     before.begin() + first + static_cast<std::ptrdiff_t>(tile),
                     texture.temperatures().begin() + first) != is_touched);
  }
  CHECK(texture.version() - texture_version == touched);

  // what cannot be seen is not sent
  map_version = map.version();
  texture_version = texture.version();
  setup.fields.temperatures[hot] += 0.3 * SurfaceMap::kTemperatureStep;
  setup.fields.survival[hot] -= 1e-4;
  map.update(setup.surface, setup.fields.view(), everywhere);
  texture.update(setup.surface, map);
  CHECK(map.version() == map_version);
  CHECK(texture.version() == texture_version);
}

TEST_CASE("surface map: bad input is refused, and nothing has changed", "[unit]") {
  Setup setup;
  SurfaceMap map;
  SurfaceTexture texture;
  CHECK_THROWS_AS(SurfaceTexture(1), InvalidArgument);
  CHECK_THROWS_AS(SurfaceTexture(65), InvalidArgument);
  CHECK_THROWS_WITH(texture.update(setup.surface, map), ContainsSubstring("not in the map"));
  const auto count = static_cast<Index>(setup.fields.water.size());
  CHECK_THROWS_WITH(map.update(setup.surface, setup.fields.view(), std::vector<Index>{count}),
                    ContainsSubstring("vertex " + std::to_string(count)));
  Fields fewer = setup.fields;
  fewer.charred.pop_back();
  CHECK_THROWS_WITH(map.update(setup.surface, fewer.view()), ContainsSubstring("beside"));
  fewer.resize(0);
  fewer.resize(20);
  CHECK_THROWS_WITH(map.update(setup.surface, fewer.view()), ContainsSubstring("20 vertices"));
  CHECK(map.temperatures().empty());
  CHECK(texture.marks().empty());
}

}  // namespace pbdsurg
