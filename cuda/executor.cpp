// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/base/executor.h"

#include <memory>
#include <string>
#include <utility>

#include "pbdsurg/base/error.h"
#include "pbdsurg/cuda/coloring.h"
#include "pbdsurg/cuda/device.h"

#include "cuda/heat/cuda_system.h"
#include "cuda/solver/cuda_backend.h"
#include "cuda/stream.cuh"
#include "lib/base/executor_state.h"
#include "lib/coloring/coloring_device.h"
#include "lib/heat/device_system.h"
#include "lib/solver/program/solver_device.h"

namespace pbdsurg::cuda {
namespace {

class CudaDevice final : public Device,
                         public ColoringDevice,
                         public SolverDevice,
                         public FieldDevice {
 public:
  explicit CudaDevice(const DeviceInfo& info) : id_(info.id), name_("CUDA, " + info.name) {}

  [[nodiscard]] const std::string& name() const noexcept override { return name_; }

  [[nodiscard]] std::unique_ptr<Backend> make_backend(const SolverData& data) override {
    const CurrentDevice current(id_);
    return cuda::make_backend(data);
  }

  [[nodiscard]] std::unique_ptr<DeviceSystem> make_system() override {
    const CurrentDevice current(id_);
    return make_cuda_system();
  }

  [[nodiscard]] Coloring color(const ConstraintVertices& constraints,
                               const ColoringOptions& options) override {
    const CurrentDevice current(id_);
    try {
      return cuda::color_constraints(constraints, options);
    } catch (const DeviceError& error) {
      throw BackendUnavailable(std::string("the CUDA device cannot colour this: ") + error.what());
    }
  }

 private:
  int id_;
  std::string name_;
};

// Devices do not come and go, so only a failure is asked about again.
const DeviceList& devices() {
  static const DeviceList list = find_devices();
  return list;
}

Executor make_executor(const DeviceInfo& info, Executor instead) {
  return Executor(
      std::make_shared<ExecutorState>(std::make_shared<CudaDevice>(info), std::move(instead)));
}

}  // namespace

Executor device(int ordinal) {
  const DeviceList& list = devices();
  if (list.devices.empty()) {
    throw BackendUnavailable("there is no CUDA device: " + list.reason);
  }
  for (const DeviceInfo& info : list.devices) {
    if (info.id == ordinal) {
      return make_executor(info, {});
    }
  }
  throw BackendUnavailable("there is no CUDA device " + std::to_string(ordinal) +
                           "; this machine has " + std::to_string(list.devices.size()));
}

Executor best() {
  try {
    const DeviceList& list = devices();
    return list.devices.empty() ? executor::threads()
                                : make_executor(list.devices.front(), executor::threads());
  } catch (const DeviceError&) {  // a driver that does not answer
    return executor::threads();
  }
}

}  // namespace pbdsurg::cuda
