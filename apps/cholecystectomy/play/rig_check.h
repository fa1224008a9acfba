// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Two minutes before an operation: whether all devices of a rig do what they should.

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace cholecystectomy {

/// A line of the sheet.
struct RigCheckLine {
  enum class Result { ok, failed, not_checked };
  std::string what;
  Result result;
  std::string detail;
};

struct RigCheckOptions {
  std::string devices = "mouse";  ///< see rig::read_rig()
  bool has_virtual_time = false;  ///< of emulated or recorded hands
};

/// What a check needs beside the devices.
struct RigCheckHelp {
  /// Tells the person what to do.
  std::function<void(const std::string& text)> tell;
  /// Asks the person; nothing if nobody answers.
  std::function<std::optional<bool>(const std::string& question)> ask;
  /// Sounds both tones and a chime, and says by which device.
  std::function<std::string()> sound;
  /// Draws pictures; ms of one, and by which device. Nothing if this build or machine draws none.
  std::function<std::optional<std::pair<double, std::string>>()> draw;
};

/// Asks the person to move each hand, press on a wall that is not there, work the jaws and step on
/// both pedals, and waits for each up to 20 seconds. Emulated hands do so by themselves.
/// @throws pbdsurg::Error  if a device does not open
[[nodiscard]] std::vector<RigCheckLine> check_rig(const RigCheckOptions& options,
                                                  const RigCheckHelp& help);

/// To be printed and signed.
[[nodiscard]] std::string sheet_of(const std::vector<RigCheckLine>& lines,
                                   const std::string& devices);

/// Checks with a person at the terminal, and prints the sheet.
/// @return  the exit status: 1 if a line failed
int check_rig_at_terminal(const RigCheckOptions& options);

}  // namespace cholecystectomy
