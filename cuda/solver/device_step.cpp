// SPDX-License-Identifier: Apache-2.0
#include "cuda/solver/device_step.h"

#include "cuda/solver/side_stream.h"
#include "lib/solver/methods/surface_contacts.h"

namespace pbdsurg::cuda {
namespace {

class Enqueuer {
 public:
  Enqueuer(const DeviceStep& step, Sweeps& sweeps, const Launch& launch)
      : step_(step),
        sweeps_(sweeps),
        launch_(launch),
        ends_apart_(step.changes_lengths || (step.arrays.state.ways != nullptr &&
                                             (step.arrays.has_pushers || step.arrays.has_meeters ||
                                              step.arrays.has_touches))) {}

  void run(StepOperation operation, Index substep) {
    const auto& [state, constraints, tools, input, stages, has_pushers, has_attachments,
                 has_meeters, has_grips, has_touches, vertices, sweep_count, has_stiff_links,
                 free_pieces, coarse, stages_revision, fillings, fillings_revision] = step_.arrays;
    const StepKernels& kernels = *step_.kernels;
    const bool has_tools = step_.arrays.has_tools();
    switch (operation) {
      case StepOperation::predict_positions:
      case StepOperation::predict_displacements: {
        Launch launch = launch_;
        launch.overlaps = launch_.overlaps && substep > 0;  // the first follows what is no kernel
        advance(substep > 0 && !ends_apart_, true, launch);
        break;
      }
      case StepOperation::take_lengths:
        if (substep == 1 && step_.changes_lengths) {
          kernels.take_later_lengths(input, launch_);
        }
        break;
      case StepOperation::recall_past:
      case StepOperation::update_velocities:
      case StepOperation::keep_past:
        break;  // see advance()
      case StepOperation::settle:
        if (ends_apart_) {
          advance(true, false, launch_);
        }
        break;
      case StepOperation::ease_contacts:
        if (has_pushers) {
          kernels.ease_contacts(state, tools, input, launch_);
        }
        if (has_meeters || has_touches) {
          kernels.ease_pieces(state, free_pieces, tools, input, substep, launch_);
        }
        if (has_meeters) {
          kernels.ease_surface_contacts(state, tools, input, launch_);
        }
        if (has_touches) {
          kernels.ease_touches(state, tools, input, launch_);
        }
        break;
      case StepOperation::clear_multipliers:
        break;  // the first sweep reads none
      case StepOperation::find_contacts:
        if (has_pushers) {
          kernels.find_contacts(state, tools, input, substep, launch_);
        }
        beside_touches(
            [&](const Launch& launch) {
              if (has_meeters) {
                kernels.find_surface_contacts(state, tools, input, substep, has_pushers, launch);
              }
              if (has_grips) {
                kernels.begin_grips(state, input, substep, vertices.block_count > 0, launch);
              }
            },
            [&](const Launch& launch) {
              kernels.find_touches(state, tools, input, substep, launch);
            });
        break;
      case StepOperation::gather_holds:
        break;  // see damp_rows and push
      case StepOperation::damp_rows:
        if (has_tools || vertices.is_damped) {
          kernels.prepare_vertices(state, vertices, tools, input, has_tools, launch_);
        }
        break;
      case StepOperation::begin_joints:
        if (step_.arrays.has_stiff_links) {
          kernels.find_loose_ends(substep, has_tools, state, constraints, vertices, tools, input,
                                  launch_);
        }
        for (const FillingArrays& filling : fillings) {
          kernels.find_wall_ends(filling, substep, has_tools, state, vertices, tools, input,
                                 launch_);
        }
        for (const Stage& stage : stages) {
          if (stage.kind == PhaseKind::stiff_link) {
            kernels.begin_joints(stage, state, constraints, input, launch_);
          }
        }
        for (const FillingArrays& filling : fillings) {
          kernels.project_filling(filling, state, vertices, free_pieces, input, true, launch_);
        }
        break;
      case StepOperation::sweep:
        sweeps_.enqueue(step_.arrays, substep, launch_);
        break;
      case StepOperation::push:
        if (has_tools) {
          kernels.prepare_vertices(state, vertices, tools, input, has_tools, launch_);
        }
        kernels.push_vertices(state, vertices, tools, input, substep, has_tools, launch_);
        for (int pass = 0; pass < kPushPasses; ++pass) {
          if (has_touches) {
            kernels.project_touches(state, tools, false, launch_);
          }
          if (has_meeters) {
            kernels.project_surface_contacts(state, tools, false, launch_);
          }
        }
        break;
      case StepOperation::settle_holds:
        settle_holds(substep);
        if (has_touches) {
          kernels.project_touches(state, tools, true, launch_);
          kernels.join_pieces(state, free_pieces, tools, launch_);
        }
        if (has_meeters) {
          kernels.project_surface_contacts(state, tools, true, launch_);
        }
        break;
      case StepOperation::keep_momentum:
        if (free_pieces.count > 0) {
          kernels.keep_momentum(state, vertices, free_pieces, tools, has_tools, launch_);
        }
        break;
      case StepOperation::stop_passing:
        if (has_meeters && tools.surfaces.thin_count > 0) {
          kernels.stop_passing(state, tools, input, substep, launch_);
        }
        break;
      case StepOperation::meet_surfaces:
        beside_touches(
            [&](const Launch& launch) {
              if (has_meeters) {
                kernels.begin_surface_contacts(state, vertices, tools, input, substep, launch);
              }
            },
            [&](const Launch& launch) {
              kernels.begin_touches(state, vertices, tools, input, substep, launch);
            });
        break;
      case StepOperation::collect_forces:
        beside_touches(
            [&](const Launch& launch) {
              if (has_tools) {
                kernels.collect_forces(state, tools, input, substep, launch);
              }
              if (has_meeters) {
                kernels.remember_surface_contacts(state, tools, input, substep, tells(substep),
                                                  launch);
              }
              if (has_grips) {
                kernels.end_grips(state, tools, input, substep, tells(substep), launch);
              }
            },
            [&](const Launch& launch) {
              kernels.remember_touches(state, tools, input, tells(substep), launch);
            });
        break;
    }
  }

