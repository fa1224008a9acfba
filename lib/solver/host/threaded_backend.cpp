// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lib/base/executor_state.h"
#include "lib/base/step_team.h"
#include "lib/solver/host/host_backends.h"
#include "lib/solver/host/lane_kernels.h"
#include "lib/solver/host/serial_phases.h"
#include "lib/solver/host/thread_choice.h"
#include "lib/solver/host/thread_stages.h"
#include "lib/solver/methods/coarse_correction.h"
#include "lib/solver/methods/contact_stage.h"
#include "lib/solver/methods/custom_constraints.h"
#include "lib/solver/methods/eased_pieces.h"
#include "lib/solver/methods/free_pieces.h"
#include "lib/solver/methods/stiff_links.h"
#include "lib/solver/methods/stop_passing.h"
#include "lib/solver/methods/surface_contacts.h"
#include "lib/solver/methods/touch_response.h"
#include "lib/solver/methods/touch_search.h"
#include "lib/solver/methods/vertex_method.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/program/step_program.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_data.h"
#include "lib/solver/state/state_report.h"

namespace pbdsurg {
namespace {

constexpr double kLongestLimit = 1e6;  // s: beyond, a step has no limit

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
  ThreadedBackend(const LaneKernels& kernels, const LaneKernels& strict_kernels,
                  const SolverOptions& options)
      : kernels_(kernels),
        strict_kernels_(strict_kernels),
        executor_(options.executor),
        findings_(static_cast<std::size_t>(executor_.state()->most_threads())),
        name_("threaded, " + executor_.name() + ", " + kernels_.name) {
    if (executor_.state()->is_to_choose()) {
      const int most = executor_.state()->most_threads();
      choice_.emplace(options.copies > 1 ? std::min<int>(most, options.copies) : most);
    }
  }

  [[nodiscard]] const char* name() const noexcept override { return name_.c_str(); }

  void start_step(SolverData& data) override {
    report_ = {};
    data.step_scratch.fit(data);
    if (data.copy_count() > 1) {
      step_copies(data);
    } else {
      report_copy(0, step_together({data, data, data.step_scratch}), data, report_);
    }
  }
  StepReport finish_step(SolverState& /*state*/) override { return report_; }

  [[nodiscard]] float stiffest(SolverData& data) override {
    float largest = 0;
    for (Index i = 0; i < data.copy_count(); ++i) {
      largest = std::max(largest, stiffest(data, data.copy(i), 0, 1));
    }
    return largest;
  }

  [[nodiscard]] std::size_t memory_bytes() const noexcept override {
    std::size_t bytes = 0;
    for (const StepScratch& scratch : scratches_) {
      bytes += scratch.memory_bytes();
    }
    return bytes;
  }

  [[nodiscard]] Maker maker() const override {
    return [](const SolverData& data) { return make_threaded_backend(data.options); };
  }

 private:
  using Clock = std::chrono::steady_clock;
  using Seconds = std::chrono::duration<double>;

  // What a thread finds after a part of a step.
  struct alignas(128) ThreadFindings {
    Residual distances, volumes, neo_hookeans;  // after the last part
    float stiffest = 0;                         // after others: see stiffest_vertex()
  };

  // Of the copies that are a worker's first.
  struct alignas(128) HandedOut {
    std::atomic<Index> next{0};
  };

  // A thread's part in a step.
  struct Turn {
    StepContext step;
    StepTeam* team;  // with whom it shares the step; null: nobody
    ProjectionState state;
    FreeMotion<float> motion;
    float past_share;  // of BDF2, see SubstepNumbers
    VertexRange vertices;
    int thread;
    int threads;  // that share the work; 0 once another has taken over this one's part
    StepReport& report;

    [[nodiscard]] bool is_idle() const { return threads == 0; }
  };

  // One copy, by all threads that pay.
  StepReport step_together(const StepContext& step) {
    const Clock::time_point start = Clock::now();
    const int wanted = choice_ ? choice_->threads() : executor_.state()->most_threads();
    const TeamLease lease(executor_.state(), wanted);
    StepTeam* const team = lease.team();
    threads_ = team != nullptr ? std::min(wanted, team->size()) : 1;
    deadline_ = Clock::time_point::max();
    if (choice_ && choice_->limit() < kLongestLimit) {
      deadline_ = start + std::chrono::duration_cast<Clock::duration>(Seconds(choice_->limit()));
    }
    StepReport report;
    step_part(step, team, report);
    while (!step.data.part.is_last()) {
      if (deadline_ < Clock::now()) {
        threads_ = 1;
      }
      step.data.go_on(std::ranges::max(findings_, {}, &ThreadFindings::stiffest).stiffest);
      step_part(step, threads_ > 1 ? team : nullptr, report);
    }
    end_report(step, findings_, report);
    learn(lease, wanted, start);
    return report;
  }

