// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/state/solver_data.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lib/solver/methods/fast_tools.h"
#include "lib/solver/methods/grip.h"
#include "lib/solver/methods/vertex_follower.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/solver_input.h"
#include "lib/solver/state/state_follower.h"
#include "lib/solver/state/told_contacts.h"
#include "lib/solver/substep_rule.h"

namespace pbdsurg {
namespace {

// The plan, and what the backend made of it.
class ProgramFollower final : public Follower {
 public:
  ProgramFollower(SolverData& data, const StateFollower& state) : data_(data), state_(state) {}

  void validate(const Tissue& tissue, const TopologyEdit& edit) const override {
    rule_of_edit_ = both(substep_rule(edit.new_bodies, data_.options),
                         substep_rule(tissue, edit, data_.options));
  }
  void follow(const Tissue& tissue, const TissueChange& change) noexcept override {
    rule_before_ = data_.substep_rule;
    if (is_explicit(data_.options)) {
      const SubstepRule rule = explicit_rule(data_);
      if (rule != data_.substep_rule) {
        set_substep_rule(rule, data_);
      }
    } else if (!change.edit.new_bodies.bodies().empty() || !change.edit.stiffnesses.empty() ||
               !change.edit.triangle_stiffnesses.empty() || !change.edit.fibres.empty()) {
      set_substep_rule(both(rule_before_, rule_of_edit_), data_);
    }
    const bool may_bring_stiff_links = !change.edit.new_links.empty() ||
                                       !change.edit.new_bodies.links().empty() ||
                                       !change.edit.unfix_vertices.empty();
    if (has_coarse_correction(data_.options) && may_bring_stiff_links) {
      const SubstepRule rule = both(data_.substep_rule, stiff_link_rule(tissue, data_.options));
      if (rule != data_.substep_rule) {
        set_substep_rule(rule, data_);
      }
    }
    update();
  }
  void undo(const Tissue& tissue, const TissueChange&) noexcept override {
    if (rule_before_ != data_.substep_rule) {
      set_substep_rule(rule_before_, data_);
    }
    drop_touches(tissue);
    update();
  }
  void renumber(const Tissue&, const Renumbering&) noexcept override {}

 private:
  // Of bodies and vertices that an undo took: later ones get their ids.
  void drop_touches(const Tissue& tissue) {
    const auto bodies = static_cast<Index>(tissue.bodies().size());
    const auto places = static_cast<Index>(data_.particles.size());
    const bool was_empty = data_.contact_bodies.empty();
    data_.contact_bodies.drop_bodies_from(bodies);
    for (Index i = 0; i < data_.copy_count(); ++i) {
      data_.copy(i).touches.forget_from(places, bodies);
    }
    if (data_.contact_bodies.empty() != was_empty) {
      data_.rebuild_plan();
    }
  }

  // At no cost for the plan where no phase was left without constraints and none got its first.
  void update() {
    if (data_.sets.has_other_phases() || state_.has_other_holds()) {
      data_.rebuild_plan();
    }
    data_.backend->follow_edit(data_);
  }

  SolverData& data_;
  const StateFollower& state_;
  SubstepRule rule_before_;           // before the last edit
  mutable SubstepRule rule_of_edit_;  // what it brings, as it was validated
};

// Of a part of a step. Who says how many there are gets no more.
// More substeps where tools are fast, and how many are too fast all the same.
StepDivision divide_for_tools(SolverData& data, float dt, const SubstepRule& rule) {
  const SolverOptions& options = data.options;
  StepDivision division = divide_step(dt, rule, options);
  float farthest = 0;
  for (Index i = 0; i < data.copy_count(); ++i) {
    farthest = std::max(farthest, farthest_way(data.copy(i)));
  }
  if (!is_explicit(options) && farthest > kFastWay * static_cast<float>(division.substeps)) {
    const auto most = static_cast<float>(kMostForTools * division.substeps);
    division = divide_step(dt, rule, options,
                           static_cast<int>(std::ceil(std::min(farthest / kFastWay, most))));
  }
  const bool is_any_fast = farthest > kFastWay * static_cast<float>(division.substeps);
  for (Index i = 0; i < data.copy_count(); ++i) {
    data.copy(i).fast_tools = is_any_fast ? count_fast_tools(data.copy(i), division.substeps) : 0;
  }
  return division;
}

int most_substeps(const SolverOptions& options) noexcept {
  return is_explicit(options) && options.substeps == kAutomatic ? StableSubstep::kUnseen
                                                                : std::numeric_limits<int>::max();
}

}  // namespace

struct SolverData::Followers {
  explicit Followers(SolverData& data)
      : state(data), surface(data.surface), sets(data.sets), vertices(data), program(data, state) {}

  StateFollower state;
  TissueSurface& surface;
  ConstraintSets& sets;
  VertexFollower vertices;
  ProgramFollower program;

