// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What contacts with surfaces and contacts between bodies have in common.

#include "cuda/solver/kernel_support.cuh"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

/// A contact as one of its corners has it, which has a weight.
/// @tparam Arrays  SurfaceArrays or TouchArrays
template <class Arrays>
struct HeldContact;

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
