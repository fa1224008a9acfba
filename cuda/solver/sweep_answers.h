// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What follows a sweep of vertex blocks.

#include "cuda/solver/sweeps.h"

namespace pbdsurg::cuda {

/// Enqueues what answers a sweep of vertex blocks, in the order of a host: bodies that meet, grips,
/// tools that meet surfaces, and after the first sweep of a substep its correction.
/// @param correct  (); enqueues the correction
template <class Correct>
void answer_sweep(const StepKernels& kernels, const SweepArrays& arrays, Index substep,
                  bool is_first, const Launch& launch, const Correct& correct) {
  const auto balance = [&] {
    kernels.balance_pieces(arrays.state, arrays.free_pieces, arrays.tools, arrays.input, launch);
  };
  if (arrays.has_touches) {
    balance();
    kernels.see_touches(arrays.state, arrays.tools, arrays.input, true, launch);
  }
  if (arrays.has_grips) {
    kernels.answer_grips(arrays.state, arrays.vertices, arrays.tools, arrays.input, substep,
                         launch);
  }
  if (arrays.has_meeters) {
    if (!arrays.has_touches) {
      balance();
    }
    kernels.answer_surface_contacts(arrays.state, arrays.tools, arrays.input, substep, launch);
  }
  if (is_first && arrays.has_correction()) {
    correct();
    if (arrays.has_touches) {
      kernels.see_touches(arrays.state, arrays.tools, arrays.input, false, launch);
    }
  }
}

}  // namespace pbdsurg::cuda
