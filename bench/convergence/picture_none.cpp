// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/base/error.h"

#include "bench/convergence/picture.h"

namespace pbdsurg::bench {

void draw_curves(const Comparison&, const std::filesystem::path&) {
  throw BackendUnavailable("built without EGL, libepoxy or stb");
}

}  // namespace pbdsurg::bench
