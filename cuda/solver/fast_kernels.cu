// SPDX-License-Identifier: Apache-2.0
// Compiled with contraction and quick division and roots: see cuda/CMakeLists.txt.
#define PBDSURG_KERNELS_NAMESPACE fast
#define PBDSURG_KERNELS_ARE_STRICT false
#include "cuda/solver/all_kernels.cuh"

namespace pbdsurg::cuda {
const StepKernels fast_kernels = fast::all_kernels();
}  // namespace pbdsurg::cuda
