// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// report.json: everything that a run counted.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/cholecystectomy/procedure.h"
#include "apps/cholecystectomy/warning.h"

namespace cholecystectomy {

/// What a report tells beside the simulation.
struct ReportNotes {
  std::uint64_t seed;
  std::vector<std::string> organs;  ///< where they came from, a line each
  std::vector<Warning> warnings;
  std::vector<std::string> files;  ///< all that the run wrote, the report too
};

/// Writes the report. But for `stages_ms` it depends on the input and the seed alone.
/// @throws pbdsurg::FileError  if it cannot be written
void write_report(const std::filesystem::path& path, const Simulation& simulation,
                  const Course& course, const ReportNotes& notes);

}  // namespace cholecystectomy
