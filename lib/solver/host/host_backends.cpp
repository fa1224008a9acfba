// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/host/host_backends.h"

#include <utility>

namespace pbdsurg {

std::unique_ptr<Backend> make_host_backend(const SolverOptions& options) {
  if (options.executor.kind() == ExecutorKind::serial) {
    return make_serial_backend();
  }
  std::unique_ptr<Backend> backend = make_threaded_backend(options);
  return backend == nullptr ? make_serial_backend() : std::move(backend);
}

}  // namespace pbdsurg