  void step_part(const StepContext& step, StepTeam* team, StepReport& report) {
    std::ranges::fill(findings_, ThreadFindings{});
    stages_.plan(step.data, threads_);
    if (team != nullptr) {
      team->run(threads_, [&](int thread) {
        findings_[thread] = take_turn(make_turn(step, team, thread, report));
      });
    } else {
      findings_[0] = take_turn(make_turn(step, nullptr, 0, report));
    }
    drop_holds(step);
  }

  // Each by one thread: first those that it had in the last step, whose state is near it, then what
  // others have left.
  void step_copies(SolverData& data) {
    const Index copies = data.copy_count();
    const Clock::time_point start = Clock::now();
    const int most = std::min<int>(copies, executor_.state()->most_threads());
    const int wanted = choice_ ? std::min(choice_->threads(), most) : most;
    const TeamLease lease(executor_.state(), wanted);
    const int workers = lease.team() != nullptr ? std::min(wanted, lease.team()->size()) : 1;
    while (scratches_.size() + 1 < static_cast<std::size_t>(wanted)) {
      scratches_.emplace_back();
    }
    for (int w = 1; w < wanted; ++w) {  // also where the team is taken: the next step has it
      scratches_[w - 1].fit_beside(data);
    }
    threads_ = 1;
    stages_.plan(data, threads_);
    reports_.assign(static_cast<std::size_t>(copies), {});
    copy_findings_.assign(static_cast<std::size_t>(copies), {});
    while (handed_out_.size() < static_cast<std::size_t>(workers)) {
      handed_out_.emplace_back();
    }
    const auto work = [&](int worker) {
      StepScratch& scratch = worker == 0 ? data.step_scratch : scratches_[worker - 1];
      for (int other = 0; other < workers; ++other) {
        const int owner = (worker + other) % workers;
        std::atomic<Index>& next = handed_out_[owner].next;
        const Index end = part_of(copies, owner, workers).last;
        for (Index i = next.fetch_add(1); i < end; i = next.fetch_add(1)) {
          copy_findings_[i] = step_alone({data, data.copy(i), scratch, i}, reports_[i]);
        }
      }
    };
    const auto step_part = [&] {
      for (int w = 0; w < workers; ++w) {
        handed_out_[w].next = part_of(copies, w, workers).first;
      }
      if (lease.team() != nullptr) {
        lease.team()->run(workers, work);
      } else {
        work(0);
      }
    };
    step_part();
    while (!data.part.is_last()) {
      data.go_on(std::ranges::max(copy_findings_, {}, &ThreadFindings::stiffest).stiffest);
      step_part();
    }
    for (Index i = 0; i < copies; ++i) {
      report_copy(i, reports_[i], data.copy(i), report_);
    }
    learn(lease, wanted, start);
  }

  // Whoever finds the team taken has not seen what it could have done.
  void learn(const TeamLease& lease, int wanted, Clock::time_point start) {
    if (choice_ && (wanted == 1 || lease.team() != nullptr)) {
      choice_->took(Seconds(Clock::now() - start).count());
    }
  }

  ThreadFindings step_alone(const StepContext& step, StepReport& report) {
    const ThreadFindings findings = take_turn(make_turn(step, nullptr, 0, report));
    drop_holds(step);
    if (step.data.part.is_last()) {
      end_report(step, {&findings, 1}, report);
    }
    return findings;
  }

  static void end_report(const StepContext& step, std::span<const ThreadFindings> findings,
                         StepReport& report) {
    report_vertices(step.data, step.copy, report);
    report_tubes(step.data, step.copy, report);
    for (const ThreadFindings& found : findings) {
      report.distance_residual = std::max(report.distance_residual, found.distances.largest);
      report.volume_residual = std::max(report.volume_residual, found.volumes.largest);
      report.volume_residual = std::max(report.volume_residual, found.neo_hookeans.largest);
      report.inverted_tets += found.volumes.inverted + found.neo_hookeans.inverted;
    }
  }

