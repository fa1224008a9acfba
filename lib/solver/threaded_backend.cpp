// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "core/executor_state.h"
#include "core/step_team.h"
#include "solver/contact_stage.h"
#include "solver/host_backends.h"
#include "solver/lane_kernels.h"
#include "solver/load_store.h"
#include "solver/serial_phases.h"
#include "solver/solver_data.h"
#include "solver/state_report.h"
#include "solver/step_program.h"
#include "solver/thread_choice.h"
#include "solver/vertex_method.h"

namespace pbdsurg {
namespace {

/// Whose work a stage is, if it is not one thread's.
constexpr int kEverybody = -1;

constexpr double kLongestLimit = 1e6;  // s: beyond, a step has no limit

struct Stage {
  Phase phase;
  Index group;         // of the constraints that it projects
  int owner;           // a thread, or kEverybody, who share it
  bool is_met_before;  // whether the threads meet before it
};

/// Blocks and vertices [first, last) of one thread.
struct Part {
  Index first, last;
};

Part part_of(std::size_t count, int thread, int threads) {
  return {static_cast<Index>(count * thread / threads),
          static_cast<Index>(count * (thread + 1) / threads)};
}

class ThreadedBackend final : public Backend {
 public:
  ThreadedBackend(const LaneKernels& kernels, const SolverOptions& options)
      : kernels_(kernels),
        executor_(options.executor),
        residuals_(static_cast<std::size_t>(executor_.state()->most_threads())),
        name_("threaded, " + executor_.name() + ", " + kernels_.name) {
    if (executor_.state()->is_to_choose()) {
      choice_.emplace(executor_.state()->most_threads());
    }
  }

  [[nodiscard]] const char* name() const noexcept override { return name_.c_str(); }

  void start_step(SolverData& data, float dt) override { report_ = step(data, dt); }
  StepReport finish_step(SolverState& /*state*/) override { return report_; }

  [[nodiscard]] Maker maker() const override {
    return [](const SolverData& data) { return make_threaded_backend(data.options); };
  }

 private:
  struct alignas(128) ThreadResidual {
    Residual distances, volumes, neo_hookeans;
  };

  // A thread's part in a step.
  struct Turn {
    ProjectionState state;
    Prediction prediction;
    VertexRange vertices;
    int thread;
    int threads;  // that share the work; 0 once another has taken over this one's part

    [[nodiscard]] bool is_idle() const { return threads == 0; }
  };

  StepReport step(SolverData& data, float dt) {
    using Clock = std::chrono::steady_clock;
    using Seconds = std::chrono::duration<double>;
    const Clock::time_point start = Clock::now();
    const int wanted = choice_ ? choice_->threads() : executor_.state()->most_threads();
    const TeamLease lease(executor_.state(), wanted);
    team_ = lease.team() != nullptr ? lease.team() : &alone_;
    threads_ = std::min(wanted, team_->size());
    deadline_ = Clock::time_point::max();
    if (choice_ && choice_->limit() < kLongestLimit) {
      deadline_ = start + std::chrono::duration_cast<Clock::duration>(Seconds(choice_->limit()));
    }
    std::ranges::fill(residuals_, ThreadResidual{});
    plan_stages(data);
    StepReport report;
    team_->run(threads_, [&](int thread) { step(data, dt, thread, report); });
    report_vertices(data, report);
    report_tubes(data, report);
    for (const ThreadResidual& residual : residuals_) {
      report.distance_residual = std::max(report.distance_residual, residual.distances.largest);
      report.volume_residual = std::max(report.volume_residual, residual.volumes.largest);
      report.volume_residual = std::max(report.volume_residual, residual.neo_hookeans.largest);
      report.inverted_tets += residual.volumes.inverted + residual.neo_hookeans.inverted;
    }
    if (choice_ && threads_ == wanted) {
      choice_->took(Seconds(Clock::now() - start).count());
    }
    return report;
  }

