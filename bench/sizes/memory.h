// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Memory of this process.

#include <cstdint>

namespace pbdsurg::bench {

/// Bytes that the program holds of the C library's allocator, with what that adds. Under a
/// sanitizer, which has an allocator of its own, they say nothing.
[[nodiscard]] std::int64_t heap_bytes();

/// Bytes of this process in main memory, after what is free was given back.
/// @throws FileError  if the system does not tell
[[nodiscard]] std::int64_t resident_bytes();

}  // namespace pbdsurg::bench