  Turn make_turn(const StepContext& step, StepTeam* team, int thread, StepReport& report) const {
    const SolverData& data = step.data;
    const MovingVertices moving = moving_vertices(step);
    const SubstepNumbers numbers = substep_numbers(data, step.copy, data.part.h, 0);
    return {step,
            team,
            {moving.moving, moving.bases, step.copy.carries.data(), numbers.lengths, moving.points,
             moving.points == nullptr ? nullptr : step.scratch.flights.data(),
             data.vertex_blocks.unit()},
            numbers.motion,
            numbers.past_share,
            vertices_of(step, thread, threads_),
            thread,
            threads_,
            report};
  }

  // What one thread does in a part of a step. Thread 0 alone looks after tools and small phases.
  // Each thread has the same vertices in all operations, so it waits for others only where it needs
  // theirs.
  ThreadFindings take_turn(Turn turn) {
    const SolverData& data = turn.step.data;
    const ConstraintSets& sets = data.sets;
    if (turn.thread == 0 && data.part.is_first()) {
      begin_tools(turn.step.copy);
    }
    run_step(step_program(data.options, data.part.division),
             [&](StepOperation operation, int substep) { run(operation, substep, turn); });
    if (turn.thread == 0 && data.part.is_last()) {
      end_tools(turn.step.copy);
    }
    if (!turn.is_idle() && has_displacements(turn.step.data.options)) {
      meet(turn);  // all vertices have settled
    }
    if (turn.is_idle()) {
      return {};
    }
    if (!data.part.is_last()) {
      return {{}, {}, {}, stiffest(data, turn.step.copy, turn.thread, turn.threads)};
    }
    return {measure(sets.of<DistanceConstraint>(), turn),
            measure(sets.of<VolumeConstraint>(), turn),
            measure(sets.of<NeoHookeanConstraint>(), turn), 0};
  }

  // Of a thread's share of the blocks.
  [[nodiscard]] float stiffest(const SolverData& data, const CopyState& copy, int thread,
                               int threads) const {
    const VertexBlocks& vertices = data.vertex_blocks;
    const Part part = part_of(static_cast<std::size_t>(vertices.block_count()), thread, threads);
    return strict_kernels_.stiffest(vertices.rows(), copy.particles.data(), copy.velocities.data(),
                                    data.stable_substep.heading(),
                                    data.stable_substep.shares().data(), part.first, part.last);
  }

  // All threads meet; the first thread then does the rest of the step alone if that takes too long.
  void meet(Turn& turn) {
    if (turn.team == nullptr) {
      return;
    }
    if (choice_ && turn.thread == 0 && !turn.team->is_alone() &&
        deadline_ < std::chrono::steady_clock::now()) {
      turn.team->dissolve();
    }
    if (!turn.team->barrier(turn.thread)) {
      turn.threads = 0;
    } else if (turn.threads > 1 && turn.thread == 0 && turn.team->is_alone()) {
      turn.threads = 1;
      turn.vertices = vertices_of(turn.step, 0, 1);
    }
  }

