// SPDX-License-Identifier: Apache-2.0
#include "tests/support/edit_trial.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <sstream>
#include <utility>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/heat/heat_field.h"
#include "pbdsurg/tissue/library.h"

#include "tests/support/edit_maker.h"
#include "tests/support/edit_spoiler.h"
#include "tests/support/eventful_program.h"
#include "tests/support/inspect.h"
#include "tests/support/model_difference.h"
#include "tests/support/solver_digest.h"

namespace pbdsurg::testing {
namespace {

constexpr float kTimeStep = 1e-3F;  // s

std::string text_of(const StepReport& report) {
  std::ostringstream text;
  text << std::hexfloat << report.inverted_tets << " inverted, residuals "
       << report.distance_residual << " and " << report.volume_residual << ", " << report.contacts
       << " contacts";
  return text.str();
}

// Takes no edit.
class Refuser final : public Follower {
 public:
  void validate(const Tissue&, const TopologyEdit&) const override {
    throw InvalidArgument("a follower takes no edit");
  }
  void follow(const Tissue&, const TissueChange&) noexcept override {}
  void undo(const Tissue&, const TissueChange&) noexcept override {}
  void renumber(const Tissue&, const Renumbering&) noexcept override {}
};

Cautery make_cautery(const Tissue& tissue) {
  const ThermalBody body{0, tissues::liver().heat};
  return {tissue, {&body, 1}};
}

}  // namespace

EditTrial::EditTrial(const EditScene& scene, const SolverOptions& options, bool has_twin)
    : solver_(scene.scene, options),
      cautery_(make_cautery(solver_.tissue())),
      strands_(scene.strands),
      pieces_(solver_.tissue()),
      model_(scene.scene) {
  solver_.tissue().add_follower(strands_, FollowerRank::surgery);
  add_surfaces();
  if (has_twin || !options.executor || options.executor.kind() != ExecutorKind::serial) {
    SolverOptions serial = options;
    serial.executor = executor::serial();
    serial.device_strategy = DeviceStrategy::automatic;
    twin_.emplace(scene.scene, serial);
  }
}

// Of bodies that have none yet.
void EditTrial::add_surfaces() {
  while (surfaces_.size() < solver_.tissue().bodies().size()) {
    surfaces_.emplace_back(solver_.tissue(), static_cast<Index>(surfaces_.size()));
  }
}

void EditTrial::apply(const TopologyEdit& change) {
  if (twin_) {
    twin_->tissue().apply(change);
  }
  solver_.tissue().apply(change);
}

void EditTrial::edit(const TopologyEdit& change) {
  model_.apply(solver_, change);
  apply(change);
  add_surfaces();
  front_ = {};
}

void EditTrial::edit(Choices& choices) {
  Change change = make_change(choices);
  edit(change.edit);
  front_ = std::move(change.front);
}

std::string EditTrial::edit_and_undo(Choices& choices) {
  const TopologyEdit change = make_change(choices).edit;
  return edit_and_undo(change, choices.below(4) == 0);
}

std::string EditTrial::edit_and_undo(const TopologyEdit& change, bool steps) {
  // a device has the state while it steps, but the twin, with which step() compares, has it here
  const SolverData& still = inspect(is_stepping_ && twin_ ? *twin_ : solver_);
  const std::uint64_t before = digest_of(still);
  apply(change);
  std::string wrong = steps ? step() : "";
  solver_.tissue().undo();
  if (twin_) {
    twin_->tissue().undo();
  }
  if (wrong.empty() && !steps && digest_of(still) != before) {
    wrong = "undo leaves something changed";
  }
  return wrong;
}

std::string EditTrial::try_bad_edit(Choices& choices) {
  TopologyEdit edit = make_change(choices).edit;
  Refuser refuser;
  if (choices.below(16) == 0) {
    solver_.tissue().add_follower(
        refuser, choices.below(2) == 0 ? FollowerRank::solver : FollowerRank::user);
  } else {
    spoil(solver_, choices, edit);
  }
  if (inspect(solver_).has_grips()) {  // which a step may end, for which edits wait
    static_cast<void>(solver_.lost_grips());
  }
  const std::uint64_t before = digest_of(inspect(solver_));
  try {
    solver_.tissue().apply(edit);
    return "a bad edit was accepted";
  } catch (const InvalidArgument& error) {
    refusal_ = error.what();
    return digest_of(inspect(solver_)) == before ? ""
                                                 : "a bad edit was refused, but something changed";
  }
}

void EditTrial::load(Choices& choices) {
  const auto some = [&](float size) {
    return Eigen::Vector3f(size * static_cast<float>(choices.share()), size, 0);
  };
  const auto call = [&](const auto& set) {
    set(solver_);
    if (twin_) {
      set(*twin_);
    }
  };
  switch (choices.below(4)) {
    case 0: {
      const auto vertices =
          pick_some(find_all(model_.points.size(), [](Index) { return true; }), 9, choices);
      const std::vector<Eigen::Vector3f> forces(vertices.size(), some(1e-5F));  // N
      call([&](Solver& solver) { solver.set_forces(vertices, forces); });
      for (const Index v : vertices) {
        model_.forces[v] = forces[0];
      }
      break;
    }
    case 1:
      call([](Solver& solver) { solver.clear_forces(); });
      std::ranges::fill(model_.forces, Eigen::Vector3f::Zero());
      break;
    case 2: {
      const Index body = choices.below(static_cast<Index>(model_.bodies.size()));
      model_.gravities[body] = some(9);  // m/s^2
      call([&](Solver& solver) { solver.set_gravity(body, model_.gravities[body]); });
      break;
    }
    default:
      model_.gravity = some(9);
      std::ranges::fill(model_.gravities, model_.gravity);
      call([&](Solver& solver) { solver.set_gravity(model_.gravity); });
      break;
  }
}

void EditTrial::tether(Choices& choices) {
  const SolverOptions& options = solver_.options();
  if (options.method == SolverMethod::explicit_steps ||
      options.executor.kind() == ExecutorKind::device) {
    return;
  }
  if (tethers_ != nullptr) {
    solver_.remove_constraints(*tethers_);
    if (twin_) {
      twin_->remove_constraints(*twin_tethers_);
    }
    tethers_ = twin_tethers_ = nullptr;
    return;
  }
  const auto vertices =
      pick_some(find_all(model_.points.size(), [](Index) { return true; }), 6, choices);
  const auto x = solver_.positions();
  std::vector<Tether> wanted;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Index v = vertices[i];
    const Eigen::Vector3f point = x[v] + Eigen::Vector3f(1e-3F, 2e-3F, 0);  // m
    wanted.push_back({.vertex = v, .point = point, .length = 2e-3F, .compliance = 0.5F});
    if (i > 0 && choices.below(2) == 0) {
      wanted.back().other = vertices[i - 1];
      wanted.back().length = 0.95F * (x[v] - x[vertices[i - 1]]).norm();
    }
  }
  tethers_ = std::make_shared<Tethers>(wanted);
  solver_.add_constraints(tethers_);
  if (twin_) {
    twin_tethers_ = std::make_shared<Tethers>(wanted);
    twin_->add_constraints(twin_tethers_);
  }
}

