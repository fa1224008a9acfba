// SPDX-License-Identifier: Apache-2.0
#include "output_folder.h"

#include <algorithm>
#include <fstream>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "pbdsurg/core/error.h"

namespace cholecystectomy {
namespace {

namespace fs = std::filesystem;

// Files of an earlier run that its report lists; none if there is no such report, or another
// program's. A name that leads elsewhere is none of ours.
std::vector<fs::path> files_of_report(const fs::path& folder) {
  std::ifstream file(folder / kReportName);
  const nlohmann::json report = nlohmann::json::parse(file, nullptr, false);
  std::vector<fs::path> files;
  if (!report.is_object() || !report.contains("state_hash") || !report.contains("files") ||
      !report["files"].is_array()) {
    return files;
  }
  for (const nlohmann::json& entry : report["files"]) {
    const fs::path name = entry.is_string() ? entry.get<std::string>() : std::string();
    const bool is_plain = name.has_filename() && name == name.filename();
    const fs::file_status status = is_plain ? fs::symlink_status(folder / name) : fs::file_status();
    if (fs::is_regular_file(status) || fs::is_symlink(status)) {
      files.push_back(folder / name);
    }
  }
  return files;
}

}  // namespace

OutputFolder::OutputFolder(fs::path folder)
    : folder_(std::move(folder)), part_(folder_ / "run.part") {
  fs::create_directories(folder_);
  const fs::path report = folder_ / kReportName;
  if (fs::exists(report) && !fs::is_regular_file(report)) {
    throw pbdsurg::FileError(report.string() + ": is there, and is no file that may be replaced");
  }
  fs::remove_all(part_);
  fs::create_directory(part_);
}

OutputFolder::~OutputFolder() {
  if (!is_kept_) {
    std::error_code ignored;
    fs::remove_all(part_, ignored);
  }
}

std::vector<std::string> OutputFolder::files() const {
  std::vector<std::string> names{kReportName};
  for (const fs::directory_entry& entry : fs::directory_iterator(part_)) {
    if (entry.path().filename() != kReportName) {
      names.push_back(entry.path().filename().string());
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

void OutputFolder::publish() {
  is_kept_ = true;
  try {
    const std::vector<fs::path> old = files_of_report(folder_);
    fs::remove(folder_ / kReportName);
    for (const fs::path& file : old) {
      fs::remove(file);
    }
    for (const std::string& name : files()) {
      if (name != kReportName) {
        fs::rename(part_ / name, folder_ / name);
      }
    }
    fs::rename(part_ / kReportName, folder_ / kReportName);
  } catch (const fs::filesystem_error& error) {
    throw pbdsurg::FileError("the files of this run stay in " + part_.string() + ": " +
                             error.what());
  }
  is_kept_ = false;
}

}  // namespace cholecystectomy
