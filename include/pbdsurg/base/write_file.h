// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Puts a file in place at once.

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string_view>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"

namespace pbdsurg {

/// Writes a file beside its place, then moves it there: no reader ever sees half of it. A symbolic
/// link is followed: what it names is replaced, and keeps its permissions, but not its owner and
/// other names. A device or a pipe is written to as it is.
/// @throws FileError  naming the path, if that fails; what was there before stays
PBDSURG_API void write_file(const std::filesystem::path& path, std::string_view bytes);

/// The same with what a function writes to a stream, for files that memory should not hold whole.
/// What the function throws goes through, and then nothing has changed either.
PBDSURG_API void write_file(const std::filesystem::path& path,
                            const std::function<void(std::ostream&)>& write);

}  // namespace pbdsurg
