// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/surgery/connective_tissue.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/surgery/cautery.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using testing::Approx;
using testing::ContainsSubstring;

constexpr double kJoinedEdge = 2e-3;
constexpr double kGap = 3e-3;

TetMesh raised(const TetMesh& mesh, double height) {
  std::vector<Vector3d> points(mesh.positions().begin(), mesh.positions().end());
  for (Vector3d& p : points) {
    p.z() += height;
  }
  return TetMesh(points, {mesh.tets().begin(), mesh.tets().end()});
}

// Two slabs, one above the other, with strands between them.
struct JoinedSlabs {
  TetMesh lower = testing::make_box({6, 6, 2}, kJoinedEdge);
  TetMesh upper = raised(lower, 2 * kJoinedEdge + kGap);
  Scene scene;
  ConnectiveTissue tissue;

  explicit JoinedSlabs(const StrandOptions& options = {}, std::uint64_t seed = 1) {
    scene.add_body("lower", lower);
    scene.add_body("upper", upper);
    scene.set_gravity(Vector3f::Zero());
    const auto links =
        scattered_links(lower, upper, {.max_distance = 2 * kGap, .density = 2e6, .seed = seed});
    tissue.join(scene, 0, 1, links, options);
  }
};

// Two particles apart along z, the upper one fixed, with one strand between them.
struct Thread {
  Scene scene;
  ConnectiveTissue tissue;

  Thread(double length, const StrandOptions& options, double mass = 1e-3, Index fibres = 1) {
    scene.add_particles("lower", std::vector<Vector3d>{{0, 0, -length}}, mass);
    scene.add_particles("upper", std::vector<Vector3d>{{0, 0, 0}}, 1);
    scene.fix_vertices(1, std::vector<Index>{0});
    scene.set_gravity({0, 0, -10});
    tissue.join(scene, 0, 1, std::vector<MembraneLink>{{0, 0, length, fibres}}, options);
  }
};

std::vector<Index> torn_links(ConnectiveTissue& tissue, const Solver& solver) {
  std::vector<Index> links;
  tissue.find_torn(solver, links);
  return links;
}

std::vector<Index> cut_links(ConnectiveTissue& tissue, const Solver& solver,
                             const BladeSweep& blade) {
  std::vector<Index> links;
  tissue.find_cut(solver, std::span(&blade, 1), links);
  return links;
}

// All that a user sees of it.
struct Seen {
  std::vector<Index> whole;
  std::vector<std::array<Index, 3>> events;

  explicit Seen(const ConnectiveTissue& tissue) {
    for (Index s = 0; s < static_cast<Index>(tissue.strands().size()); ++s) {
      if (tissue.is_whole(s)) {
        whole.push_back(s);
      }
    }
    for (const StrandEvent& event : tissue.events()) {
      events.push_back({event.strand, event.link, static_cast<Index>(event.cause)});
    }
    CHECK(tissue.whole_count() == static_cast<Index>(whole.size()));
  }
  friend bool operator==(const Seen&, const Seen&) = default;
};

}  // namespace

// Would catch strands that pull or push from the start: joints off their places, rest lengths of
// another strand, links to a wrong vertex.
TEST_CASE("connective tissue: strands are at rest where they are made", "[property]") {
  const int segments = GENERATE(1, 2, 3, 7);
  const double slack = segments == 1 ? 0 : GENERATE(0.0, 0.1, 1.0);
  const JoinedSlabs slabs({.segments = segments, .slack = slack});
  const auto x = slabs.scene.positions();
  REQUIRE(slabs.tissue.strands().size() > 30);
  REQUIRE(slabs.scene.links().size() == segments * slabs.tissue.strands().size());
  for (const Strand& strand : slabs.tissue.strands()) {
    double length = 0;
    for (Index k = 0; k < strand.link_count; ++k) {
      const Link& link = slabs.scene.links()[strand.first_link + k];
      const double distance = (x[link.first] - x[link.second]).norm();
      CHECK(link.rest_length == Approx(distance).epsilon(1e-5));
      length += distance;
      if (k > 0) {
        CHECK(link.first == slabs.scene.links()[strand.first_link + k - 1].second);
      }
    }
    const Index first = slabs.scene.links()[strand.first_link].first;
    const Index last = slabs.scene.links()[strand.first_link + strand.link_count - 1].second;
    CHECK(first < slabs.scene.body(1).first_vertex);
    CHECK(last >= slabs.scene.body(1).first_vertex);
    CHECK(length == Approx((1 + slack) * (x[first] - x[last]).norm()));
  }
}

