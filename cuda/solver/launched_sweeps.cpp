// SPDX-License-Identifier: Apache-2.0
#include "cuda/solver/sweep_answers.h"
#include "cuda/solver/sweeps.h"
#include "lib/solver/methods/vertex_method.h"
#include "lib/solver/solver_options.h"

namespace pbdsurg::cuda {
namespace {

class LaunchedSweeps final : public Sweeps {
 public:
  explicit LaunchedSweeps(const SolverData& data)
      : kernels_(kernels_of(data.options)),
        is_damped_(data.sets.has_damping),
        options_(data.options) {}

  bool take_over(const SolverData& /*data*/, std::span<const Stage> /*stages*/,
                 const StageRecords& /*records*/, cudaStream_t /*stream*/) override {
    return true;
  }

  void enqueue(const SweepArrays& arrays, Index substep, const Launch& launch) override {
    for (int iteration = 0; iteration < arrays.sweep_count; ++iteration) {
      const bool is_first = iteration == 0;
      const Projection projection{options_.mode, is_damped_, !is_first,
                                  iteration + 1 < arrays.sweep_count};
      const VertexSweep sweep{
          substep, relaxation_of(options_.over_relaxation, iteration, arrays.sweep_count),
          arrays.has_tools(), false};
      for (const Stage& stage : arrays.stages) {
        if (stage.kind == PhaseKind::vertex) {
          kernels_.solve_vertices(stage, sweep, arrays.state, arrays.vertices, arrays.tools,
                                  arrays.input, launch);
        } else {
          kernels_.project(stage, projection, arrays.state, arrays.constraints, arrays.input,
                           launch);
        }
      }
      for (const FillingArrays& filling : arrays.fillings) {
        kernels_.project_filling(filling, arrays.state, arrays.vertices, arrays.free_pieces,
                                 arrays.input, is_first && !moves_vertices(options_), launch);
      }
      if (moves_vertices(options_)) {  // tools act on vertices as these move
        answer_sweep(kernels_, arrays, substep, is_first, launch, [&] { correct(arrays, launch); });
        continue;
      }
      if (arrays.has_touches) {
        kernels_.project_touches(arrays.state, arrays.tools, false, launch);
      }
      if (arrays.has_grips) {
        kernels_.project_grips(arrays.state, arrays.input, substep, launch);
      }
      if (arrays.has_attachments) {
        kernels_.project_attachments(arrays.state, arrays.tools, arrays.input, substep, is_first,
                                     launch);
      }
      if (arrays.has_pushers) {
        kernels_.project_contacts(arrays.state, arrays.tools, arrays.input, launch);
      }
      if (arrays.has_meeters) {
        kernels_.project_surface_contacts(arrays.state, arrays.tools, false, launch);
      }
    }
  }

 private:
  void correct(const SweepArrays& arrays, const Launch& launch) const {
    const DeviceState& state = arrays.state;
    const VertexArrays& vertices = arrays.vertices;
    const CoarseArrays& coarse = arrays.coarse;
    const bool has_tools = arrays.has_tools();
    const auto find_residuals = [&] {
      kernels_.find_residuals(state, vertices, coarse, arrays.input, has_tools, launch);
      for_each_wall(arrays, [&](const FillingArrays& filling, Index wide) {
        if (wide >= coarse.wide_count) {
          kernels_.leave_out_wall(filling, vertices, coarse, launch);
        }
      });
    };
    find_residuals();
    for_each_wall(arrays, [&](const FillingArrays& filling, Index wide) {
      if (wide < coarse.wide_count) {
        kernels_.sum_wall(filling, wide, coarse, launch);
      }
    });
    kernels_.move_by_modes(state, coarse, arrays.input, has_tools, launch);
    find_residuals();
    kernels_.turn_back_moves(state, coarse, arrays.input, launch);
  }

  // With its number among those that have one.
  template <class Visit>
  static void for_each_wall(const SweepArrays& arrays, const Visit& visit) {
    Index wide = 0;
    for (const FillingArrays& filling : arrays.fillings) {
      if (filling.wall_count > 0) {
        visit(filling, wide++);
      }
    }
  }

  const StepKernels& kernels_;
  bool is_damped_;
  SolverOptions options_;
};

}  // namespace

std::unique_ptr<Sweeps> make_launched_sweeps(const SolverData& data) {
  return std::make_unique<LaunchedSweeps>(data);
}

}  // namespace pbdsurg::cuda
