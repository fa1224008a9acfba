// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/tissue/follower.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/heat/heat_field.h"
#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/surgery/cautery.h"
#include "pbdsurg/surgery/connective_tissue.h"
#include "pbdsurg/tissue/library.h"
#include "pbdsurg/tissue/tissue.h"
#include "pbdsurg/views/live_pieces.h"
#include "pbdsurg/views/live_surface.h"

#include "tests/support/catch.h"
#include "tests/support/cuts.h"
#include "tests/support/inspect.h"
#include "tests/support/meshes.h"
#include "tests/support/solver_digest.h"

namespace pbdsurg {
namespace {

using testing::ContainsSubstring;
using testing::digest_of;
using testing::inspect;
using testing::kSoftEdge;

// Containers move what cannot fail to move, and copy the rest: copies would follow nothing.
static_assert(std::is_nothrow_move_constructible_v<LiveSurface>);
static_assert(std::is_nothrow_move_constructible_v<LivePieces>);
static_assert(std::is_nothrow_move_constructible_v<ConnectiveTissue>);
static_assert(std::is_nothrow_move_constructible_v<ThermalMesh>);
static_assert(std::is_nothrow_move_constructible_v<HeatField>);
static_assert(std::is_nothrow_move_constructible_v<Cautery>);

Scene make_block() {
  Scene scene;
  scene.add_body("block", testing::make_box({3, 2, 2}, kSoftEdge, 0.1));
  return scene;
}

// Writes down what it hears: its name, then a letter for follow, undo or renumber.
class Witness : public Follower {
 public:
  Witness(std::string name, std::vector<std::string>& log) : name_(std::move(name)), log_(&log) {}

  void validate(const Tissue&, const TopologyEdit&) const override { refuse(refuses_edits); }
  void validate_undo(const Tissue&, const TissueChange&) const override { refuse(refuses_undos); }
  void follow(const Tissue& tissue, const TissueChange& change) noexcept override {
    saw_it_done = tissue.version() == change.version;
    for (const Index t : change.removed_tets) {
      saw_it_done = saw_it_done && !tissue.is_tet_alive(t);
    }
    log_->push_back(name_ + "f");
  }
  void undo(const Tissue& tissue, const TissueChange& change) noexcept override {
    saw_it_done = tissue.version() == change.version_before;
    for (const Index t : change.removed_tets) {
      saw_it_done = saw_it_done && tissue.is_tet_alive(t);
    }
    log_->push_back(name_ + "u");
  }
  void renumber(const Tissue& tissue, const Renumbering& ids) noexcept override {
    saw_it_done = tissue.version() == ids.version && ids.tets.size() > tissue.tets().size();
    log_->push_back(name_ + "r");
  }

  bool refuses_edits = false, refuses_undos = false;
  bool saw_it_done = false;  // whether the tissue was as it must be, the last time

 private:
  static void refuse(bool refuses) {
    if (refuses) {
      throw InvalidArgument("not now");
    }
  }