// Would catch a rule that depends on how finely a strand is divided, or on fibres, or that mistakes
// a squared length for a length: a weight is held if and only if it is below the stated tension.
TEST_CASE("connective tissue: a strand holds its strength and not more", "[validation]") {
  const int segments = GENERATE(1, 4);
  const double length = GENERATE(1e-3, 20e-3);
  const bool is_too_heavy = GENERATE(false, true);
  StrandOptions options{.segments = segments, .stiffness = 0.1, .tear_stretch = 1.5};
  options.particle_mass = segments > 1 ? 5e-5 : options.particle_mass;
  const Index fibres = GENERATE(1, 3);
  const double strength = fibres * 0.1 * 0.5;  // N
  Thread thread(length, options, (is_too_heavy ? 1.1 : 0.9) * strength / 10, fibres);
  Solver solver(thread.scene, {.substeps = 50, .damping = 200});
  solver.tissue().add_follower(thread.tissue, FollowerRank::surgery);
  for (int i = 0; i < 1000 && thread.tissue.whole_count() == 1; ++i) {
    solver.step(2e-3F);
    thread.tissue.separate(solver);
  }
  CHECK((thread.tissue.whole_count() == 0) == is_too_heavy);
  if (is_too_heavy) {
    REQUIRE(thread.tissue.events().size() == 1);
    CHECK(thread.tissue.events()[0].cause == StrandLoss::torn);
    CHECK(thread.tissue.share_lost(StrandLoss::torn) == 1);
  }
}

TEST_CASE("connective tissue: the longest link of a strand tears, and an endless one never",
          "[unit]") {
  const double tear_stretch = GENERATE(1.6, 1.7, std::numeric_limits<double>::infinity());
  Thread thread(4e-3, {.segments = 4, .tear_stretch = tear_stretch});
  Solver solver(thread.scene);
  solver.tissue().add_follower(thread.tissue, FollowerRank::surgery);
  std::vector<Vector3f> x = solver.positions();
  x[0].z() = -6.6e-3F;  // links from below: 1.6, 1.6, 1.4 and 2 mm, all of 1 mm: 1.65 in the mean
  x[2].z() = -5.0e-3F;
  x[3].z() = -3.4e-3F;
  x[4].z() = -2.0e-3F;
  solver.write_positions(x);
  const auto torn = torn_links(thread.tissue, solver);
  CHECK(torn == (tear_stretch < 1.65 ? std::vector<Index>{3} : std::vector<Index>{}));
}

