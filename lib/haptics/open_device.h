// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Opens serial ports and input devices, and says what to do where that fails.

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "pbdsurg/base/error.h"
#include "pbdsurg/haptics/file_descriptor.h"

namespace pbdsurg {

/// What to do, as an imperative: "install the rule of docs/rig/pedals.md".
struct OpenAdvice {
  std::string_view not_allowed;
  std::string_view not_there;
};

/// A sentence for a person: path, reason, what to do.
[[nodiscard]] std::string open_refusal(const std::filesystem::path& path, int error,
                                       const OpenAdvice& advice);

/// Opens for reading, so that reads do not wait.
/// @throws FileError  open_refusal()
[[nodiscard]] FileDescriptor open_device(const std::filesystem::path& path,
                                         const OpenAdvice& advice);

/// read() that signals do not end.
/// @return  bytes; 0 at the end; negative if there is nothing now
[[nodiscard]] long read_available(const FileDescriptor& descriptor, void* bytes,
                                  std::size_t size) noexcept;

}  // namespace pbdsurg
