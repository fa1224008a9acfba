// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/base/error.h"
#include "pbdsurg/cuda/coloring.h"
#include "pbdsurg/cuda/device.h"

#include "bench/support/timing.h"
#include "bench/table1/gpu_coloring.h"

namespace pbdsurg::bench {

std::string describe_gpu() {
  const cuda::DeviceList list = cuda::find_devices();
  return list.devices.empty() ? list.reason : list.devices.front().name;
}

std::optional<double> time_gpu_coloring(const ConstraintVertices& constraints,
                                        const ColoringOptions& options, const Coloring& expected,
                                        int repetitions) {
  const bool is_sequential =
      options.algorithm == ColoringAlgorithm::greedy &&
      (options.order == GreedyOrder::smallest_last || options.order == GreedyOrder::saturation);
  if (is_sequential || cuda::find_devices().devices.empty()) {
    return std::nullopt;
  }
  cuda::DeviceColoring device(constraints);
  device.color(options);  // allocates
  const double time = median_time(repetitions, [&] { device.color(options); });
  if (device.download() != expected) {
    throw Error(std::string(name_of(options.algorithm)) +
                ": the device's colouring differs from the host's");
  }
  return time;
}

}  // namespace pbdsurg::bench