  // What one thread does in a step. Thread 0 alone looks after tools and small phases. Each thread
  // has the same vertices in all operations, so it waits for others only where it needs theirs.
  void step(SolverData& data, float dt, int thread, StepReport& report) {
    const float h = dt / static_cast<float>(data.options.substeps);
    Turn turn{{data.particles.data(), data.previous.data(), {1 / h, 1 / (h * h)}},
              {h, 1 / (1 + data.options.damping * h), h * load(data.gravity)},
              vertices_of(data, thread, threads_),
              thread,
              threads_};
    if (thread == 0) {
      begin_tools(data);
    }
    run_step(step_program(data.options), [&](StepOperation operation, int substep) {
      run(operation, substep, data, turn, report);
    });
    if (thread == 0) {
      end_tools(data);
    }
    if (!turn.is_idle()) {
      residuals_[thread] = {measure(data, data.sets.of<DistanceConstraint>(), turn),
                            measure(data, data.sets.of<VolumeConstraint>(), turn),
                            measure(data, data.sets.of<NeoHookeanConstraint>(), turn)};
    }
  }

  // All threads meet; the first thread then does the rest of the step alone if that takes too long.
  void meet(SolverData& data, Turn& turn) {
    if (choice_ && turn.thread == 0 && !team_->is_alone() &&
        deadline_ < std::chrono::steady_clock::now()) {
      team_->dissolve();
    }
    if (!team_->barrier(turn.thread)) {
      turn.threads = 0;
    } else if (turn.threads > 1 && turn.thread == 0 && team_->is_alone()) {
      turn.threads = 1;
      turn.vertices = vertices_of(data, 0, 1);
    }
  }

  void run(StepOperation operation, int substep, SolverData& data, Turn& turn, StepReport& report) {
    if (turn.is_idle()) {
      return;
    }
    const auto substeps = static_cast<float>(data.options.substeps);
    const int thread = turn.thread;
    const Substep<float>& lengths = turn.state.substep;
    switch (operation) {
      case StepOperation::predict:
        kernels_.predict(turn.vertices, turn.prediction);
        break;
      case StepOperation::extrapolate:
        kernels_.extrapolate(falling_range(data, turn), way_of_fall(data, lengths));
        break;
      case StepOperation::clear_multipliers:
        data.sets.for_each_set([&]<class Constraint>(ConstraintSlots<Constraint>& slots) {
          if constexpr (KindOf<Constraint>::kHasCompliance) {
            clear_multipliers(slots, turn);
          }
        });
        break;
      case StepOperation::find_contacts:
        meet(data, turn);
        if (thread == 0) {
          place_tools(data, static_cast<float>(substep + 1) / substeps);
          find_contacts(data, report);
        }
        break;
      case StepOperation::gather_holds:
        if (thread == 0) {
          gather_holds(data);
        }
        break;
      case StepOperation::damp_rows:  // all have met since the prediction: see find_contacts
        damp_rows(data, turn);
        break;
      case StepOperation::sweep:
        for (int iteration = 0; iteration < data.options.iterations; ++iteration) {
          sweep(data, vertex_state(data, lengths, relaxation_of(data.options, iteration)), turn);
        }
        if (!turn.is_idle()) {
          meet(data, turn);
        }
        break;
      case StepOperation::collect_forces:  // all have met since the sweeps
        if (thread == 0) {
          collect_tool_forces(data, lengths.inverse_dt_squared / substeps);
        }
        break;
      case StepOperation::measure_fall:
        kernels_.measure_fall(falling_range(data, turn), gravity_per_square(data),
                              lengths.inverse_dt);
        break;
      case StepOperation::update_velocities:
        kernels_.update_velocities(turn.vertices, lengths.inverse_dt);
        break;
    }
  }

  void damp_rows(SolverData& data, const Turn& turn) {
    VertexBlocks& blocks = data.vertex_method.blocks;
    if (blocks.has_damping()) {
      const Part part =
          part_of(static_cast<std::size_t>(blocks.block_count()), turn.thread, turn.threads);
      kernels_.add_damping(blocks.damped_rows(), data.previous.data(),
                           turn.state.substep.inverse_dt, part.first, part.last);
    }
  }

