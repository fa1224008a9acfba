// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a hand did, to keep and to play again.
///
/// A trace is a text file, which numpy.loadtxt() reads as it is:
///
///     # pbdsurg device trace 1
///     # name Touch (left)
///     # begin_s 0.25
///     # asked_s time_s connected jaw buttons cut coagulation x_m y_m z_m xx xy ... fx_n fy_n fz_n
///     0.251 0.2505 1 0.5 0 0 0 0.01 0.02 0.03 1 0 0 0 1 0 0 0 1 0 0 -0.4
///
/// The first four lines are as here; the name is any text, and begin_s the recording clock when the
/// recording began. Then follows a line for each time that the state was asked for, in 22 columns
/// with one space between them:
///
/// | columns | hold                                                                          |
/// |---------|-------------------------------------------------------------------------------|
/// | 1, 2    | s, when it was asked for, ascending, and DeviceState::time                    |
/// | 3       | 1 if connected, else 0                                                        |
/// | 4       | jaw, 0 closed to 1 open                                                       |
/// | 5       | buttons, an integer                                                           |
/// | 6, 7    | pedals, cut and coagulation: 1 down, 0 up                                     |
/// | 8-10    | m, where the tip is                                                           |
/// | 11-19   | the instrument's x, y and z axis in the scene                                 |
/// | 20-22   | N, the force that was set until the state was asked for again, scene's axes   |
///
/// Numbers have as many digits as give the same bits again.

#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "pbdsurg/base/clock.h"
#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/haptics/device.h"

namespace pbdsurg {

/// A line of a trace.
struct DeviceSample {
  double asked = 0;                                 ///< s, when the state was asked for
  DeviceState state;                                ///< what the device said
  Eigen::Vector3f force = Eigen::Vector3f::Zero();  ///< N, set after that
};

/// A device over some time.
struct DeviceTrace {
  std::string name;                   ///< the device's
  double begin = 0;                   ///< s, by the clock of the recording
  std::vector<DeviceSample> samples;  ///< by ascending time of asking
  std::size_t lost = 0;               ///< that had no room; not in files
};

/// Reads a trace.
/// @throws FileError  naming the line, the value and the rule, if it cannot be opened, is of
///                    another version, or has no state, a line cut short, a column too many or too
///                    few, a number out of range or not finite, times that go back, or axes that
///                    are not those of a rotation (to 1e-3)
[[nodiscard]] PBDSURG_API DeviceTrace read_device_trace(const std::filesystem::path& path);

/// Writes a trace, in place at once. What a broken device said is written as it is, and refused on
/// reading.
/// @throws InvalidArgument  if the name has a line break
/// @throws FileError        if it cannot be written
PBDSURG_API void write_device_trace(const std::filesystem::path& path, const DeviceTrace& trace);

/// A device that keeps what it says and what it is told. At 1000 Hz, a minute takes 8 MB.
/// @param trace     begun anew here, and outlives the device
/// @param capacity  samples that are kept; reserved here, so that recording allocates nothing. The
///                  rest is counted as lost
/// @param clock     the device's; outlives it
/// @throws InvalidArgument  if there is no device, or room for no sample
[[nodiscard]] PBDSURG_API std::unique_ptr<Device> recorded(std::unique_ptr<Device> device,
                                                           DeviceTrace& trace, std::size_t capacity,
                                                           const Clock& clock);

/// A device that does again what a trace holds, from now on. Its state is that of the newest sample
/// whose time has come: the same bits at the same times, where the clock is as it was when the
/// recording began; else with all times shifted. Before the first sample and after the last it is
/// not connected.
/// @param clock  outlives the device
/// @throws InvalidArgument  if the trace has no sample, or times that go back or are not finite
[[nodiscard]] PBDSURG_API std::unique_ptr<Device> replayed(DeviceTrace trace, const Clock& clock);

}  // namespace pbdsurg
