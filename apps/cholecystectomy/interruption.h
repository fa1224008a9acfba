// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Ctrl-C, SIGTERM and SIGHUP.

namespace cholecystectomy {

inline constexpr int kInterruptedStatus = 130;  ///< exit status, as shells have it for Ctrl-C

/// From here on, a signal ends the program at once with that status and a line that says so. A
/// signal that whoever started the program has switched off stays off.
void end_on_interrupt();

/// From here on, the first signal is only noted, so that the run can write what there is; one that
/// comes a second or more after it ends the program.
void note_interrupt();

/// Whether a signal was noted.
[[nodiscard]] bool is_interrupted() noexcept;

}  // namespace cholecystectomy
