// SPDX-License-Identifier: Apache-2.0
#include "solver/cuda_hook.h"

#include <utility>

namespace pbdsurg {
namespace {

constinit const CudaHook* registered = nullptr;  // before all static initialisers

}  // namespace

const CudaHook* set_cuda_hook(const CudaHook* hook) noexcept {
  return std::exchange(registered, hook);
}

const CudaHook* cuda_hook() noexcept {
  return registered;
}

}  // namespace pbdsurg
