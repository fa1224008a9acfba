// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/base/version.h"

#include <build_id.h>  // made by cmake/WriteBuildId.cmake

namespace pbdsurg {

const char* version() noexcept {
  return PBDSURG_VERSION;
}

const char* build_id() noexcept {
  return PBDSURG_VERSION " (commit " PBDSURG_COMMIT ", " PBDSURG_BUILD ")";
}

}  // namespace pbdsurg