void EditTrial::touch(Choices& choices) {
  touches_.change(choices, solver_, twin_ ? &*twin_ : nullptr);
}

void EditTrial::begin_step() {
  solver_.start_step(kTimeStep);
  if (twin_) {
    twin_report_ = twin_->step(kTimeStep);
  }
}

void EditTrial::start_step() {
  begin_step();
  is_stepping_ = true;
}

std::string EditTrial::step() {
  const bool had_edits_within = std::exchange(is_stepping_, false);
  if (!had_edits_within) {
    begin_step();
  }
  const StepReport report = solver_.finish_step();
  if (report.non_finite_vertices > 0) {
    return "vertex " + std::to_string(report.first_non_finite) + " is not finite";
  }
  if (twin_) {
    const std::string name = solver_.backend_name();
    if (!equal(report, twin_report_)) {
      return name + " reports " + text_of(report) + ", its twin " + text_of(twin_report_);
    }
    if (solver_.state_hash() != twin_->state_hash()) {
      return name + " has not the state of its twin";
    }
    const std::string touched = touches_.difference(solver_, *twin_);
    if (!touched.empty()) {
      return name + ": " + touched + " than its twin";
    }
    if (had_edits_within && digest_of(inspect(solver_)) != digest_of(inspect(*twin_))) {
      return name + " has not the topology of its twin";
    }
  }
  return had_edits_within ? "" : surface_difference(solver_, surfaces_);
}

