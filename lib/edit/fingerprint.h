// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// By which an edit is known again.

#include <cstdint>

#include "pbdsurg/edit/topology_edit.h"

namespace pbdsurg {

/// 64 bits that differ where anything of an edit or its result does (up to chance). Cost:
/// proportional to these.
[[nodiscard]] std::uint64_t fingerprint_of(const TopologyEdit& edit,
                                           const EditResult& result) noexcept;

}  // namespace pbdsurg