  void sweep(SolverData& data, const VertexState& vertex_state, Turn& turn) {
    for (const Stage& stage : stages_) {
      if (stage.is_met_before && !turn.is_idle()) {
        meet(data, turn);
      }
      if (turn.is_idle()) {
        return;
      }
      const bool is_shared = stage.owner == kEverybody;
      if (!is_shared && stage.owner != turn.thread && turn.threads > 1) {
        continue;
      }
      const int thread = is_shared ? turn.thread : 0, threads = is_shared ? turn.threads : 1;
      if (stage.phase.kind == PhaseKind::vertex) {
        solve_vertices(data, vertex_state, stage, thread, threads);
      } else {
        project(data, stage, turn.state, thread, threads);
      }
    }
  }

  void project(SolverData& data, const Stage& stage, const ProjectionState& state, int thread,
               int threads) {
    if (stage.phase.serial) {
      project_serially(data, stage.phase, state.substep);
      return;
    }
    bool is_elastic = false;
    data.sets.visit_set(stage.phase.kind, [&](auto& slots) {
      is_elastic = true;
      project_group(data, slots, stage.group, state, thread, threads);
    });
    if (!is_elastic) {
      project_serially(data, stage.phase, state.substep);
    }
  }

  // Blocks of a colour get longer towards its end, so the threads take turns.
  void solve_vertices(SolverData& data, const VertexState& state, const Stage& stage, int thread,
                      int threads) {
    const VertexRows rows = data.vertex_method.blocks.rows();
    const auto [first, count] = data.vertex_method.blocks.blocks(stage.group);
    for (Index block = first + thread; block < first + count; block += threads) {
      const LaneBits left = kernels_.solve_vertices(rows, state, block);
      if (left != 0) {
        solve_lanes(data, state, block, left);
      }
    }
  }

  template <class Constraint>
  void project_group(SolverData& data, ConstraintSlots<Constraint>& slots, Index group,
                     const ProjectionState& state, int thread, int threads) {
    const BlockRange<Constraint> range = blocks_of(slots, group, thread, threads);
    const ConstraintKernels<Constraint>& kernels = kernels_;
    if (data.options.mode == ProjectionMode::fraction) {
      kernels.project_fraction(range, state);
    } else if (data.sets.has_damping) {
      kernels.project_damped(range, state);
    } else {
      kernels.project_compliance(range, state);
    }
  }

  template <class Constraint>
  Residual measure(SolverData& data, ConstraintSlots<Constraint>& slots, const Turn& turn) {
    const ConstraintKernels<Constraint>& kernels = kernels_;
    Residual sum;
    for (Index group = 0; group < slots.group_count(); ++group) {
      const Residual residual = kernels.measure(blocks_of(slots, group, turn.thread, turn.threads),
                                                data.particles.data());
      sum.largest = std::max(sum.largest, residual.largest);
      sum.inverted += residual.inverted;
    }
    return sum;
  }

  template <class Constraint>
  void clear_multipliers(ConstraintSlots<Constraint>& slots, const Turn& turn) {
    for (Index group = 0; group < slots.group_count(); ++group) {
      const BlockRange<Constraint> range = blocks_of(slots, group, turn.thread, turn.threads);
      std::fill(range.multipliers + range.first, range.multipliers + range.last,
                MultiplierBlock<Constraint>{});
    }
  }

  template <class Constraint>
  static BlockRange<Constraint> blocks_of(ConstraintSlots<Constraint>& slots, Index group,
                                          int thread, int threads) {
    const auto blocks = slots.blocks(group);
    const Part part = part_of(blocks.size(), thread, threads);
    return {blocks.data(), slots.multipliers(group).data(), slots.size(group), part.first,
            part.last};
  }

  static FallingRange falling_range(SolverData& data, const Turn& turn) {
    return {turn.vertices, data.vertex_method.flights.data(), data.falling.data()};
  }

  // Cut at multiples of a block, as the kernels want it.
  [[nodiscard]] static VertexRange vertices_of(SolverData& data, int thread, int threads) {
    const auto count = static_cast<Index>(data.particles.size());
    const Part part =
        part_of((data.particles.size() + kBlockLanes - 1) / kBlockLanes, thread, threads);
    return {data.particles.data(), data.previous.data(), data.velocities.data(),
            std::min(count, part.first * kBlockLanes), std::min(count, part.last * kBlockLanes)};
  }

