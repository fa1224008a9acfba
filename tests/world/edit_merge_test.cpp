// SPDX-License-Identifier: Apache-2.0
#include "lib/world/edit_merge.h"

#include <limits>

#include "tests/support/catch.h"
#include "tests/support/meshes.h"

namespace pbdsurg {
namespace {

constexpr Index kVertices = 10;

Scene particles(const std::string& name, Index count) {
  Scene scene;
  scene.add_particles(
      name, std::vector<Eigen::Vector3d>(static_cast<std::size_t>(count), Eigen::Vector3d::Zero()),
      1e-3);
  return scene;
}

// Two new vertices and one of a body, and a link from each to vertex 0.
TopologyEdit bringing(const std::string& name) {
  TopologyEdit edit;
  edit.new_vertices = {{1, 1}, {2, 2}};
  edit.corner_moves = {{3, 1, kVertices}};
  edit.new_tets = {{4, {kVertices, kVertices + 1, 5, 6}}};
  edit.new_bodies = particles(name, 1);
  edit.new_links = {{0, kVertices, 0, {}}, {0, kVertices + 1, 0, {}}, {0, kVertices + 2, 0, {}}};
  return edit;
}

}  // namespace

// Would catch an edit refused because two sources ask for the same.
TEST_CASE("edit merge: what is named twice is asked for once, in order", "[unit]") {
  TopologyEdit edit{.remove_tets = {5, 3}, .remove_links = {2}, .remove_bodies = {1}};
  REQUIRE(merge(edit, {.remove_tets = {7, 5}, .remove_links = {2, 1}, .remove_bodies = {1, 0}},
                kVertices));
  CHECK(edit.remove_tets == std::vector<Index>{5, 3, 7});
  CHECK(edit.remove_links == std::vector<Index>{2, 1});
  CHECK(edit.remove_bodies == std::vector<Index>{1, 0});
  CHECK(is_empty({}));
  CHECK_FALSE(is_empty(edit));
  CHECK_FALSE(is_empty({.new_bodies = particles("a", 1)}));
}

// Would catch a link to a vertex that another source brings.
TEST_CASE("edit merge: what several bring has the numbers that it gets", "[unit]") {
  TopologyEdit edit = bringing("a");
  REQUIRE(merge(edit, bringing("b"), kVertices));
  REQUIRE(edit.new_vertices.size() == 4);
  CHECK(edit.corner_moves[0].to == kVertices);
  CHECK(edit.corner_moves[1].to == kVertices + 2);
  CHECK(edit.new_tets[1].vertices == Tet{kVertices + 2, kVertices + 3, 5, 6});
  std::vector<Index> ends;
  for (const Link& link : edit.new_links) {
    CHECK(link.first == 0);
    ends.push_back(link.second - kVertices);
  }
  // four new vertices, then that of either body
  CHECK(ends == std::vector<Index>{0, 1, 4, 2, 3, 5});
  CHECK(edit.new_bodies.bodies()[1].name == "b");
}

// Would catch a wrong id that becomes a right one by what else comes.
TEST_CASE("edit merge: ids beyond what is and comes are not made ids of others", "[unit]") {
  for (const Index bad : {kVertices + 3, std::numeric_limits<Index>::max()}) {
    TopologyEdit edit = bringing("a"), wrong = bringing("b");
    wrong.new_links[0].second = bad;
    CHECK_FALSE(merge(edit, wrong, kVertices));
    CHECK(edit.new_links.size() == 3);
    CHECK_FALSE(merge(wrong, edit, kVertices));
  }
  TopologyEdit edit = bringing("a");
  CHECK_FALSE(merge(edit, bringing("a"), kVertices));  // names differ
  CHECK(edit.new_vertices.size() == 2);
}

TEST_CASE("edit merge: after others, what is done is left out and what is new is moved", "[unit]") {
  Scene scene;
  scene.add_body("body", testing::make_box({2, 1, 1}, 1e-2));
  Tissue tissue(scene);
  const auto vertices = tissue.vertex_count(), tets = static_cast<Index>(tissue.tets().size());
  const EarlierEdits fresh(tissue);
  EarlierEdits earlier = fresh;
  earlier.note(tissue.apply({.remove_tets = {4, 1}, .new_bodies = particles("p", 3)}));

  TopologyEdit edit{.remove_tets = {0, 1, 4, tets}, .remove_bodies = {0, 1}};
  edit.new_links = {{2, vertices, 0, {}}, {2, std::numeric_limits<Index>::max(), 0, {}}};
  earlier.adapt(edit, tissue);
  CHECK(edit.remove_tets == std::vector<Index>{0, tets});  // no tets came: still out of range
  CHECK(edit.remove_bodies == std::vector<Index>{0, 2});   // 1 was not there, and is another's now
  CHECK(edit.new_links[0].first == 2);
  CHECK(edit.new_links[0].second == vertices + 3);
  CHECK(edit.new_links[1].second == std::numeric_limits<Index>::max());
}

TEST_CASE("edit merge: a scene takes in another", "[unit]") {
  Scene scene = particles("a", 2), other;
  other.add_body("box", testing::make_box({1, 1, 1}, 1e-2));
  other.fix_vertices(0, std::vector<Index>{3});
  other.add_particles("p", std::vector<Eigen::Vector3d>{{1, 2, 3}, {4, 5, 6}}, 2e-3);
  other.add_link({0, 8, 1e-3F, {}});
  const Index hinges = other.add_hinges(0, 1e-3F);
  scene.append(other);
  REQUIRE(scene.bodies().size() == 3);
  CHECK(scene.body(1).first_vertex == 2);
  CHECK(scene.body(2).first_vertex == 10);
  CHECK(scene.tets().size() == other.tets().size());
  CHECK(scene.tets()[0][0] == other.tets()[0][0] + 2);
  CHECK(scene.is_fixed(5));
  CHECK_FALSE(scene.is_fixed(4));
  CHECK(scene.links()[0].second == 10);
  REQUIRE(static_cast<Index>(scene.hinges().size()) == hinges);
  CHECK(scene.hinges()[0].vertices[3] == other.hinges()[0].vertices[3] + 2);
  CHECK(scene.masses()[11] == 2e-3);
  CHECK_THROWS_AS(scene.append(other), InvalidArgument);  // names are taken; nothing has changed
  CHECK(scene.vertex_count() == 12);
  CHECK(scene.links().size() == 1);
}

}  // namespace pbdsurg