  std::string name_;
  std::vector<std::string>* log_;
};

using Log = std::vector<std::string>;

Log take(Log& log) {
  return std::exchange(log, {});
}

}  // namespace

// Would catch a follower that is told of the past, or that an undo takes to before its birth.
// Would catch a list that changes while it is gone through: who comes behind is missed or called
// twice.
TEST_CASE("follower: one that leaves within an edit is not called any more, and the others once",
          "[tissue][follower]") {
  // Drops another when it hears of an edit.
  class Dropper : public Follower {
   public:
    explicit Dropper(std::optional<Witness>& other) : other_(other) {}
    void follow(const Tissue&, const TissueChange&) noexcept override { other_.reset(); }
    void undo(const Tissue&, const TissueChange&) noexcept override {}
    void renumber(const Tissue&, const Renumbering&) noexcept override {}

   private:
    std::optional<Witness>& other_;
  };
  const bool is_dropped_first = GENERATE(false, true);
  std::vector<std::string> log;
  Tissue tissue(make_block());
  std::optional<Witness> dropped(std::in_place, "dropped ", log);
  Dropper dropper(dropped);
  Witness first("a", log), second("b", log);
  if (is_dropped_first) {
    tissue.add_follower(*dropped);
  }
  tissue.add_follower(dropper);
  if (!is_dropped_first) {
    tissue.add_follower(*dropped);
  }
  tissue.add_follower(first);
  tissue.add_follower(second);
  tissue.apply({.remove_tets = {0}});
  tissue.apply({.remove_tets = {1}});
  const auto count = [&](const std::string& name) {
    return std::ranges::count_if(log,
                                 [&](const std::string& line) { return line.starts_with(name); });
  };
  CHECK(count("dropped") == (is_dropped_first ? 1 : 0));
  CHECK(count("a") == 2);
  CHECK(count("b") == 2);
}

TEST_CASE("follower: one that comes late follows what comes later, and ends undo before it",
          "[unit]") {
  Tissue tissue(make_block());
  Log log;
  Witness early("a", log);
  tissue.add_follower(early);
  tissue.apply({.remove_tets = {1}});
  CHECK(take(log) == Log{"af"});
  {
    Witness late("b", log);
    tissue.add_follower(late);
    CHECK(log.empty());
    CHECK_THROWS_WITH(tissue.undo(), ContainsSubstring("a follower came after the last edit"));
    CHECK(log.empty());
    CHECK(!tissue.is_tet_alive(1));
    CHECK(tissue.version() == 1);
    tissue.apply({.remove_tets = {2}});
    CHECK(take(log) == Log{"af", "bf"});
    CHECK(late.saw_it_done);
    tissue.undo();
    CHECK(take(log) == Log{"au", "bu"});
    CHECK(late.saw_it_done);
    CHECK(tissue.version() == 1);
    CHECK_THROWS_WITH(tissue.undo(), ContainsSubstring("there is no edit to undo"));
  }
  // one that came after an edit which was undone since missed nothing
  tissue.apply({.remove_tets = {3}});
  tissue.undo();
  Witness later("c", log);
  tissue.add_follower(later);
  tissue.apply({.remove_tets = {3}});
  CHECK_NOTHROW(tissue.undo());
  CHECK(later.saw_it_done);

  // once the late one has gone, the edit before it can be undone
  tissue.apply({.remove_tets = {4}});
  {
    Witness brief("d", log);
    tissue.add_follower(brief);
    CHECK_THROWS_AS(tissue.undo(), InvalidArgument);
  }
  CHECK_NOTHROW(tissue.undo());
  CHECK(tissue.is_tet_alive(4));
}

// Would catch a call of what is not there any more.
TEST_CASE("follower: one that was destroyed, or left, hears of nothing more", "[unit]") {
  Log log;
  Witness survivor("s", log);
  {
    Tissue tissue(make_block());
    Witness first("a", log), last("c", log);
    tissue.add_follower(first);
    auto brief = std::make_unique<Witness>("b", log);
    tissue.add_follower(*brief);
    tissue.add_follower(last);
    tissue.add_follower(survivor);
    tissue.apply({.remove_tets = {1}});
    CHECK(take(log) == Log{"af", "bf", "cf", "sf"});
    brief.reset();
    tissue.undo();
    CHECK(take(log) == Log{"au", "cu", "su"});
    first.leave_tissue();
    first.leave_tissue();  // once is enough
    tissue.apply({.remove_tets = {1}});
    CHECK(take(log) == Log{"cf", "sf"});
    CHECK_THROWS_WITH(tissue.check_follower(first, "a witness"),
                      ContainsSubstring("a witness does not follow this tissue"));
    CHECK_NOTHROW(tissue.check_follower(last, "a witness"));
  }
  // whose tissue has gone
  Tissue other(make_block());
  CHECK_THROWS_AS(other.check_follower(survivor, "a witness"), InvalidArgument);
  other.add_follower(survivor);
  other.apply({.remove_tets = {1}});
  CHECK(take(log) == Log{"sf"});
}

// Would catch half an edit or half an undo: whoever refuses, nobody has changed.
TEST_CASE("follower: one that refuses leaves everything as it was", "[unit]") {
  const TetMesh lower = testing::make_box({3, 2, 2}, kSoftEdge, 0.1);
  Scene scene = make_block();
  std::vector<Eigen::Vector3d> points(lower.positions().begin(), lower.positions().end());
  for (Eigen::Vector3d& x : points) {
    x.z() += 3 * kSoftEdge;
  }
  const TetMesh upper(points, {lower.tets().begin(), lower.tets().end()});
  scene.add_body("upper", upper);
  ConnectiveTissue strands;
  strands.join(scene, 0, 1,
               scattered_links(lower, upper, {.max_distance = 2 * kSoftEdge, .density = 2e5}));
  REQUIRE(!strands.strands().empty());
  Solver solver(scene, {.executor = executor::serial()});
  Tissue& tissue = solver.tissue();
  tissue.add_follower(strands, FollowerRank::surgery);
  const ThermalBody body{0, tissues::liver().heat};
  HeatField field(tissue, {&body, 1});
  const LiveSurface surface(tissue, 0);
  const LivePieces pieces(tissue);
  Log log;
  Witness before("a", log), refusing("b", log), after("c", log);
  const FollowerRank rank = GENERATE(FollowerRank::solver, FollowerRank::view, FollowerRank::user);
  tissue.add_follower(before, rank);
  tissue.add_follower(refusing, rank);
  tissue.add_follower(after, rank);

  const Index heated = tissue.tets()[0][0];
  field.step(0.1, std::vector<HeatSource>{{heated, 0.1}});
  const auto digest = [&] {
    testing::Digest all;
    all.mix(digest_of(inspect(solver)));
    all.mix(tissue.version());
    all.mix(surface.version());
    all.mix_all(surface.triangles());
    all.mix(pieces.count());
    for (Index t = 0; t < static_cast<Index>(tissue.tets().size()); ++t) {
      all.mix(pieces.piece_of(t));
    }
    all.mix_all(field.temperatures());
    all.mix(field.ledger().removed);
    all.mix(field.mesh().version());
    all.mix(strands.whole_count());
    all.mix(strands.events().size());
    return all.value();
  };
  TopologyEdit edit = testing::split_edge(solver, tissue.tet_edges(0)[0], 0.5F);
  edit.remove_links = {strands.strands()[0].first_link};
  edit.new_bodies.add_body("guest", lower);
  const std::uint64_t untouched = digest();

  refusing.refuses_edits = true;
  CHECK_THROWS_WITH(tissue.apply(edit), ContainsSubstring("not now"));
  CHECK(digest() == untouched);
  CHECK(log.empty());
  CHECK_THROWS_AS(tissue.undo(), InvalidArgument);  // there was no edit

  refusing.refuses_edits = false;
  tissue.apply(edit);
  const std::uint64_t edited = digest();
  CHECK(edited != untouched);
  CHECK(take(log) == Log{"af", "bf", "cf"});
  refusing.refuses_undos = true;
  CHECK_THROWS_WITH(tissue.undo(), ContainsSubstring("not now"));
  CHECK(digest() == edited);
  CHECK(log.empty());

  refusing.refuses_edits = true;  // and the edit is still the last
  CHECK_THROWS_AS(tissue.apply({.remove_tets = {5}}), InvalidArgument);
  refusing.refuses_undos = false;
  tissue.undo();
  CHECK(take(log) == Log{"au", "bu", "cu"});
  CHECK(digest_of(inspect(solver)) != edited);
  CHECK(strands.events().empty());
  CHECK(tissue.version() == 0);
}

// Would catch a follower that reads another one before that has followed.
TEST_CASE("follower: ranks give the order, then who came first", "[unit]") {
  Solver solver(make_block(), {.executor = executor::serial()});
  const Tissue& tissue = solver.tissue();
  Log log;
  Witness user("u", log), surgery("g", log), view("v", log), heat("h", log), of_solver("s", log);
  Witness second("w", log);
  tissue.add_follower(user);
  tissue.add_follower(surgery, FollowerRank::surgery);
  tissue.add_follower(view, FollowerRank::view);
  tissue.add_follower(second, FollowerRank::view);
  tissue.add_follower(heat, FollowerRank::heat);
  tissue.add_follower(of_solver, FollowerRank::solver);
  solver.tissue().apply({.remove_tets = {1}});
  CHECK(take(log) == Log{"sf", "hf", "vf", "wf", "gf", "uf"});
  solver.tissue().undo();
  CHECK(take(log) == Log{"su", "hu", "vu", "wu", "gu", "uu"});
  tissue.add_follower(view, FollowerRank::view);  // again: it comes last of its rank, and once
  solver.tissue().apply({.remove_tets = {1}});
  CHECK(take(log) == Log{"sf", "hf", "wf", "vf", "gf", "uf"});
  Compaction compaction(solver);
  compaction.build();
  static_cast<void>(compaction.finish(solver));
  CHECK(take(log) == Log{"sr", "hr", "wr", "vr", "gr", "ur"});
  for (const Witness* each : {&user, &surgery, &view, &heat, &of_solver, &second}) {
    CHECK(each->saw_it_done);
  }
  CHECK_THROWS_AS(solver.tissue().undo(), InvalidArgument);
}

// Would catch a registration that stays with what was moved from, that a copy takes, or that an
// assignment leaves behind.
TEST_CASE("follower: moved ones go on following, copies do not", "[unit]") {
  Tissue tissue(make_block());
  Log log;
  Witness first("a", log), last("z", log);
  tissue.add_follower(first);
  tissue.add_follower(last);
  const auto hears = [&](const Follower& follower) {
    try {
      tissue.check_follower(follower, "a witness");
      return true;
    } catch (const InvalidArgument&) {
      return false;
    }
  };
  Witness moved = std::move(first);
  CHECK(hears(moved));
  CHECK(!hears(first));  // NOLINT(bugprone-use-after-move)
  tissue.apply({.remove_tets = {1}});
  CHECK(log.size() == 2);
  CHECK(take(log).back() == "zf");  // the order stays
  CHECK_NOTHROW(tissue.undo());     // and since when it follows
  log.clear();

  Witness copy = moved;
  CHECK(!hears(copy));
  CHECK(hears(moved));
  copy = std::move(moved);
  CHECK(hears(copy));
  CHECK(!hears(moved));  // NOLINT(bugprone-use-after-move)
  Witness& same = copy;
  copy = same;
  CHECK(hears(copy));
  copy = std::move(same);
  CHECK(hears(copy));
  copy = last;  // becomes a copy, and so leaves
  CHECK(!hears(copy));
  CHECK(hears(last));
  Witness replaced("r", log);
  tissue.add_follower(replaced);
  replaced = std::move(last);
  CHECK(hears(replaced));
  tissue.apply({.remove_tets = {2}});
  CHECK(log == Log{"zf"});

  // of the library
  std::vector<LiveSurface> surfaces;
  for (int i = 0; i < 5; ++i) {
    surfaces.emplace_back(tissue, 0);  // which moves those before
  }
  const LiveSurface stale = surfaces[0];
  auto pieces = std::make_unique<LivePieces>(tissue);
  LivePieces moved_pieces = std::move(*pieces);
  pieces.reset();
  const ThermalBody body{0, tissues::liver().heat};
  std::optional<HeatField> field(std::in_place, tissue, std::span(&body, 1));
  HeatField moved_field = std::move(*field);
  HeatField copied_field = moved_field;
  field.reset();
  const Tet corners = tissue.tets()[3];
  tissue.apply({.remove_tets = {3}});
  const Index triangles = LiveSurface(tissue, 0).triangle_count();
  for (const LiveSurface& surface : surfaces) {
    CHECK(surface.triangle_count() == triangles);
  }
  CHECK(!std::ranges::equal(stale.triangles(), surfaces[0].triangles()));
  CHECK(moved_pieces.piece_of(3) == kInvalidIndex);
  const std::vector<HeatSource> sources{{corners[0], 0.1}};
  CHECK_NOTHROW(moved_field.step(0.01, sources));
  CHECK_THROWS_WITH(copied_field.step(0.01, sources), ContainsSubstring("copies do not follow"));
}

// Would catch a list of followers that tissues share, or an edit of one that counts for all.
TEST_CASE("follower: those of one tissue never hear of another's edits", "[unit]") {
  const Scene scene = make_block();
  Tissue one(scene), other(scene);
  Log log;
  Witness witness("a", log), elsewhere("b", log);
  one.add_follower(witness);
  other.add_follower(elsewhere);
  const LiveSurface surface(one, 0);
  const Index triangles = surface.triangle_count();
  other.apply({.remove_tets = {1}});
  CHECK(take(log) == Log{"bf"});
  CHECK(surface.triangle_count() == triangles);
  CHECK(one.version() == 0);
  one.apply({.remove_tets = {2}});
  CHECK(take(log) == Log{"af"});
  CHECK(one.identified_version() != other.identified_version());
  CHECK(one.version() == other.version());

  other.add_follower(witness);  // and so it leaves the one
  one.apply({.remove_tets = {3}});
  CHECK(log.empty());
  other.apply({.remove_tets = {3}});
  CHECK(take(log) == Log{"bf", "af"});
}

}  // namespace pbdsurg
