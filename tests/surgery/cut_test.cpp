// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/surgery/cut.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/mesh/tetrahedralize.h"

#include "lib/surgery/cut_planner.h"
#include "tests/support/catch.h"
#include "tests/support/edit_model.h"
#include "tests/support/meshes.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using testing::ContainsSubstring;
using testing::EditModel;

constexpr double kCutEdge = 4e-3;

Scene scene_of(const TetMesh& mesh) {
  Scene scene;
  scene.add_body("body", mesh);
  return scene;
}

// The plain model, and living tissue under the same edits, of which plans are made.
class CutModel : public EditModel {
 public:
  explicit CutModel(const TetMesh& mesh) : CutModel(scene_of(mesh)) {}
  explicit CutModel(const Scene& scene)
      : EditModel(TetMesh({scene.positions().begin(), scene.positions().end()},
                          {scene.tets().begin(), scene.tets().end()})),
        tissue_(scene) {
    links.assign(scene.links().begin(), scene.links().end());
  }

  // As the model is, of which tests let tetrahedra go, too.
  const Tissue& tissue() {
    TopologyEdit gone;
    for (Index t = 0; t < static_cast<Index>(tets.size()); ++t) {
      if (!alive[t] && tissue_.is_tet_alive(t)) {
        gone.remove_tets.push_back(t);
      }
    }
    tissue_.apply(gone);
    return tissue_;
  }

  std::string apply(const TopologyEdit& edit) {
    const std::string wrong = EditModel::apply(edit);
    tissue_.apply(edit);
    return wrong.empty() && !std::ranges::equal(tissue_.tets(), tets)
               ? "the tissue has other tetrahedra than the model"
               : wrong;
  }

 private:
  Tissue tissue_;
};

CutPlan plan_with_front(CutModel& model, const CutSurface& surface, const CutOptions& options) {
  std::vector<Vector3f> positions;
  for (const Vector3d& x : model.positions) {
    positions.push_back(x.cast<float>());
  }
  return plan_cut({positions, model.tissue()}, surface, options);
}

TopologyEdit plan(CutModel& model, const CutSurface& surface, const CutOptions& options) {
  return plan_with_front(model, surface, options).edit;
}

bool is_empty(const TopologyEdit& edit) {
  return edit.new_vertices.empty() && edit.corner_moves.empty() && edit.link_moves.empty() &&
         edit.new_tets.empty();
}

// A square of a plane, wide enough for all meshes here.
CutSurface plane_through(const Vector3d& point, const Vector3d& normal, double half_width = 1) {
  const Vector3d along = half_width * normal.unitOrthogonal();
  const Vector3d across = normal.normalized().cross(along);
  return sweep_blade(
      {{{(point - along - across).cast<float>(), (point - along + across).cast<float>()},
        {(point + along - across).cast<float>(), (point + along + across).cast<float>()}}});
}

Vector3d random_direction(std::uint64_t seed) {
  Vector3d direction;
  for (int axis = 0; axis < 3; ++axis) {
    direction[axis] = 2 * random_unit(seed, 7, axis) - 1;
  }
  return direction.norm() > 0.1 ? Vector3d(direction.normalized()) : Vector3d::UnitX();
}

// Crumbs of fewer tetrahedra than `least` left out.
Index count_pieces(const EditModel& model, Index least = 1) {
  const std::vector<Tet> live = model.live_tets();
  const Components pieces = find_components(static_cast<Index>(model.positions.size()), live);
  std::vector<Index> sizes(pieces.count, 0);
  for (const Tet& tet : live) {
    ++sizes[pieces.of_vertex[tet[0]]];
  }
  return static_cast<Index>(
      std::ranges::count_if(sizes, [&](Index size) { return size >= least; }));
}

