// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Puts a file in place at once.

#include <filesystem>
#include <string_view>

namespace pbdsurg {

/// Writes a file beside its place, then moves it there: no reader ever sees half of it. A symbolic
/// link is followed: what it names is replaced. A device or a pipe is written to as it is.
/// @throws FileError  naming the path, if that fails; what was there before stays
void write_file(const std::filesystem::path& path, std::string_view bytes);

}  // namespace pbdsurg
