// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Work that threads of a device share, and a host does by itself.

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// Some who work on the same numbers: each on those whose index is `first` modulo `stride`. Of a
/// matrix, each on the entries whose row is `row()` modulo `rows()`, and likewise their column.
struct OneWorker {
  Index first = 0, stride = 1;
  [[nodiscard]] PBDSURG_HOST_DEVICE Index row() const { return 0; }
  [[nodiscard]] PBDSURG_HOST_DEVICE Index rows() const { return 1; }
  [[nodiscard]] PBDSURG_HOST_DEVICE Index column() const { return 0; }
  [[nodiscard]] PBDSURG_HOST_DEVICE Index columns() const { return 1; }
  PBDSURG_HOST_DEVICE void meet() const {}
};

}  // namespace pbdsurg
