// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/base/error.h"

#include "bench/table1/figure8.h"

namespace pbdsurg::bench {

std::filesystem::path draw_figure8(const Sample&, const std::filesystem::path&) {
  throw BackendUnavailable("built without EGL, libepoxy or stb");
}

}  // namespace pbdsurg::bench
