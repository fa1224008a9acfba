// SPDX-License-Identifier: Apache-2.0
// Compiled without contraction, with IEEE division and roots: see cuda/CMakeLists.txt.
#define PBDSURG_KERNELS_NAMESPACE strict
#define PBDSURG_KERNELS_ARE_STRICT true
#include "cuda/solver/all_kernels.cuh"

namespace pbdsurg::cuda {
const StepKernels strict_kernels = strict::all_kernels();
}  // namespace pbdsurg::cuda