// Against the plane and the outline of a flat sweep. Would catch a strand that slips through the
// sheet's diagonal, between two steps of the blade, or is cut beside it.
TEST_CASE("connective tissue: a blade cuts what its edge sweeps over", "[property]") {
  const std::uint64_t seed = GENERATE(range(1, 21));
  const int segments = GENERATE(1, 3);
  JoinedSlabs slabs({.segments = segments, .slack = segments > 1 ? 0.2 : 0.0}, seed);
  Solver solver(slabs.scene);
  solver.tissue().add_follower(slabs.tissue, FollowerRank::surgery);
  const auto random = [&](std::uint64_t i) { return random_unit(seed, 100 + i); };
  // a parallelogram within the gap, tilted
  const Vector3d corner(-4e-3 + 8e-3 * random(0), -4e-3 + 8e-3 * random(1),
                        2 * kJoinedEdge + kGap * (0.2 + 0.4 * random(2)));
  const Vector3d edge(12e-3 * random(3), 6e-3, 1e-3 * random(4));
  const Vector3d way(10e-3, 10e-3 * (random(5) - 0.5), 1e-3 * (random(6) - 0.5));
  const auto blade_at = [&](double share) {
    const Vector3d start = corner + share * way;
    return BladeEdge{start.cast<float>(), (start + edge).cast<float>()};
  };

  std::set<Index> expected;  // strands
  const Vector3d normal = edge.cross(way);
  const auto x = solver.positions();
  for (Index s = 0; s < static_cast<Index>(slabs.tissue.strands().size()); ++s) {
    const Strand& strand = slabs.tissue.strands()[s];
    for (Index k = 0; k < strand.link_count; ++k) {
      const Link& link = solver.tissue().links()[strand.first_link + k];
      const Vector3d a = x[link.first].cast<double>(), b = x[link.second].cast<double>();
      const double share = normal.dot(corner - a) / normal.dot(b - a);
      const Vector3d hit = a + share * (b - a) - corner;
      const double along = normal.dot(hit.cross(way)) / normal.squaredNorm();
      const double across = normal.dot(edge.cross(hit)) / normal.squaredNorm();
      if (share >= 0 && share <= 1 && along >= 0 && along <= 1 && across >= 0 && across <= 1) {
        expected.insert(s);
      }
    }
  }

  for (const int steps : {1, 17}) {
    ConnectiveTissue tissue = slabs.tissue;
    solver.tissue().add_follower(tissue, FollowerRank::surgery);
    std::set<Index> cut;
    for (int i = 0; i < steps; ++i) {
      const BladeSweep blade{blade_at(static_cast<double>(i) / steps),
                             blade_at(static_cast<double>(i + 1) / steps)};
      for (const Index link : cut_links(tissue, solver, blade)) {
        cut.insert(link / segments);
      }
    }
    CHECK(cut == expected);
  }
  const BladeSweep resting{blade_at(0.5), blade_at(0.5)};
  CHECK(cut_links(slabs.tissue, solver, resting).empty());
}

// Would catch strands that are lost or kept against what the solver holds, causes mixed up, and
// anything that an undo forgets.
TEST_CASE("connective tissue: it follows any edit, and back", "[property]") {
  const std::uint64_t seed = GENERATE(range(1, 11));
  JoinedSlabs slabs({.segments = 3});
  ConnectiveTissue& tissue = slabs.tissue;
  Solver solver(slabs.scene);
  solver.tissue().add_follower(slabs.tissue, FollowerRank::surgery);
  std::uint64_t round = 0;
  const auto pick = [&](double share) { return random_unit(seed, ++round) < share; };
  while (tissue.whole_count() > 0) {
    TopologyEdit edit;
    for (Index l = 0; l < static_cast<Index>(solver.tissue().links().size()); ++l) {
      if (solver.tissue().is_link_alive(l) && pick(0.02)) {
        edit.remove_links.push_back(l);
      }
    }
    for (Index t = 0; t < static_cast<Index>(solver.tissue().tets().size()); ++t) {
      if (solver.tissue().is_tet_alive(t) && pick(0.05)) {
        edit.remove_tets.push_back(t);
      }
    }
    const Seen before(tissue);
    const std::uint64_t version = solver.tissue().apply(edit).version;
    const Seen after(tissue);
    for (Index s = 0; s < static_cast<Index>(tissue.strands().size()); ++s) {
      const Strand& strand = tissue.strands()[s];
      bool is_whole = true;
      for (Index k = 0; k < strand.link_count; ++k) {
        is_whole = is_whole && solver.tissue().is_link_alive(strand.first_link + k);
      }
      REQUIRE(tissue.is_whole(s) == is_whole);
    }
    for (const StrandEvent& event : tissue.events()) {
      CHECK((event.cause == StrandLoss::removed || event.cause == StrandLoss::without_tissue));
      const bool was_asked =
          std::count(edit.remove_links.begin(), edit.remove_links.end(), event.link) > 0;
      CHECK((event.version < version || was_asked == (event.cause == StrandLoss::removed)));
    }
    solver.tissue().undo();
    CHECK(Seen(tissue) == before);
    solver.tissue().apply(edit);
    CHECK(Seen(tissue) == after);
  }
  CHECK(tissue.events().size() == tissue.strands().size());
  CHECK(tissue.share_lost(StrandLoss::removed) + tissue.share_lost(StrandLoss::without_tissue) ==
        Approx(1));
}