  void run(StepOperation operation, int substep, Turn& turn) {
    if (turn.is_idle()) {
      return;
    }
    const StepContext& step = turn.step;
    const SolverData& data = step.data;
    const StepPart& part = data.part;
    const int thread = turn.thread;
    const Substep<float>& lengths = turn.state.substep;
    switch (operation) {
      case StepOperation::take_lengths:
        take_lengths(substep, turn);
        break;
      case StepOperation::recall_past:
        recall_past(step, turn.past_share, turn.vertices.first, turn.vertices.last);
        break;
      case StepOperation::predict_positions:
        kernels_.predict_positions(turn.vertices, turn.motion);
        break;
      case StepOperation::predict_displacements:
        kernels_.predict_displacements(turn.vertices, turn.motion);
        break;
      case StepOperation::clear_multipliers:
        data.sets.for_each_set([&]<class Constraint>(const ConstraintSlots<Constraint>& slots) {
          if constexpr (KindOf<Constraint>::kHasCompliance) {
            clear_multipliers(slots, turn);
          }
        });
        break;
      case StepOperation::find_contacts:
        meet(turn);
        if (thread == 0) {
          place_tools(step.copy, part.done_after(substep), part.done_after(substep - 1));
          find_contacts(step, lengths, turn.report);
        }
        break;
      case StepOperation::gather_holds:
        if (thread == 0) {
          gather_holds(step);
        }
        break;
      case StepOperation::damp_rows:  // all have met since the prediction: see find_contacts
        damp_rows(turn);
        break;
      case StepOperation::meet_surfaces:  // few contacts, of rows that all have damped
        if (meets_surfaces(step) || has_touches(step)) {
          meet(turn);
          if (thread == 0) {
            find_gives(vertex_state(step, lengths, 1), turn);
            begin_surface_contacts(step, vertex_state(step, lengths, 1));
            begin_touches(step, vertex_state(step, lengths, 1));
          }
        }
        break;
      case StepOperation::begin_joints:
        begin_joints(vertex_state(step, lengths, 1), turn);
        break;
      case StepOperation::sweep:
        for (int iteration = 0; iteration < part.division.sweeps; ++iteration) {
          sweep(vertex_state(
                    step, lengths,
                    relaxation_of(data.options.over_relaxation, iteration, part.division.sweeps)),
                iteration, turn);
          if (iteration == 0 && has_correction(data, part.division.sweeps)) {
            correct(vertex_state(step, lengths, 1), turn);
          }
        }
        if (!turn.is_idle()) {
          meet(turn);
        }
        break;
      case StepOperation::push:
        meet(turn);
        push_vertices(vertex_state(step, lengths, 1), turn);
        if ((meets_surfaces(step) || has_touches(step)) && !turn.is_idle()) {
          meet(turn);
          if (thread == 0) {
            push_out_of_surfaces(step);
          }
          if (!turn.is_idle()) {
            meet(turn);
          }
        }
        break;
      case StepOperation::settle_holds:  // few: all have met since the sweeps
        if (has_holds_to_settle(step) || meets_surfaces(step) || has_touches(step)) {
          if (thread == 0) {
            if (has_holds_to_settle(step)) {
              settle_holds(step, vertex_state(step, lengths, 1), lengths);
            }
            settle_touches(step);
            settle_surface_contacts(step);
          }
          meet(turn);
        }
        break;
      case StepOperation::keep_momentum:
        keep_momentum(turn);
        break;
      case StepOperation::stop_passing:
        if (may_stop(step)) {
          meet(turn);
          if (thread == 0) {
            stop_passing(step);
          }
          if (!turn.is_idle()) {
            meet(turn);
          }
        }
        break;
      case StepOperation::collect_forces:  // of thread 0, too
        if (thread == 0) {
          collect_tool_forces(step, part.force_per_multiplier(lengths.inverse_dt_squared));
          remember_contacts(step, lengths);
        }
        break;
      case StepOperation::update_velocities:
        kernels_.update_velocities(turn.vertices, turn.motion);
        break;
      case StepOperation::settle:
        kernels_.settle(turn.vertices, turn.motion);
        break;
      case StepOperation::keep_past:
        keep_past(step, turn.vertices.first, turn.vertices.last);
        break;
      case StepOperation::ease_contacts:
        ease(turn);
        break;
    }
  }

  static void take_lengths(int substep, Turn& turn) {
    const SolverData& data = turn.step.data;
    const SubstepNumbers numbers = substep_numbers(data, turn.step.copy, data.part.h, substep);
    turn.motion = numbers.motion;
    turn.state.substep = numbers.lengths;
    turn.past_share = numbers.past_share;
  }

  // Few: the first thread does it, while the others wait.
  void ease(Turn& turn) {
    if (turn.step.copy.touches.contacts.empty() &&
        std::ranges::all_of(turn.step.copy.tools, [](const ToolState& tool) {
          return tool.contacts.empty() && tool.surface_contacts.empty();
        })) {
      return;
    }
    meet(turn);
    if (turn.thread == 0) {
      ease_pieces(turn.step);
      ease_contacts(turn.step.copy, turn.step.data.part.h);
    }
    if (!turn.is_idle()) {
      meet(turn);
    }
  }

  void damp_rows(const Turn& turn) {
    const VertexBlocks& blocks = turn.step.data.vertex_blocks;
    if (blocks.has_damping()) {
      const Part part =
          part_of(static_cast<std::size_t>(blocks.block_count()), turn.thread, turn.threads);
      kernels_.damp_rows(damped_rows(turn.step), turn.state.bases, turn.state.carries,
                         turn.state.substep.inverse_dt, part.first, part.last);
    }
  }

