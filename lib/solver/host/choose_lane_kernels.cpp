// SPDX-License-Identifier: Apache-2.0
#include <hwy/targets.h>

#include "lib/solver/host/lane_kernels.h"

namespace pbdsurg {

// lane_kernels.cpp as lib/solver/CMakeLists.txt compiles it
#ifdef PBDSURG_HAS_X86_LANES
namespace lanes_ssse3_fast {
extern const LaneKernels kernels;
}
namespace lanes_ssse3_strict {
extern const LaneKernels kernels;
}
namespace lanes_avx2_fast {
extern const LaneKernels kernels;
}
namespace lanes_avx2_strict {
extern const LaneKernels kernels;
}
namespace lanes_avx512_fast {
extern const LaneKernels kernels;
}
namespace lanes_avx512_strict {
extern const LaneKernels kernels;
}
#endif

const LaneKernels* choose_lane_kernels([[maybe_unused]] bool fast) {
#ifdef PBDSURG_HAS_X86_LANES
  const auto supported = hwy::SupportedTargets();
  if ((supported & HWY_AVX3) != 0) {
    return fast ? &lanes_avx512_fast::kernels : &lanes_avx512_strict::kernels;
  }
  if ((supported & HWY_AVX2) != 0) {
    return fast ? &lanes_avx2_fast::kernels : &lanes_avx2_strict::kernels;
  }
  if ((supported & HWY_SSSE3) != 0) {
    return fast ? &lanes_ssse3_fast::kernels : &lanes_ssse3_strict::kernels;
  }
#endif
  return nullptr;
}

}  // namespace pbdsurg