  // Phases that take less time than a meeting of the threads are left to thread 0, one after
  // another without meetings between them. Of a nested plan, a domain is one thread's.
  void plan_stages(SolverData& data) {
    stages_.clear();
    // any of the phases may come with an edit
    const std::size_t stages_of_phase = data.options.composition == PlanComposition::joint ? 7 : 1;
    stages_.reserve(stages_of_phase * data.plan.phases.capacity());
    for (const Phase& phase : data.plan.phases) {
      switch (phase.kind) {
        case PhaseKind::distance:
        case PhaseKind::volume:
        case PhaseKind::neo_hookean:
        case PhaseKind::strain_limit:
        case PhaseKind::bending:
          data.sets.visit_set(
              phase.kind, [&](const auto& slots) { add_stage(data, phase, slots, phase.color); });
          break;
        case PhaseKind::joint:
          if (phase.serial) {
            add_stage(phase, phase.color, 0);
            break;
          }
          for (Index place = 0; place < 6; ++place) {
            add_stage(data, {PhaseKind::distance, phase.color}, data.sets.of<DistanceConstraint>(),
                      data.sets.joint_group(phase.color, place));
          }
          add_stage(data, {PhaseKind::volume, phase.color}, data.sets.of<VolumeConstraint>(),
                    phase.color);
          break;
        case PhaseKind::vertex:  // a block takes several times as long as a meeting
          add_stage(phase, phase.color,
                    data.vertex_method.blocks.blocks(phase.color).count > 1 ? kEverybody : 0);
          break;
        case PhaseKind::attachment:
        case PhaseKind::contact:
          add_stage(phase, phase.color, 0);
          break;
      }
    }
  }

  template <class Constraint>
  void add_stage(const SolverData& data, const Phase& phase,
                 const ConstraintSlots<Constraint>& slots, Index group) {
    const Index domains = data.sets.domain_counts[phase.level];
    if (domains > 1) {
      const auto owner =
          static_cast<int>(std::min<Index>(domains, threads_) * phase.domain / domains);
      const bool follows_level = !stages_.empty() && stages_.back().phase.level == phase.level &&
                                 stages_.back().phase.kind != PhaseKind::vertex;
      stages_.push_back({phase, group, owner, !follows_level});
      return;
    }
    // in the time that sixteen distances take, some 20 ns
    constexpr Index kBlockCost = std::is_same_v<Constraint, NeoHookeanConstraint> ? 6
                                 : std::is_same_v<Constraint, BendingConstraint>
                                     ? 5
                                     : Constraint::kVertexCount / 2;
    constexpr Index kMeetingCost = 8;
    const Index saved =
        kBlockCost * static_cast<Index>(slots.blocks(group).size()) * (threads_ - 1) / threads_;
    add_stage(phase, group, !phase.serial && saved > kMeetingCost ? kEverybody : 0);
  }

  void add_stage(const Phase& phase, Index group, int owner) {
    const bool follows_own =
        !stages_.empty() && stages_.back().owner == owner && owner != kEverybody;
    // in the next sweep, what comes first follows what came last
    stages_.push_back({phase, group, owner, !follows_own});
  }

  const LaneKernels& kernels_;
  Executor executor_;
  StepTeam alone_{1};
  StepTeam* team_ = &alone_;                        // of this step
  std::optional<ThreadChoice> choice_;              // where nobody said how many
  int threads_ = 1;                                 // that begin a step
  std::chrono::steady_clock::time_point deadline_;  // from which one of them goes on alone
  std::vector<Stage> stages_;
  std::vector<ThreadResidual> residuals_;  // [thread]
  StepReport report_;
  std::string name_;
};

}  // namespace

std::unique_ptr<Backend> make_threaded_backend(const SolverOptions& options) {
  const LaneKernels* kernels = choose_lane_kernels(options.math == MathMode::fast);
  return kernels == nullptr ? nullptr : std::make_unique<ThreadedBackend>(*kernels, options);
}

}  // namespace pbdsurg