// How far the furthest piece reaches over to the other side of a plane, m.
double overlap(const EditModel& model, const Vector3d& point, const Vector3d& normal) {
  const std::vector<Tet> live = model.live_tets();
  const Components pieces = find_components(static_cast<Index>(model.positions.size()), live);
  std::vector<double> above(pieces.count, 0), below(pieces.count, 0);
  for (const Tet& tet : live) {
    for (const Index v : tet) {
      const double height = normal.dot(model.positions[v] - point);
      const Index piece = pieces.of_vertex[v];
      above[piece] = std::max(above[piece], height);
      below[piece] = std::max(below[piece], -height);
    }
  }
  double largest = 0;
  for (Index i = 0; i < pieces.count; ++i) {
    largest = std::max(largest, std::min(above[i], below[i]));
  }
  return largest;
}

double longest_edge(const EditModel& model) {
  double longest = 0;
  for (const auto& [a, b] : find_edges(model.live_tets())) {
    longest = std::max(longest, (model.positions[a] - model.positions[b]).norm());
  }
  return longest;
}

TetrahedralizeOptions spaced(double spacing) {
  TetrahedralizeOptions options;
  options.spacing = spacing;
  return options;
}

const TetMesh& ball() {
  static const TetMesh mesh =
      tetrahedralize(sphere_shape({1e-3, 2e-3, -1e-3}, 4 * kCutEdge), spaced(2 * kCutEdge)).mesh;
  return mesh;
}

const TetMesh& shell() {
  static const TetMesh mesh =
      tetrahedralize(shell_shape(sphere_shape({0, 0, 0}, 6 * kCutEdge), 1.6 * kCutEdge),
                     spaced(1.3 * kCutEdge))
          .mesh;
  return mesh;
}

std::vector<TetMesh> meshes() {
  return {testing::make_box({6, 5, 4}, kCutEdge), testing::make_box({6, 5, 4}, kCutEdge, 0.15),
          ball(), shell()};
}

}  // namespace

// Would catch a hole or a bridge in the cut, tetrahedra that do not agree on a face, tissue lost or
// made twice, and a cut beside its plane.
TEST_CASE("cut: a plane parts any body in two", "[property]") {
  const CutStyle style = GENERATE(CutStyle::along_faces, CutStyle::through_tets);
  for (const TetMesh& mesh : meshes()) {
    const Vector3d center = bounding_box(mesh).center();
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      CutModel model(mesh);
      const double volume = model.volume();
      const double longest = longest_edge(model);
      const Vector3d normal = random_direction(seed);
      const Vector3d point =
          center + 1.5 * kCutEdge * random_unit(seed, 8) * random_direction(seed + 1);
      CHECK(model.apply(plan(model, plane_through(point, normal), {.style = style})) == "");
      CAPTURE(style, mesh.tet_count(), seed);
      CHECK(count_pieces(model, style == CutStyle::along_faces ? 3 : 1) == 2);
      CHECK(overlap(model, point, normal) <
            (style == CutStyle::through_tets ? 0.2 : 0.75) * longest);
      CHECK(std::abs(model.volume() - volume) < 1e-6 * volume);
      CHECK(model.least_share > 0.99 * 0.2 * 0.2 * 0.2);
      CHECK(!model.is_pinched());
    }
  }
}

// Would catch slivers and crashes where the plane meets vertices, edges and faces, or nearly.
TEST_CASE("cut: a plane through vertices, edges and faces parts there", "[property]") {
  const CutStyle style = GENERATE(CutStyle::along_faces, CutStyle::through_tets);
  const double offset = GENERATE(0.0, 1e-9, -1e-9, 1e-6, -1e-6, 0.1999, -0.2001);
  const TetMesh mesh = testing::make_box({4, 4, 4}, kCutEdge);
  for (const Vector3d& normal : {Vector3d(1, 0, 0), Vector3d(1, 1, 0), Vector3d(1, -1, 0),
                                 Vector3d(1, 1, 1), Vector3d(-1, 1, 1), Vector3d(2, 1, 0)}) {
    CutModel model(mesh);
    const Vector3d point = kCutEdge * (Vector3d(2, 2, 2) + offset * normal.normalized());
    const TopologyEdit edit = plan(model, plane_through(point, normal), {.style = style});
    CHECK(model.apply(edit) == "");
    CHECK(count_pieces(model) == 2);
    CHECK(model.least_share > 0.99 * 0.2 * 0.2 * 0.2);
    if (normal.y() == 0 && std::abs(offset) < 0.2) {
      CHECK(edit.new_tets.empty());
      CHECK(edit.new_vertices.size() == 25);
    }
  }
}

