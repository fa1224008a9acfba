// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which library this is.

#include "pbdsurg/base/export.h"

namespace pbdsurg {

/// "MAJOR.MINOR.PATCH"; CHANGELOG.md says what each of them may change.
[[nodiscard]] PBDSURG_API const char* version() noexcept;

/// version() with commit, kind of build, compiler and METIS, for reports:
/// "0.1.0 (commit 0123456789ab, Release, GNU 12.2.0, METIS 5.1.0)". A commit ends with "-dirty"
/// where sources were changed since, and is "unknown" outside of a checkout.
[[nodiscard]] PBDSURG_API const char* build_id() noexcept;

}  // namespace pbdsurg