  // In their order.
  template <class Visit>
  void for_each(Visit visit) {
    visit(state), visit(surface), visit(sets), visit(vertices), visit(program);
  }
};

SolverData::SolverData() : followers_(std::make_unique<Followers>(*this)) {
  end_step = [](SolverState& data) { end_grips(static_cast<SolverData&>(data)); };
}
SolverData::~SolverData() = default;

void SolverData::follow_tissue(SolverData* before) {
  if (options.method == SolverMethod::vertex_block) {
    free_pieces.follow(*tissue, before != nullptr ? before->free_pieces.leave() : nullptr);
  }
  followers_->for_each(
      [&](Follower& follower) { tissue->add_follower(follower, FollowerRank::solver); });
}

void SolverData::leave_tissue() noexcept {
  followers_->for_each([](Follower& follower) { follower.leave_tissue(); });
}

void SolverData::set_backend(std::unique_ptr<Backend> made) {
  backend = std::move(made);
  if (!backend->keeps_state()) {
    step_scratch.fit(*this);
  }
}

void SolverData::refresh_surfaces() {
  surface.refresh(*tissue);
  contact_bodies.refresh(*tissue, surface, place_of_vertex);
  free_pieces.refresh(*tissue, place_of_vertex);
  if (options.method == SolverMethod::vertex_block &&
      std::ranges::any_of(tools, &ToolState::has_surface)) {
    contact_firmness.refresh(*tissue, free_pieces, place_of_vertex);
  }
}

void SolverData::start_step(float dt) {
  custom.begin_step(*this);
  refresh_surfaces();
  for (Index i = 0; i < copy_count(); ++i) {
    forget_told(copy(i));
  }
  SubstepRule rule = rule_of_copies();
  if (is_explicit(options)) {
    rule.longest = static_cast<float>(stable_substep.longest(backend->stiffest(*this)));
    check_explicit_step(dt, rule, options);
  }
  part = first_part(whole_step(dt, divide_for_tools(*this, dt, rule)), most_substeps(options));
  step_length = dt;
  if (!backend->keeps_state()) {
    if (!custom.empty()) {
      custom.keep(*this);
    }
    backend->start_step(*this);
    const StepReport done = backend->finish_step(*this);
    custom.end_step(*this);
    end_grips(*this);
    report = done;
    for (Index i = 0; i < copy_count(); ++i) {
      CopyState& each = copy(i);
      std::ranges::transform(watched_places, each.watched_positions.begin(), [&](Index place) {
        const Particle& p = each.particles[place];
        return Eigen::Vector3f(p.x, p.y, p.z);
      });
    }
  } else {
    try {
      backend->start_step(*this);
    } catch (...) {  // part of it may be done: what the host has is the state
      for (Index i = 0; i < copy_count(); ++i) {
        changes.state[i] = changes.state[i] || copy(i).is_state_current;
      }
      throw;
    }
    for (Index i = 0; i < copy_count(); ++i) {
      copy(i).is_state_current = false;
    }
  }
  for (Index i = 0; i < copy_count() && has_past_lengths(options); ++i) {
    copy(i).past_substep = part.h;
  }
  step_in_flight = Step::running;
  changes.clear();
}

void SolverData::go_on(float stiffest) noexcept {
  part = part_after(part, step_length, stable_substep.longest(stiffest), most_substeps(options));
}

void SolverData::rebuild_plan() {
  plan.phases.clear();
  const bool by_vertices = moves_vertices(options);
  if (by_vertices) {
    step_scratch.reserve_holds(*this);
    for (Index color = 0; color < vertex_blocks.color_count(); ++color) {
      if (vertex_blocks.blocks(color).count > 0) {
        plan.phases.push_back({PhaseKind::vertex, color});
      }
    }
  }
  for (const Phase& phase : sets.phases) {
    if (sets.constraint_count(phase) > 0 && (!by_vertices || is_after_vertices(phase.kind))) {
      plan.phases.push_back(phase);
    }
  }
  for (Index set = 0; set < custom.count(); ++set) {
    plan.phases.push_back({PhaseKind::custom, set});
  }
  if (!contact_bodies.empty()) {  // before tools, so that nothing stays in those
    plan.phases.push_back({PhaseKind::body_contact, 0});
  }
  if (has_grips()) {
    plan.phases.push_back({PhaseKind::grip, 0});
  }
  if (by_vertices) {  // tools act within it, but for what surfaces answer after a sweep
    if (std::ranges::any_of(tools, &ToolState::has_surface)) {
      plan.phases.push_back({PhaseKind::contact, 0});
    }
    return;
  }
  // what a copy does not need does nothing there
  Index colors = 0;
  for (Index i = 0; i < copy_count(); ++i) {
    colors = std::max(colors, copy(i).attachment_colors);
  }
  for (Index color = 0; color < colors; ++color) {
    plan.phases.push_back({PhaseKind::attachment, color});
  }
  for (const bool has_surface : {false, true}) {
    for (std::size_t t = 0; t < tools.size(); ++t) {
      const auto tool = static_cast<Index>(t);
      bool pushes = false;
      for (Index i = 0; i < copy_count() && !pushes; ++i) {
        pushes = copy(i).pushes(tool) && copy(i).tools[t].has_surface() == has_surface;
      }
      if (pushes) {
        plan.phases.push_back({PhaseKind::contact, tool});
      }
    }
  }
}

void SolverData::reserve_spare_room() {
  followers_->state.reserve(static_cast<std::size_t>(options.spare.vertices));
  sets.reserve(options.spare);
  constexpr std::size_t kToolPhases = 64;
  plan.phases.reserve(sets.phases.size() + kToolPhases);
}

std::size_t SolverData::memory_bytes() const noexcept {
  return SolverState::memory_bytes() + sets.memory_bytes() + vertex_blocks.memory_bytes() +
         coarse_space.memory_bytes() + free_pieces.memory_bytes() + stable_substep.memory_bytes() +
         custom.memory_bytes() + surface.memory_bytes() + contact_firmness.memory_bytes() +
         contact_bodies.memory_bytes() + step_scratch.memory_bytes() +
         plan.phases.capacity() * sizeof(Phase) + followers_->state.memory_bytes() +
         followers_->vertices.memory_bytes() + backend->memory_bytes() +
         (own_tissue != nullptr ? own_tissue->memory_bytes() : 0);
}

}  // namespace pbdsurg
