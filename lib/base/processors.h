// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How many processors there are for this program.

namespace pbdsurg {

/// Those that the calling thread may run on, at least one: a part of the machine's where an
/// administrator, a container or taskset gave it no more.
[[nodiscard]] int processor_count() noexcept;

}  // namespace pbdsurg
