// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Work that threads of a device share, and a host does by itself.

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// Some who work on the same numbers: each on those whose index is `first` modulo `stride`.
struct OneWorker {
  Index first = 0, stride = 1;
  PBDSURG_HOST_DEVICE void meet() const {}
};

}  // namespace pbdsurg