  // All have met since what moved vertices last.
  void keep_momentum(Turn& turn) {
    const Index count = turn.step.data.free_pieces.count();
    if (count == 0) {
      return;
    }
    for (Index piece = turn.thread; piece < count; piece += turn.threads) {
      pbdsurg::keep_momentum(turn.step, piece);
    }
    meet(turn);
  }

  void begin_joints(const VertexState& vertex_state, Turn& turn) {
    const bool has_own = has_custom(turn.step);
    if (!has_stiff_links(turn.step.data.plan) && !has_own) {
      return;
    }
    meet(turn);
    if (turn.is_idle()) {
      return;
    }
    find_loose_ends(vertex_state, turn);
    begin_stiff_links(vertex_state, turn);
    if (has_own && !turn.is_idle()) {
      meet(turn);
    }
    if (has_own && turn.thread == 0) {
      begin_custom(turn.step, turn.state.substep);
    }
  }

  void begin_stiff_links(const VertexState& vertex_state, Turn& turn) {
    bool is_met = false;  // since what comes before; stages that are left out would have met
    for (const ThreadStage& stage : stages_) {
      if (stage.phase.kind != PhaseKind::stiff_link) {
        is_met = is_met && !stage.is_met_before;
        continue;
      }
      if (!is_met || stage.is_met_before) {
        meet(turn);
        is_met = true;
      }
      if (turn.is_idle()) {
        return;
      }
      do_share(stage, turn, [&](int thread, int threads) {
        if (stage.phase.serial) {
          pbdsurg::begin_joints(turn.step, vertex_state, stage.group);
        } else {
          const auto& slots = turn.step.data.sets.of<StiffLinkConstraint>();
          kernels_.begin_joints(blocks_of(slots, turn.step.scratch, stage.group, thread, threads),
                                turn.state, turn.step.scratch.link_ends());
        }
      });
    }
  }

  // In turns, as solve_vertices().
  void find_loose_ends(const VertexState& vertex_state, const Turn& turn) {
    const StepContext& step = turn.step;
    const VertexRows rows = vertex_rows(step);
    const std::vector<LaneBits>& linked = step.scratch.linked;
    for (Index block = turn.thread; block < step.data.vertex_blocks.block_count();
         block += turn.threads) {
      if (linked[block] != 0) {
        damp_volumes(turn, block);
        const LaneBits left = kernels_.find_loose_ends(rows, vertex_state, step.scratch.link_ends(),
                                                       block, linked[block]);
        pbdsurg::find_loose_ends(step, vertex_state, block,
                                 left | (linked[block] & step.scratch.held[block]));
      }
    }
    if (turn.thread == 0) {
      find_lone_ends(step, vertex_state);
    }
  }

  void sweep(const VertexState& vertex_state, int iteration, Turn& turn) {
    for (const ThreadStage& stage : stages_) {
      if (stage.is_met_before && !turn.is_idle()) {
        meet(turn);
      }
      if (turn.is_idle()) {
        return;
      }
      do_share(stage, turn, [&](int thread, int threads) {
        if (stage.phase.kind == PhaseKind::vertex) {
          solve_vertices(turn, vertex_state, stage, thread, threads);
        } else if (stage.phase.kind == PhaseKind::custom) {
          project_custom(turn.step, stage.phase.color, turn.state.substep, iteration);
        } else {
          project(turn, stage, thread, threads);
        }
      });
    }
  }

  // See coarse_correction.h; all meet before each stage, and at the end.
  void correct(VertexState state, Turn& turn) {
    const StepContext& step = turn.step;
    const auto stage = [&](Index count, const auto& work) {
      if (!turn.is_idle()) {
        meet(turn);
      }
      for (Index i = turn.thread; !turn.is_idle() && i < count; i += turn.threads) {
        work(i);
      }
    };
    if (has_custom(step)) {
      stage(1, [&](Index) { leave_out_pushed(step); });
      state.left_out = step.scratch.coarse.left_out.data();
    }
    const auto find_residuals = [&] {
      const VertexRows rows = vertex_rows(step);
      stage(step.data.vertex_blocks.block_count(), [&](Index block) {
        kernels_.find_residuals(rows, state, block, step.scratch.coarse.residuals.data());
      });
    };
    find_residuals();
    const Index nodes = step.data.coarse_space.node_count();
    stage(nodes, [&](Index node) { project_residuals(step, node); });
    stage(1, [&](Index) { solve_coarse(step, state.inverse_dt_squared); });
    const auto displace = [&](Index part) {
      VertexRange range = turn.vertices;
      const auto [first, last] = coarse_part(step, part);
      range.first = first;
      range.last = last;
      kernels_.displace(range, step.scratch.coarse.moves.data());
    };
    stage(kCoarseParts, [&](Index part) {
      find_moves(step, part);
      displace(part);
    });
    find_residuals();
    stage(nodes, [&](Index node) { weigh_moves(step, node); });
    stage(kCoarseParts, [&](Index part) {
      if (turn_back_moves(step, part)) {
        displace(part);
      }
    });
    if (has_touches(step)) {
      stage(1, [&](Index) { see_touches(step); });
    }
    if (!turn.is_idle()) {
      meet(turn);
    }
  }

