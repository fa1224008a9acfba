// SPDX-License-Identifier: Apache-2.0
#include "bench/table1/gpu_coloring.h"

namespace pbdsurg::bench {

std::string describe_gpu() {
  return "none: built without CUDA; the CUDA toolkit (>= 12) and PBDSURG_ENABLE_CUDA=ON would "
         "switch it on";
}

std::optional<double> time_gpu_coloring(const ConstraintVertices&, const ColoringOptions&,
                                        const Coloring&, int) {
  return std::nullopt;
}

}  // namespace pbdsurg::bench