// Would catch the two ways mixed up in one step, a link asked for twice, and an edit of nothing.
TEST_CASE("connective tissue: separating tears and cuts in one edit", "[unit]") {
  JoinedSlabs slabs({.segments = 2});
  Solver solver(slabs.scene);
  solver.tissue().add_follower(slabs.tissue, FollowerRank::surgery);
  CHECK(slabs.tissue.separate(solver) == nullptr);
  CHECK(solver.tissue().version() == 0);

  // the upper slab is far away, and a blade goes through half of the strands
  std::vector<Vector3f> x = solver.positions();
  for (std::size_t v = slabs.scene.body(1).first_vertex; v < x.size(); ++v) {
    x[v].z() += 10e-3F;
  }
  solver.write_positions(x);
  const float middle = 6e-3F;
  const BladeSweep blade{{Vector3f(-1, -1, 6e-3F), Vector3f(-1, 1, 6e-3F)},
                         {Vector3f(middle, -1, 6e-3F), Vector3f(middle, 1, 6e-3F)}};
  const std::vector<Index> torn = torn_links(slabs.tissue, solver);
  const std::vector<Index> cut = cut_links(slabs.tissue, solver, blade);
  CHECK(torn.size() == slabs.tissue.strands().size());
  CHECK(cut.size() > torn.size() / 4);
  CHECK(cut.size() < torn.size());

  const TissueChange* const change = slabs.tissue.separate(solver, std::span(&blade, 1));

  REQUIRE(change != nullptr);
  CHECK(change->removed_links == change->edit.remove_links);
  CHECK(change->removed_links.size() == torn.size());
  CHECK(slabs.tissue.whole_count() == 0);
  CHECK(slabs.tissue.share_lost(StrandLoss::blade) ==
        static_cast<double>(cut.size()) / static_cast<double>(torn.size()));
  CHECK(slabs.tissue.share_lost(StrandLoss::torn) ==
        Approx(1 - slabs.tissue.share_lost(StrandLoss::blade)));
  CHECK(slabs.tissue.separate(solver, std::span(&blade, 1)) == nullptr);
}

TEST_CASE("connective tissue: heat parts strands link by link", "[unit]") {
  Thread thread(3e-3, {.segments = 3});
  Solver solver(thread.scene);
  solver.tissue().add_follower(thread.tissue, FollowerRank::surgery);
  Cautery cautery(solver.tissue(), {}, {.contact_radius = 1e-3, .link_energy = 0.1});
  const Eigen::Vector3f tip(0.2e-3F, 0, -1.5e-3F);
  int updates = 0;
  for (; thread.tissue.whole_count() == 1 && updates < 100; ++updates) {
    // some 8 mJ
    cautery.update(solver, {tip, tip}, cut_settings(2), 5e-3);
  }
  REQUIRE(thread.tissue.events().size() == 1);
  CHECK(thread.tissue.events()[0].link == 1);  // the middle one, nearest to the tip
  CHECK(thread.tissue.events()[0].cause == StrandLoss::removed);
  CHECK(updates >= 10);
  CHECK_FALSE(solver.tissue().is_link_alive(1));
}