  // Calls work(thread, threads) with a thread's share of a stage, if it has any.
  template <class Work>
  static void do_share(const ThreadStage& stage, const Turn& turn, const Work& work) {
    if (stage.owner == kEverybody) {
      work(turn.thread, turn.threads);
    } else if (stage.owner == turn.thread || turn.threads == 1) {
      work(0, 1);
    }
  }

  void project(const Turn& turn, const ThreadStage& stage, int thread, int threads) {
    if (stage.phase.serial) {
      project_serially(turn.step, stage.phase, turn.state.substep);
      return;
    }
    bool is_elastic = false;
    turn.step.data.sets.visit_set(stage.phase.kind, [&](const auto& slots) {
      is_elastic = true;
      project_group(turn, slots, stage.group, thread, threads);
    });
    if (!is_elastic) {
      project_serially(turn.step, stage.phase, turn.state.substep);
    }
  }

  // The last blocks are the longest, as of a colour.
  void push_vertices(const VertexState& state, Turn& turn) {
    if (turn.is_idle()) {
      return;
    }
    const StepContext& step = turn.step;
    const VertexRows rows = vertex_rows(step);
    const Index count = step.data.vertex_blocks.block_count();
    for (Index block = turn.thread; block < count; block += turn.threads) {
      const LaneBits left = kernels_.push_vertices(rows, state, block);
      if (left != 0) {
        push_lanes(step, state, block, left);
      }
    }
    meet(turn);
  }

  // Blocks of a colour get longer towards its end, so the threads take turns.
  void solve_vertices(const Turn& turn, const VertexState& state, const ThreadStage& stage,
                      int thread, int threads) {
    const StepContext& step = turn.step;
    const VertexRows rows = vertex_rows(step);
    const auto [first, count] = step.data.vertex_blocks.blocks(stage.group);
    for (Index block = first + thread; block < first + count; block += threads) {
      EnergyBlock energies;
      const LaneBits left = kernels_.solve_vertices(rows, state, block, energies);
      if (left != 0) {
        damp_volumes(turn, block);
        solve_lanes(step, state, block, left, &energies);
      }
    }
  }

  void damp_volumes(const Turn& turn, Index block) {
    if (turn.step.data.vertex_blocks.has_damping() && kernels_.damp_volumes != nullptr) {
      kernels_.damp_volumes(damped_rows(turn.step), turn.state.bases, turn.state.carries,
                            turn.state.substep.inverse_dt, block);
    }
  }

  // Whether tools hold a vertex, or only touch it.
  static bool is_grasped(const StepScratch& scratch, Index first_hold) {
    bool is_grasped = false;
    for (Index h = first_hold; h != kInvalidIndex; h = scratch.holds[h].next) {
      const HoldKind kind = scratch.holds[h].kind;
      is_grasped |= kind == HoldKind::grasp || kind == HoldKind::grip;
    }
    return is_grasped;
  }

  // How what is held yields, before contacts ask: yield_of() finds what registers cannot, as what a
  // tool grasps.
  void find_gives(const VertexState& vertex_state, const Turn& turn) {
    const StepContext& step = turn.step;
    StepScratch& scratch = step.scratch;
    const VertexRows rows = vertex_rows(step);
    const bool has_room = scratch.end_gives.size() == step.copy.particles.size();
    for (Index block = 0; block < step.data.vertex_blocks.block_count(); ++block) {
      const LaneBits held = scratch.held[block];
      if (held == 0) {
        continue;
      }
      damp_volumes(turn, block);
      if (!has_room) {
        continue;
      }
      const LaneBits found =
          held & ~kernels_.find_loose_ends(rows, vertex_state, scratch.link_ends(), block, held);
      for (Index lane = 0; lane < rows.blocks[block].lane_count; ++lane) {
        const ParticleOffset corner = rows.blocks[block].corners[lane];
        const Index first = scratch.first_holds[place_at(corner)];
        if ((found >> lane & 1) != 0 && first != kInvalidIndex && !is_grasped(scratch, first)) {
          scratch.gives[first] = {load_end(scratch.link_ends(), corner).give, true};
        }
      }
    }
  }

