// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/host/serial_step.h"

#include <algorithm>
#include <ranges>

#include "lib/solver/host/serial_phases.h"
#include "lib/solver/methods/coarse_correction.h"
#include "lib/solver/methods/contact_stage.h"
#include "lib/solver/methods/custom_constraints.h"
#include "lib/solver/methods/eased_pieces.h"
#include "lib/solver/methods/free_pieces.h"
#include "lib/solver/methods/stiff_links.h"
#include "lib/solver/methods/stop_passing.h"
#include "lib/solver/methods/surface_contacts.h"
#include "lib/solver/methods/touch_response.h"
#include "lib/solver/methods/vertex_method.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/program/step_program.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_data.h"
#include "lib/solver/state/state_report.h"

namespace pbdsurg {
namespace {

// What each operation of a step means.
class SerialStep {
 public:
  SerialStep(const StepContext& step, StepReport& report)
      : step_(step),
        part_(step.data.part),
        numbers_(substep_numbers(step.data, step.copy, part_.h, 0)),
        report_(report) {}

  void run() {
    if (part_.is_first()) {
      begin_tools(step_.copy);
    }
    run_step(step_program(step_.data.options, part_.division),
             [&](StepOperation operation, int substep) { run(operation, substep); });
    drop_holds(step_);
    if (!part_.is_last()) {
      return;
    }
    end_tools(step_.copy);
    report_vertices(step_.data, step_.copy, report_);
    report_constraints(step_.data, step_.copy, report_);
    report_tubes(step_.data, step_.copy, report_);
  }

 private:
  void run(StepOperation operation, int substep) {
    const auto vertex_count = static_cast<Index>(step_.copy.particles.size());
    switch (operation) {
      case StepOperation::take_lengths:
        numbers_ = substep_numbers(step_.data, step_.copy, part_.h, substep);
        break;
      case StepOperation::recall_past:
        recall_past(step_, numbers_.past_share, 0, vertex_count);
        break;
      case StepOperation::predict_positions:
        predict_positions(step_, numbers_.motion);
        break;
      case StepOperation::predict_displacements:
        predict_displacements(step_, numbers_.motion);
        break;
      case StepOperation::clear_multipliers:
        step_.scratch.multipliers.for_each([](auto& groups) {
          for (auto& blocks : groups) {
            std::ranges::fill(blocks, std::ranges::range_value_t<decltype(blocks)>{});
          }
        });
        break;
      case StepOperation::find_contacts:
        place_tools(step_.copy, part_.done_after(substep), part_.done_after(substep - 1));
        find_contacts(step_, numbers_.lengths, report_);
        break;
      case StepOperation::gather_holds:
        gather_holds(step_);
        break;
      case StepOperation::damp_rows:
        damp_rows(step_, numbers_.lengths.inverse_dt);
        break;
      case StepOperation::meet_surfaces:
        begin_surface_contacts(step_, vertex_state(step_, numbers_.lengths, 1));
        begin_touches(step_, vertex_state(step_, numbers_.lengths, 1));
        break;
      case StepOperation::begin_joints:
        begin_joints();
        break;
      case StepOperation::sweep:
        for (int iteration = 0; iteration < part_.division.sweeps; ++iteration) {
          sweep(iteration);
          if (iteration == 0 && has_correction(step_.data, part_.division.sweeps)) {
            correct();
            see_touches(step_);
          }
        }
        break;
      case StepOperation::push:
        push_vertices(step_, vertex_state(step_, numbers_.lengths, 1));
        push_out_of_surfaces(step_);
        break;
      case StepOperation::settle_holds:
        if (has_holds_to_settle(step_)) {
          settle_holds(step_, vertex_state(step_, numbers_.lengths, 1), numbers_.lengths);
        }
        settle_touches(step_);
        settle_surface_contacts(step_);
        break;
      case StepOperation::keep_momentum:
        for (Index piece = 0; piece < step_.data.free_pieces.count(); ++piece) {
          keep_momentum(step_, piece);
        }
        break;
      case StepOperation::stop_passing:
        stop_passing(step_);
        break;
      case StepOperation::collect_forces:
        collect_tool_forces(step_, part_.force_per_multiplier(numbers_.lengths.inverse_dt_squared));
        remember_contacts(step_, numbers_.lengths);
        break;
      case StepOperation::update_velocities:
        update_velocities(step_, numbers_.motion);
        break;
      case StepOperation::settle:
        settle_vertices(step_, numbers_.motion);
        break;
      case StepOperation::keep_past:
        keep_past(step_, 0, vertex_count);
        break;
      case StepOperation::ease_contacts:
        ease_pieces(step_);
        ease_contacts(step_.copy, part_.h);
        break;
    }
  }

  void begin_joints() {
    if (!has_stiff_links(step_.data.plan) && !has_custom(step_)) {
      return;
    }
    const VertexState state = vertex_state(step_, numbers_.lengths, 1);
    for (Index block = 0; block < step_.data.vertex_blocks.block_count(); ++block) {
      find_loose_ends(step_, state, block, step_.scratch.linked[block]);
    }
    find_lone_ends(step_, state);
    for (const Phase& phase : step_.data.plan.phases) {
      if (phase.kind == PhaseKind::stiff_link) {
        pbdsurg::begin_joints(step_, state, phase.color);
      }
    }
    begin_custom(step_, numbers_.lengths);
  }

  void correct() {
    VertexState state = vertex_state(step_, numbers_.lengths, 1);
    if (has_custom(step_)) {
      leave_out_pushed(step_);
      state.left_out = step_.scratch.coarse.left_out.data();
    }
    const auto find_all_residuals = [&] {
      for (Index block = 0; block < step_.data.vertex_blocks.block_count(); ++block) {
        find_residuals(step_, state, block);
      }
    };
    const auto for_each_part = [&](const auto& work) {
      for (Index part = 0; part < kCoarseParts; ++part) {
        work(part);
      }
    };
    const auto for_each_node = [&](const auto& work) {
      for (Index node = 0; node < step_.data.coarse_space.node_count(); ++node) {
        work(node);
      }
    };
    find_all_residuals();
    for_each_node([&](Index node) { project_residuals(step_, node); });
    solve_coarse(step_, state.inverse_dt_squared);
    for_each_part([&](Index part) {
      find_moves(step_, part);
      displace(step_, state, part);
    });
    find_all_residuals();
    for_each_node([&](Index node) { weigh_moves(step_, node); });
    for_each_part([&](Index part) {
      if (turn_back_moves(step_, part)) {
        displace(step_, state, part);
      }
    });
  }

  void sweep(int iteration) {
    const VertexState state = vertex_state(
        step_, numbers_.lengths,
        relaxation_of(step_.data.options.over_relaxation, iteration, part_.division.sweeps));
    for (const Phase& phase : step_.data.plan.phases) {
      if (phase.kind == PhaseKind::vertex) {
        solve_vertices(step_, state, phase.color);
      } else if (phase.kind == PhaseKind::custom) {
        project_custom(step_, phase.color, numbers_.lengths, iteration);
      } else {
        project_serially(step_, phase, numbers_.lengths);
      }
    }
  }

  StepContext step_;
  const StepPart& part_;
  SubstepNumbers numbers_;
  StepReport& report_;
};

}  // namespace

void step_serially(const StepContext& step, StepReport& report) {
  SerialStep(step, report).run();
}

}  // namespace pbdsurg