// Would catch a cut that forgets tissue which was cut before, and pieces that fall apart elsewhere.
TEST_CASE("cut: cuts cross each other", "[property]") {
  const CutStyle style = GENERATE(CutStyle::along_faces, CutStyle::through_tets);
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    CutModel model(testing::make_box({5, 5, 5}, kCutEdge, 0.1));
    const double volume = model.volume();
    const double longest = longest_edge(model);
    for (std::uint64_t i = 0; i < 4; ++i) {
      const Vector3d normal = random_direction(100 * seed + i);
      const Vector3d point = kCutEdge * Vector3d(2.3, 2.6, 2.45);
      const CutSurface surface = plane_through(point, normal);
      CHECK(model.apply(plan(model, surface, {.style = style})) == "");
      CHECK(overlap(model, point, normal) <
            (style == CutStyle::through_tets ? 0.2 : 0.75) * longest);
      CHECK(is_empty(plan(model, surface, {.style = style})));
    }
    CHECK(count_pieces(model) >= 8);
    CHECK(std::abs(model.volume() - volume) < 1e-5 * volume);
  }
}

// Would catch whatever else a blade can do to tissue: bent paths that begin and end anywhere, over
// cuts that are there, around tissue that is gone, in one style after another.
TEST_CASE("cut: any path leaves a mesh that fits together", "[property]") {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    CutModel model(testing::make_box({4, 4, 4}, kCutEdge, 0.15));
    CutFront front;
    for (std::uint64_t round = 0; round < 5; ++round) {
      const std::uint64_t key = 10 * seed + round;
      const auto random = [&](std::uint64_t i) { return random_unit(key, 9, i); };
      Vector3d at = kCutEdge * Vector3d(4 * random(0), 4 * random(1), 4 * random(2));
      Vector3d motion = (0.5 + 2 * random(3)) * kCutEdge * random_direction(key + 50'000);
      Vector3d edge = (0.5 + 5 * random(4)) * kCutEdge * random_direction(key + 60'000);
      std::vector<BladeEdge> path;
      for (int i = 0; i < 4; ++i) {
        path.push_back({(at - edge).cast<float>(), (at + edge).cast<float>()});
        at += motion;
        motion += 0.3 * motion.norm() * random_direction(key + 70'000 + 1000 * i);
        edge += 0.2 * edge.norm() * random_direction(key + 80'000 + 1000 * i);
      }
      const CutStyle style = random(5) < 0.3 ? CutStyle::along_faces : CutStyle::through_tets;
      const double volume = model.volume();
      CAPTURE(seed, round);
      const CutPlan cut =
          plan_with_front(model, sweep_blade(path), {.style = style, .front = front});
      CHECK(model.apply(cut.edit) == "");
      front = cut.front;
      CHECK(model.volume() == testing::Approx(volume).epsilon(1e-6));
      if (seed % 2 == 0) {
        CHECK(!model.is_pinched());
        continue;
      }
      for (std::uint64_t i = 10; i < 30; ++i) {
        model.alive[static_cast<std::size_t>(model.alive.size() * random(i))] = false;
      }
    }
    CHECK(model.least_share > 0.99 * 0.2 * 0.2 * 0.2);
  }
}

// Would catch a cut that runs on beyond its surface, and one that opens nothing.
TEST_CASE("cut: a surface that ends within tissue leaves a slit") {
  const CutStyle style = GENERATE(CutStyle::along_faces, CutStyle::through_tets);
  for (const double depth : {1.6, 2.5, 3.2}) {
    CutModel model(testing::make_box({6, 6, 6}, kCutEdge, 0.1));
    const double area = model.boundary_area();
    const float to = static_cast<float>(depth * kCutEdge), x = 3.3F * kCutEdge;
    const CutSurface surface =
        sweep_blade({{{{x, -1, -1}, {x, -1, 1}}, {{x, to, -1}, {x, to, 1}}}});
    CHECK(model.apply(plan(model, surface, {.style = style})) == "");
    CHECK(count_pieces(model) == 1);
    const double opened = (model.boundary_area() - area) / (2 * to * 6 * kCutEdge);
    CHECK(opened > 0.6);
    CHECK(opened < (style == CutStyle::through_tets ? 1.3 : 3));
    CHECK(!model.is_pinched());
  }
}

// Would catch bridges that are left between the motions of a blade.
TEST_CASE("cut: a blade that goes through step by step parts what it passed", "[long]") {
  const CutStyle style = GENERATE(CutStyle::along_faces, CutStyle::through_tets);
  const double step = GENERATE(0.23, 0.61, 1.7);   // edges
  const double bend = GENERATE(-0.04, 0.0, 0.05);  // rad an edge
  const std::uint64_t seed = GENERATE(range(1, 7));
  CutModel model(testing::make_box({6, 6, 3}, kCutEdge, 0.1, seed));
  const double volume = model.volume();
  Vector3d at(-0.5 * kCutEdge, 2.7 * kCutEdge, 0);
  double heading = -0.2;
  std::vector<BladeEdge> path;
  CutFront front;
  for (int i = 0; at.x() < 7 * kCutEdge && i < 100; ++i) {
    path.push_back(
        {at.cast<float>(), (at + Vector3d(0.1 * kCutEdge, 0, 3.5 * kCutEdge)).cast<float>()});
    path.back().first.z() = -0.5F * kCutEdge;
    heading += bend * step;
    at += step * kCutEdge * Vector3d(std::cos(heading), std::sin(heading), 0);
    if (path.size() > 1) {
      const CutSurface surface = sweep_blade(std::span(path).last(2));
      const CutPlan cut = plan_with_front(model, surface, {.style = style, .front = front});
      CHECK(model.apply(cut.edit) == "");
      front = cut.front;
    }
  }
  CAPTURE(style, step, bend, seed);
  CHECK(count_pieces(model, 20) == 2);
  CHECK(std::abs(model.volume() - volume) < 1e-5 * volume);
}

// Would catch a side found by the plane of one triangle where the surface is curved.
TEST_CASE("cut: a closed surface takes out what is in it") {
  const CutStyle style = GENERATE(CutStyle::along_faces, CutStyle::through_tets);
  CutModel model(testing::make_box({8, 8, 8}, kCutEdge, 0.1));
  const double volume = model.volume();
  std::vector<BladeEdge> path;
  for (int i = 0; i <= 24; ++i) {
    const double angle = i % 24 * std::numbers::pi / 12;
    const Vector3d on =
        kCutEdge * Vector3d(4 + 2.6 * std::cos(angle), 4 + 2.6 * std::sin(angle), -1);
    path.push_back({on.cast<float>(), (on + Vector3d(0, 0, 10 * kCutEdge)).cast<float>()});
  }
  CHECK(model.apply(plan(model, sweep_blade(path), {.style = style})) == "");
  REQUIRE(count_pieces(model) == 2);
  const std::vector<Tet> live = model.live_tets();
  const Components pieces = find_components(static_cast<Index>(model.positions.size()), live);
  double inside = 0;
  for (const Tet& tet : live) {
    inside += (pieces.of_vertex[tet[0]] == 1) * tet_volume(model.positions, tet);
  }
  CHECK(inside == testing::Approx(std::numbers::pi * 2.6 * 2.6 * 8 / 512 * volume).epsilon(0.06));
}

// Would catch links that hold both sides of a cut together.
TEST_CASE("cut: links go with the side on which they are") {
  const CutStyle style = GENERATE(CutStyle::along_faces, CutStyle::through_tets);
  const TetMesh box = testing::make_box({4, 4, 2}, kCutEdge);
  const std::span<const Vector3d> points = box.positions();
  const Index anchor = box.vertex_count();
  Scene scene = scene_of(box);
  scene.add_particles(
      "anchors", std::vector<Vector3d>{kCutEdge * Vector3d(-1, 2, 2), kCutEdge * Vector3d(5, 2, 2)},
      1e-5);
  for (Index v = 0; v < anchor; ++v) {
    scene.add_link({v, anchor, 1e-3F, {}});
    scene.add_link({anchor + 1, v, 1e-3F, {}});
  }
  CutModel model(scene);
  CHECK(model.apply(plan(model, plane_through(kCutEdge * Vector3d(2, 2, 1), {1, 0, 0}),
                         {.style = style})) == "");
  const Components pieces =
      find_components(static_cast<Index>(model.positions.size()), model.live_tets());
  Index parted = 0;
  for (Index v = 0; v < anchor; ++v) {
    const Index left = model.links[2 * v].first, right = model.links[2 * v + 1].second;
    if (std::abs(points[v].x() - 2 * kCutEdge) < 1e-6) {
      CHECK(pieces.of_vertex[left] == pieces.of_vertex[0]);
      CHECK(pieces.of_vertex[right] == pieces.of_vertex[4]);
      ++parted;
    } else {
      CHECK((left == v && right == v));
    }
  }
  CHECK(parted == 15);
}

// Would catch an edit that touches tissue away from the blade, or tissue that is gone.
TEST_CASE("cut: what is not crossed stays as it is") {
  CutModel model(testing::make_box({4, 4, 4}, kCutEdge));
  CHECK(is_empty(plan(model, plane_through({0, 0, 10 * kCutEdge}, {0, 0, 1}), {})));
  CHECK(is_empty(plan(model, plane_through({0, 0, 0}, {1, 1, 1}), {})));
  CHECK(is_empty(
      plan(model, plane_through(kCutEdge * Vector3d(6, 2, 2), {0, 1, 0}, 1.5 * kCutEdge), {})));
  model.positions[62].x() = std::numeric_limits<double>::quiet_NaN();
  const TopologyEdit edit =
      plan(model, plane_through(kCutEdge * Vector3d(2, 2, 2), {1, 1, 0.3}), {});
  CHECK(!edit.new_tets.empty());
  for (const NewVertex& v : edit.new_vertices) {
    CHECK((v.first != 62 && v.second != 62));
  }
  model.alive.assign(model.alive.size(), false);
  CHECK(is_empty(plan(model, plane_through(kCutEdge * Vector3d(2, 2, 2), {1, 1, 0.3}), {})));
}

// Would catch input that leads to a cut nobody can explain.
TEST_CASE("cut: surfaces without a side are refused") {
  CutModel model(testing::make_box({2, 2, 2}, kCutEdge));
  const auto refuse = [&](const CutSurface& surface, const char* reason) {
    CHECK_THROWS_WITH(plan(model, surface, {}), ContainsSubstring(reason));
  };
  const std::vector<Vector3f> square{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5F, 0.5F, 1}};
  const float nan = std::numeric_limits<float>::quiet_NaN();
  refuse({{{0, 0, 0}, {1, nan, 0}, {1, 1, 0}}, {{0, 1, 2}}}, "point 1");
  refuse({square, {{0, 1, 2}, {0, 2, 5}}}, "triangle 1 of the cut's surface has point 5");
  refuse({square, {{0, 1, -1}}}, "point -1");
  refuse({square, {{0, 1, 2}, {0, 0, 3}}}, "triangle 1 of the cut's surface has no area");
  refuse({square, {{0, 1, 2}, {0, 3, 2}, {0, 2, 3}}}, "edge 0-2 of the cut's surface has 3");
  refuse({square, {{0, 1, 2}, {0, 3, 2}}}, "run the same way along");
  refuse({square, {{0, 1, 2}, {0, 2, 1}}}, "fold back");
  for (const CutFront& front : {CutFront{{27}, {}}, CutFront{{}, {{0, 1, 27}}}}) {
    CHECK_THROWS_WITH(plan(model, plane_through({0, 0, 0}, {0, 0, 1}), {.front = front}),
                      ContainsSubstring("vertex 27"));
  }
  for (const float snap : {0.0F, 0.41F, nan}) {
    CHECK_THROWS_AS(plan(model, plane_through({0, 0, 0}, {0, 0, 1}), {.snap = snap}),
                    InvalidArgument);
  }
  CHECK_THROWS_WITH(sweep_blade({{{{0, 0, 0}, {1, 0, 0}}, {{0, 0, 0}, {1, nan, 0}}}}),
                    ContainsSubstring("instant 1"));
}

// Would catch triangles without area from a blade that rests, turns around an end, or slides along
// itself, and a surface that falls into pieces there.
TEST_CASE("cut: a blade may rest, turn and go back") {
  const std::vector<BladeEdge> path{{{0, 0, 0}, {0, 0, 1}}, {{0, 0, 0}, {0, 0, 1}},
                                    {{1, 0, 0}, {1, 0, 1}}, {{1, 0, 0}, {1, 0, 1}},
                                    {{2, 0, 0}, {1, 0, 1}}, {{3, 0, 0}, {2, 0, 1}}};
  const CutSurface surface = sweep_blade(path);
  CHECK(surface.points.size() == 7);
  CHECK(surface.triangles.size() == 5);
  CHECK(sweep_blade({}).triangles.empty());
  CutModel rest(testing::make_box({2, 2, 2}, kCutEdge));
  CHECK(plan(rest, sweep_blade({}), {}).new_tets.empty());

  // a trembling hand: to x = 2 in all, with steps back
  std::vector<BladeEdge> trembling;
  for (const float x : {0.0F, 1.0F, 0.9F, 1.1F, 0.8F, 2.0F}) {
    trembling.push_back({{x, 0, -1}, {x, 0, 1}});
  }
  CutModel model(testing::make_box({4, 4, 4}, 0.5, 0.1));
  for (BladeEdge& edge : trembling) {
    edge.first += Vector3f(0, 0.9F, 1);
    edge.second += Vector3f(0, 0.9F, 1.1F);
  }
  trembling.front().first.x() = trembling.front().second.x() = -0.2F;
  trembling.back().first.x() = trembling.back().second.x() = 2.2F;
  CHECK(model.apply(plan(model, sweep_blade(trembling), {})) == "");
  CHECK(count_pieces(model) == 2);
}

// Would catch a planner that sees the tissue where it was at rest, or tissue that is gone.
TEST_CASE("cut: a solver's tissue is cut where it lies now") {
  const TetMesh box = testing::make_box({4, 4, 4}, kCutEdge);
  Scene scene;
  scene.add_body("block", box);
  Solver solver(scene);
  std::vector<Vector3f> positions = solver.positions();
  for (Vector3f& x : positions) {
    x.x() += 1;
  }
  solver.write_positions(positions);
  const Vector3d there = kCutEdge * Vector3d(2.2, 2, 2) + Vector3d(1, 0, 0);
  CHECK(is_empty(plan_cut(solver, plane_through(there - Vector3d(1, 0, 0), {1, 0, 0}, 0.5)).edit));
  TopologyEdit all;
  const CutSurface surface = plane_through(there, {1, 0, 0});
  for (const NewTet& child : plan_cut(solver, surface).edit.new_tets) {
    if (all.remove_tets.empty() || all.remove_tets.back() != child.parent) {
      all.remove_tets.push_back(child.parent);
    }
  }
  CHECK(all.remove_tets.size() >= 64);
  solver.tissue().apply(all);
  CHECK(is_empty(plan_cut(solver, surface).edit));
}

}  // namespace pbdsurg
