// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// All kernels of a step, for one of its two compilations.

#include "cuda/solver/cluster_launch.cuh"
#include "cuda/solver/coarse_kernels.cuh"
#include "cuda/solver/cooperative_kernels.cuh"
#include "cuda/solver/eased_piece_kernels.cuh"
#include "cuda/solver/explicit_kernels.cuh"
#include "cuda/solver/filling_kernels.cuh"
#include "cuda/solver/grip_kernels.cuh"
#include "cuda/solver/momentum_kernels.cuh"
#include "cuda/solver/project_kernels.cuh"
#include "cuda/solver/report_kernels.cuh"
#include "cuda/solver/stiff_link_kernels.cuh"
#include "cuda/solver/stop_passing_kernels.cuh"
#include "cuda/solver/surface_answer_kernels.cuh"
#include "cuda/solver/surface_list_kernels.cuh"
#include "cuda/solver/surface_projection_kernels.cuh"
#include "cuda/solver/surface_search_kernels.cuh"
#include "cuda/solver/tool_kernels.cuh"
#include "cuda/solver/touch_kernels.cuh"
#include "cuda/solver/touch_list_kernels.cuh"
#include "cuda/solver/touched_piece_kernels.cuh"
#include "cuda/solver/vertex_block_kernels.cuh"
#include "cuda/solver/vertex_kernels.cuh"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

constexpr StepKernels all_kernels() {
  return {&code_architecture,
          &advance,
          &find_contacts,
          &find_surface_contacts,
          &begin_surface_contacts,
          &project_surface_contacts,
          &answer_surface_contacts,
          &stop_passing,
          &begin_grips,
          &answer_grips,
          &project_grips,
          &end_grips,
          &remember_surface_contacts,
          &ease_surface_contacts,
          &balance_pieces,
          &join_pieces,
          &ease_pieces,
          &find_touches,
          &begin_touches,
          &project_touches,
          &see_touches,
          &remember_touches,
          &ease_touches,
          &project,
          &project_attachments,
          &project_contacts,
          &project_filling,
          &prepare_vertices,
          &find_loose_ends,
          &begin_joints,
          &find_wall_ends,
          &solve_vertices,
          &push_vertices,
          &measure_stiffness,
          &prepare_sweep_of_vertices,
          &pack_rows,
          &pack_numbers,
          &sweep_vertices,
          &fill_mailboxes,
          &prepare_explicit_step,
          &step_explicitly,
          &find_residuals,
          &prepare_residuals,
          &find_residuals_by_tiles,
          &sum_wall,
          &leave_out_wall,
          &move_by_modes,
          &turn_back_moves,
          &prepare_cluster,
          &sweep_cluster,
          &keep_momentum,
          &collect_forces,
          &ease_contacts,
          &take_later_lengths,
          &report};
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
