// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/output_folder.h"

#include <algorithm>
#include <fstream>
#include <regex>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "pbdsurg/base/error.h"

namespace cholecystectomy {
namespace {

namespace fs = std::filesystem;

// Files of an earlier run that its report lists; none if there is no such report, or another
// program's. A name that leads elsewhere is none of ours, nor is a link.
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
    if (is_plain && fs::is_regular_file(fs::symlink_status(folder / name))) {
      files.push_back(folder / name);
    }
  }
  return files;
}

// Whether a run may write a file of this name.
bool is_name_of_run(const std::string& name) {
  static const std::regex names(
      R"(report\.json|(force|cautery|recovery|hands)\.csv|series\.pvd|series_\d{6}\.vtu|)"
      R"(hands_\d+ms\.png|(left|right)\.trace|)"
      R"(\d\d_(start|interrupted|drag_\d+ms|(burn|separate)_(begin|middle|end)|separate_bed)\.png)");
  return std::regex_match(name, names);
}

// Refuses a file of the user's.
void check_is_ours(const fs::path& file, const std::vector<fs::path>& ours) {
  if (fs::exists(fs::symlink_status(file)) &&
      std::find(ours.begin(), ours.end(), file) == ours.end()) {
    throw pbdsurg::FileError(file.string() +
                             " is no file of an earlier run; move it away or choose another folder "
                             "with --out");
  }
}

// A folder in this one that was not there before.
fs::path make_part(const fs::path& folder) {
  for (int i = 0;; ++i) {
    fs::path part = folder / (i == 0 ? "run.part" : "run." + std::to_string(i) + ".part");
    if (!fs::exists(fs::symlink_status(part)) && fs::create_directory(part)) {
      return part;
    }
  }
}

pbdsurg::FileError unusable(const fs::path& folder, const std::string& why) {
  return pbdsurg::FileError("--out '" + folder.string() + "': " + why);
}

}  // namespace

OutputFolder::OutputFolder(fs::path folder) : folder_(std::move(folder)) {
  if (folder_.empty()) {
    throw unusable(folder_, "expected the name of a folder");
  }
  try {
    if (fs::exists(fs::symlink_status(folder_)) && !fs::is_directory(folder_)) {
      throw unusable(folder_, "is no folder");
    }
    fs::create_directories(folder_);
    fs::remove(make_part(folder_));
    const std::vector<fs::path> ours = files_of_report(folder_);
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
      if (is_name_of_run(entry.path().filename().string())) {
        check_is_ours(entry.path(), ours);
      }
    }
  } catch (const fs::filesystem_error& error) {
    throw unusable(folder_, "cannot be written to (" + error.code().message() + ")");
  }
}

void OutputFolder::open() {
  try {
    part_ = make_part(folder_);
  } catch (const fs::filesystem_error& error) {
    throw unusable(folder_, "cannot be written to (" + error.code().message() + ")");
  }
}

OutputFolder::~OutputFolder() {
  if (!is_kept_ && !part_.empty()) {
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
    for (const std::string& name : files()) {
      check_is_ours(folder_ / name, old);
    }
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
  } catch (const std::runtime_error& error) {
    throw pbdsurg::FileError("the files of this run stay in " + part_.string() + ": " +
                             error.what());
  }
  is_kept_ = false;
}

}  // namespace cholecystectomy