  template <class Constraint>
  void project_group(const Turn& turn, const ConstraintSlots<Constraint>& slots, Index group,
                     int thread, int threads) {
    const SolverData& data = turn.step.data;
    const ProjectionState& state = turn.state;
    const BlockRange<Constraint> range =
        blocks_of(slots, turn.step.scratch, group, thread, threads);
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
  Residual measure(const ConstraintSlots<Constraint>& slots, const Turn& turn) {
    const ConstraintKernels<Constraint>& kernels = kernels_;
    Residual sum;
    for (Index group = 0; group < slots.group_count(); ++group) {
      const Residual residual =
          kernels.measure(blocks_of(slots, turn.step.scratch, group, turn.thread, turn.threads),
                          turn.step.copy.particles.data());
      sum.largest = std::max(sum.largest, residual.largest);
      sum.inverted += residual.inverted;
    }
    return sum;
  }

  template <class Constraint>
  void clear_multipliers(const ConstraintSlots<Constraint>& slots, const Turn& turn) {
    for (Index group = 0; group < slots.group_count(); ++group) {
      const BlockRange<Constraint> range =
          blocks_of(slots, turn.step.scratch, group, turn.thread, turn.threads);
      std::fill(range.multipliers + range.first, range.multipliers + range.last,
                MultiplierBlock<Constraint>{});
    }
  }

  template <class Constraint>
  static BlockRange<Constraint> blocks_of(const ConstraintSlots<Constraint>& slots,
                                          StepScratch& scratch, Index group, int thread,
                                          int threads) {
    const auto blocks = slots.blocks(group);
    const Part part = part_of(blocks.size(), thread, threads);
    return {blocks.data(), scratch.multipliers.of<Constraint>()[group].data(), slots.size(group),
            part.first, part.last};
  }

  // Cut at multiples of a block, as the kernels want it.
  [[nodiscard]] static VertexRange vertices_of(const StepContext& step, int thread, int threads) {
    CopyState& copy = step.copy;
    const auto count = static_cast<Index>(copy.particles.size());
    const Part part =
        part_of((copy.particles.size() + kBlockLanes - 1) / kBlockLanes, thread, threads);
    StepScratch& scratch = step.scratch;
    const bool has_flights = moves_vertices(step.data.options);
    return {copy.particles.data(),
            scratch.previous.data(),
            scratch.displacements.data(),
            has_flights ? scratch.flights.data() : nullptr,
            has_flights ? scratch.fixed_points.data() : nullptr,
            is_explicit(step.data.options),
            step.data.vertex_blocks.unit(),
            copy.velocities.data(),
            copy.carries.data(),
            copy.forces.empty() ? nullptr : copy.forces.data(),
            step.data.gravities.empty() ? nullptr : step.data.gravities.data(),
            std::min(count, part.first * kBlockLanes),
            std::min(count, part.last * kBlockLanes)};
  }

  const LaneKernels& kernels_;
  const LaneKernels& strict_kernels_;
  Executor executor_;
  std::optional<ThreadChoice> choice_;              // where nobody said how many
  int threads_ = 1;                                 // that begin a step
  std::chrono::steady_clock::time_point deadline_;  // from which one of them goes on alone
  ThreadStages stages_;
  std::vector<ThreadFindings> findings_;       // [thread]
  std::deque<HandedOut> handed_out_;           // [worker]
  std::vector<StepScratch> scratches_;         // of workers on copies, beside the first
  std::vector<StepReport> reports_;            // [copy]
  std::vector<ThreadFindings> copy_findings_;  // [copy]
  StepReport report_;
  std::string name_;
};

}  // namespace

std::unique_ptr<Backend> make_threaded_backend(const SolverOptions& options) {
  const LaneKernels* kernels = choose_lane_kernels(options.math == MathMode::fast);
  return kernels == nullptr
             ? nullptr
             : std::make_unique<ThreadedBackend>(*kernels, *choose_lane_kernels(false), options);
}

}  // namespace pbdsurg
