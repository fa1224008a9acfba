// SPDX-License-Identifier: Apache-2.0
#include "solver/host_backends.h"

#include <utility>

#include "pbdsurg/core/error.h"

namespace pbdsurg {

std::unique_ptr<Backend> make_host_backend(const SolverOptions& options) {
  if (options.backend == BackendKind::serial) {
    return make_serial_backend();
  }
  std::unique_ptr<Backend> backend = make_threaded_backend(options);
  if (backend == nullptr && options.backend == BackendKind::threaded) {
    throw BackendUnavailable(
        "the threaded backend has no kernels for this processor; it has them for x86-64 with "
        "SSSE3, AVX2 or AVX-512");
  }
  return backend == nullptr ? make_serial_backend() : std::move(backend);
}

}  // namespace pbdsurg