TEST_CASE("connective tissue: bad values are refused by name, and nothing is joined", "[unit]") {
  Scene scene;
  const TetMesh box = testing::make_box({1, 1, 1}, kJoinedEdge);
  scene.add_body("a", box);
  scene.add_body("b", raised(box, 2 * kJoinedEdge));
  ConnectiveTissue tissue;
  const auto refuse = [&](const MembraneLink& link, const StrandOptions& options,
                          const std::string& why) {
    CHECK_THROWS_WITH(tissue.join(scene, 0, 1, std::span(&link, 1), options),
                      ContainsSubstring(why));
  };
  const MembraneLink good{0, 0, 1e-3};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  refuse({8, 0, 1e-3}, {}, "body 'a' has no vertex 8");
  refuse({0, -1, 1e-3}, {}, "body 'b' has no vertex -1");
  refuse({0, 0, nan}, {}, "link 0 has rest length nan");
  refuse({0, 0, 1e-3, 0}, {}, "0 fibres");
  refuse(good, {.segments = 0}, "segments is 0");
  refuse(good, {.stiffness = 0}, "stiffness is 0 N");
  refuse(good, {.stiffness = 1e-30}, "compliance");
  refuse(good, {.fraction = 2}, "fraction");
  refuse(good, {.tear_stretch = 1}, "tear_stretch is 1");
  refuse(good, {.least_length = nan}, "least_length is nan m");
  refuse(good, {.segments = 2, .slack = -1}, "slack is -1");
  refuse(good, {.slack = 0.1}, "push the organs apart");
  refuse(good, {.particle_mass = -1}, "particle_mass is -1 kg");
  refuse(good, {.particle_mass = 1e-6}, "particle_mass is 1e-06 kg, which nothing would read");
  CHECK_THROWS_WITH(tissue.join(scene, 0, 2, {}), ContainsSubstring("no body 2"));
  const MembraneLink across{0, 7, 1e-3};
  CHECK_THROWS_WITH(tissue.join(scene, 0, 0, std::span(&across, 1)),
                    ContainsSubstring("body 'a' (0) would be joined to itself"));
  CHECK(scene.links().empty());
  CHECK(scene.bodies().size() == 2);
  CHECK(tissue.strands().empty());

  tissue.join(scene, 0, 1, std::span(&good, 1));
  Solver solver(scene);
  CHECK_THROWS_WITH(tissue.separate(solver),
                    ContainsSubstring("connective tissue does not follow this tissue"));
  solver.tissue().add_follower(tissue, FollowerRank::surgery);
  BladeSweep blade{{Vector3f::Zero(), Vector3f::Ones()}, {Vector3f::Zero(), Vector3f::Ones()}};
  blade.now.second.x() = std::numeric_limits<float>::infinity();
  CHECK_THROWS_WITH(tissue.separate(solver, std::span(&blade, 1)),
                    ContainsSubstring("blade 0 is not finite"));
  CHECK(tissue.whole_count() == 1);
}

// Would catch strands that take each other's links, or come back to life, once links have new ids.
TEST_CASE("connective tissue: goes along with a compaction", "[property]") {
  const StrandOptions options{.segments = 3, .particle_mass = 1e-6};
  JoinedSlabs slabs(options), others(options);
  Solver solver(slabs.scene), unchanged(others.scene);
  solver.tissue().add_follower(slabs.tissue, FollowerRank::surgery);
  unchanged.tissue().add_follower(others.tissue, FollowerRank::surgery);
  Compaction compaction(solver);
  for (auto& [of, tissue] :
       {std::pair(&solver, &slabs.tissue), std::pair(&unchanged, &others.tissue)}) {
    TopologyEdit edit;
    for (Index s = 0; s < static_cast<Index>(tissue->strands().size()); s += 2) {
      const Strand& strand = tissue->strands()[s];
      for (Index k = 0; k <= s % 3; ++k) {  // some lose all
        edit.remove_links.push_back(strand.first_link + k);
      }
    }
    of->tissue().apply(edit);
    if (of == &solver) {
      compaction = Compaction(solver);
    }
  }
  compaction.build();
  const Renumbering ids = compaction.finish(solver);
  REQUIRE(slabs.tissue.whole_count() == others.tissue.whole_count());
  CHECK(slabs.tissue.events().size() == others.tissue.events().size());
  for (Index s = 0; s < static_cast<Index>(slabs.tissue.strands().size()); ++s) {
    const Strand& now = slabs.tissue.strands()[s];
    const Strand& before = others.tissue.strands()[s];
    REQUIRE(slabs.tissue.is_whole(s) == others.tissue.is_whole(s));
    Index left = 0;
    for (Index k = 0; k < before.link_count; ++k) {
      const Index id = ids.links[before.first_link + k];
      REQUIRE((id == kInvalidIndex || id == now.first_link + left++));
    }
    REQUIRE(now.link_count == left);
  }
  // what parts from then on is counted at the same strands
  const Index strand = 5;
  for (auto& [of, tissue] :
       {std::pair(&solver, &slabs.tissue), std::pair(&unchanged, &others.tissue)}) {
    of->tissue().apply({.remove_links = {tissue->strands()[strand].first_link + 1}});
    CHECK(tissue->events().back().strand == strand);
    CHECK(!tissue->is_whole(strand));
  }
  CHECK(slabs.tissue.separate(solver) == nullptr);
}

}  // namespace pbdsurg
