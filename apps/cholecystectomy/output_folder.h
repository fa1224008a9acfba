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
/// They are written to `run.part` in it, or to `run.1.part` and so on where that is taken: what
/// this object did not make, it never deletes, so that the part of a run that was killed stays.
/// publish() removes what the report in the folder lists, the files of an earlier run, and moves
/// the new ones in. Other files stay.
class OutputFolder {
 public:
  /// Makes the folder where it is missing, and tries whether it can be written to.
  /// @throws pbdsurg::FileError  naming --out, if not; naming the file, if one is there that a run
  ///                             may write and that is no regular file of an earlier report
  explicit OutputFolder(std::filesystem::path folder);

  /// Removes the part folder, unless publish() failed.
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// Makes the part folder.
  /// @throws pbdsurg::FileError  if that fails
  void open();

  /// Where files are written, after open().
  [[nodiscard]] const std::filesystem::path& part() const noexcept { return part_; }

  /// Names of the files written so far, and of the report, sorted.
  [[nodiscard]] std::vector<std::string> files() const;

  /// @throws pbdsurg::FileError  naming the part folder, in which the files then still are; also if
  ///                             a file would be replaced that is not of an earlier run
  void publish();

 private:
  std::filesystem::path folder_, part_;
  bool is_kept_ = false;
};

}  // namespace cholecystectomy
