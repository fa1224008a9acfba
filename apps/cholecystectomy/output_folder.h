// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Where a run leaves its files: all of one run, or all of another.

#include <filesystem>
#include <string>
#include <vector>

namespace cholecystectomy {

/// The report, which lists the files of its run; it comes last and goes first, so that a folder
/// with a report is whole.
inline constexpr const char* kReportName = "report.json";

/// A folder that takes files of a run when all of them are there.
///
/// They are written to `run.part` in it. publish() removes what the report in the folder lists, the
/// files of an earlier run, and moves the new ones in. Other files stay; one of the same name as a
/// new one is replaced.
class OutputFolder {
 public:
  /// Makes the folder where it is missing, and `run.part` anew: that of a run that was killed goes.
  /// @throws pbdsurg::FileError, std::filesystem::filesystem_error  if nothing can be written there
  explicit OutputFolder(std::filesystem::path folder);

  /// Removes `run.part`, unless publish() failed.
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// Where files are written.
  [[nodiscard]] const std::filesystem::path& part() const noexcept { return part_; }

  /// Names of the files written so far, and of the report, sorted.
  [[nodiscard]] std::vector<std::string> files() const;

  /// @throws pbdsurg::FileError  naming `run.part`, in which the files then still are
  void publish();

 private:
  std::filesystem::path folder_, part_;
  bool is_kept_ = false;
};

}  // namespace cholecystectomy