std::string EditTrial::difference() const {
  std::string wrong = testing::difference(model_, solver_);
  for (std::size_t body = 0; body < surfaces_.size() && wrong.empty(); ++body) {
    wrong = testing::difference(model_, surfaces_[body], solver_, static_cast<Index>(body));
  }
  if (wrong.empty()) {
    wrong = testing::difference(model_, pieces_);
  }
  if (wrong.empty()) {
    wrong = testing::difference(model_, strands_, solver_);
  }
  const ThermalProperties& liver = tissues::liver().heat;
  if (wrong.empty()) {
    wrong = testing::difference(model_, cautery_.field(), liver);
  }
  if (wrong.empty()) {  // the same of what comes late
    wrong = testing::difference(model_, LivePieces(solver_.tissue()));
  }
  const ThermalBody body{0, liver};
  return wrong.empty() ? testing::difference(model_, HeatField(solver_.tissue(), {&body, 1}), liver)
                       : wrong;
}

// Some changes, or a cut and perhaps more; with links to what stays, and without crumbs.
EditTrial::Change EditTrial::make_change(Choices& choices) {
  Change change;
  const bool is_cut = choices.below(8) == 0;
  if (is_cut) {
    CutPlan plan = make_cut(solver_, choices.below(2) == 0 ? CutFront{} : front_, choices);
    change = {std::move(plan.edit), std::move(plan.front)};
  }
  EditMaker maker(solver_, choices, std::move(change.edit));
  for (Index more = choices.below(2) + (is_cut ? 0 : 1); more > 0; --more) {
    maker.add();
  }
  if (choices.below(6) == 0) {
    maker.add_links();
  }
  maker.fix_some();
  change.edit = maker.edit();
  if (choices.below(6) == 0) {
    pieces_.add_crumbs(solver_.tissue(), change.edit, 1 + choices.below(8));
  }
  return change;
}

std::string run_edit_trial(std::span<const std::uint8_t> bytes, const Executor& executor,
                           bool has_touches) {
  Choices choices(bytes);
  const EditScene& scene = choices.one_of(edit_scenes());
  const std::vector<SolverOptions> all_options = edit_options(scene);
  const Index option = choices.below(static_cast<Index>(all_options.size()));
  SolverOptions options = all_options[option];
  options.executor = executor;
  options.math = MathMode::strict;
  if (options.mode == ProjectionMode::compliance && choices.below(2) == 0) {
    options.integration = TimeIntegration::bdf2;
  }
  if (executor.kind() == ExecutorKind::device) {
    options.device_strategy = choices.one_of(
        std::array{DeviceStrategy::stream, DeviceStrategy::graph, DeviceStrategy::cluster});
    const bool has_cluster = options.method == SolverMethod::projection &&
                             options.composition != PlanComposition::joint &&
                             options.coloring.max_colors == 0;
    if (options.device_strategy == DeviceStrategy::cluster && !has_cluster) {
      options.device_strategy = DeviceStrategy::automatic;
    }
  }
  EditTrial trial(scene, options, choices.below(8) == 0);
  std::string wrong;
  while (wrong.empty() && !choices.is_spent()) {
    if (!trial.is_stepping() && choices.below(4) == 0) {
      trial.start_step();
    }
    if (choices.below(6) == 0) {
      trial.load(choices);
    }
    if (!trial.is_stepping() && choices.below(8) == 0) {
      trial.tether(choices);
    }
    if (has_touches && !trial.is_stepping() && choices.below(3) == 0) {
      trial.touch(choices);
    }
    switch (choices.below(10)) {
      case 0:
        wrong = trial.try_bad_edit(choices);
        break;
      case 2:
      case 3:
        wrong = trial.edit_and_undo(choices);
        break;
      case 1:
        wrong = trial.step();
        break;
      default:
        trial.edit(choices);
        if (trial.is_stepping() ? choices.below(2) == 0 : executor.kind() != ExecutorKind::serial) {
          wrong = trial.step();
        }
    }
  }
  for (int i = trial.is_stepping() ? -1 : 0; i < 2 && wrong.empty(); ++i) {
    wrong = trial.step();
  }
  if (wrong.empty()) {
    wrong = trial.difference();
  }
  return wrong.empty() ? wrong : scene.name + ", options " + std::to_string(option) + ": " + wrong;
}

std::vector<std::uint8_t> bytes_of_trial(std::uint64_t seed) {
  constexpr std::size_t kFewest = 16, kMost = 256;
  return random_bytes(seed, kFewest + random_bits(seed, kMost) % (kMost - kFewest));
}

}  // namespace pbdsurg::testing
