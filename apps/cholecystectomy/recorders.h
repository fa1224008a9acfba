// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a run leaves behind, beside pictures: forces, a ParaView series, a line of progress.

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "pbdsurg/mesh/series.h"

#include "apps/cholecystectomy/procedure.h"

namespace cholecystectomy {

/// A text file of comma-separated values that is written line by line.
class CsvFile {
 public:
  /// @throws pbdsurg::FileError  if the file cannot be opened
  CsvFile(const std::filesystem::path& path, const std::string& header);

  std::ostream& stream() { return file_; }

  /// @throws pbdsurg::FileError  if not all could be written
  void close();

 private:
  std::filesystem::path path_;
  std::ofstream file_;
};

/// Writes force.csv: t_s, tool, fx_n, fy_n, fz_n; two rows a step.
class ForceRecorder final : public Observer {
 public:
  /// @throws pbdsurg::FileError  if the file cannot be opened
  explicit ForceRecorder(const std::filesystem::path& path);

  void step(const Simulation& simulation, double progress) override;
  void moment(const Simulation& simulation, const std::string& name) override;

  /// @throws pbdsurg::FileError  if not all could be written
  void close();

 private:
  CsvFile file_;
};

/// Writes cautery.csv: t_s, power set and delivered, resistance (inf: open), hottest tissue, energy
/// in, tets deleted, links cut; a row a step, the last three sums so far.
class CauteryRecorder final : public Observer {
 public:
  /// @throws pbdsurg::FileError  if the file cannot be opened
  explicit CauteryRecorder(const std::filesystem::path& path);

  void step(const Simulation& simulation, double progress) override;
  void moment(const Simulation& simulation, const std::string& name) override;

  /// @throws pbdsurg::FileError  if not all could be written
  void close();

 private:
  CsvFile file_;
};

/// Writes t_ms, since the release, and distance_mm.
/// @throws pbdsurg::FileError  if the file cannot be opened or not all could be written
void write_recovery(const std::filesystem::path& path, const Recovery& recovery);

/// Writes series.pvd with positions, velocities, temperature, water, body and heat state at each
/// moment.
class SeriesRecorder final : public Observer {
 public:
  explicit SeriesRecorder(const std::filesystem::path& path);

  void step(const Simulation& simulation, double progress) override;
  void moment(const Simulation& simulation, const std::string& name) override;

 private:
  pbdsurg::MeshSeries series_;
};

/// Shows a bar on a terminal, or a line a moment elsewhere.
class ProgressRecorder final : public Observer {
 public:
  ProgressRecorder();

  /// Ends the line of a bar that did not reach its end.
  ~ProgressRecorder() override;

  void step(const Simulation& simulation, double progress) override;
  void moment(const Simulation& simulation, const std::string& name) override;

 private:
  bool is_terminal_;
  int shown_ = -1;  // percent
};

}  // namespace cholecystectomy