  void finish() {
    if (!ends_apart_) {
      advance(true, false, launch_);
    }
    report();
  }

  void report() {
    if (step_.arrays.state.starts) {
      // strict, so that steps are divided as on a host
      strict_kernels.measure_stiffness(step_.arrays.state, step_.arrays.vertices,
                                       step_.arrays.input, launch_);
    }
    step_.kernels->report(step_.arrays.state, step_.arrays.constraints, step_.arrays.input,
                          step_.output, launch_);
  }

 private:
  [[nodiscard]] bool tells(Index substep) const {
    return substep + 1 == step_.program.division.substeps;
  }

  // What tools do, and what bodies that meet do meanwhile.
  template <class OfTools, class OfBodies>
  void beside_touches(const OfTools& of_tools, const OfBodies& of_bodies) {
    if (step_.arrays.has_touches && (step_.arrays.has_meeters || step_.arrays.has_grips)) {
      side_by_side(launch_, of_tools, of_bodies);
      return;
    }
    of_tools(launch_);
    if (step_.arrays.has_touches) {
      of_bodies(launch_);
    }
  }

  void settle_holds(Index substep) {
    const SweepArrays& arrays = step_.arrays;
    const bool is_pulled_last = arrays.has_stiff_links || !arrays.fillings.empty();
    if (!arrays.has_tools() || !is_pulled_last) {
      return;
    }
    for (const Stage& stage : arrays.stages) {
      if (stage.kind == PhaseKind::vertex) {
        step_.kernels->solve_vertices(stage, {substep, 1, true, true}, arrays.state,
                                      arrays.vertices, arrays.tools, arrays.input, launch_);
      }
    }
    if (arrays.has_grips) {
      step_.kernels->answer_grips(arrays.state, arrays.vertices, arrays.tools, arrays.input,
                                  substep, launch_);
    }
  }

  // What ends a substep and what begins the next: all that each vertex does for itself.
  void advance(bool ends, bool begins, const Launch& launch) {
    step_.kernels->advance(step_.arrays.state, step_.arrays.input, ends, begins, launch);
  }

  const DeviceStep& step_;
  Sweeps& sweeps_;
  const Launch& launch_;
  bool ends_apart_;  // substeps: something comes between the end of one and the next
};

}  // namespace

void enqueue_step(const DeviceStep& step, Sweeps& sweeps, const Launch& launch) {
  Enqueuer enqueuer(step, sweeps, launch);
  if (step.start.particles != nullptr) {
    keep_state(step.arrays.state, step.start, static_cast<std::size_t>(launch.copies),
               launch.stream);
  }
  if (step.is_whole) {
    sweeps.enqueue_step(step.arrays, launch);
    enqueuer.report();
    return;
  }
  run_step(step.program,
           [&](StepOperation operation, int substep) { enqueuer.run(operation, substep); });
  enqueuer.finish();
}

}  // namespace pbdsurg::cuda
