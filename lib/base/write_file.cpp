// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/base/write_file.h"

#include <cerrno>
#include <cstdio>
#include <fstream>
#include <string>
#include <system_error>

#include "pbdsurg/base/error.h"

namespace pbdsurg {
namespace {

/// What a chain of symbolic links ends at, there or not.
std::filesystem::path follow_links(const std::filesystem::path& path) {
  constexpr int kMostLinks = 40;  // as Linux
  std::filesystem::path place = path;
  std::error_code error;
  for (int links = 0; std::filesystem::is_symlink(place, error); ++links) {
    if (links == kMostLinks) {
      throw FileError(path.string() + ": more than 40 symbolic links lead on from it");
    }
    // of an absolute target, operator/ keeps the target alone
    place = place.parent_path() / std::filesystem::read_symlink(place, error);
  }
  return place;
}

/// An empty file beside the place that was not there before: neither a user's own nor another
/// writer's is written over.
std::filesystem::path make_part(const std::filesystem::path& path,
                                const std::filesystem::path& place) {
  for (int number = 0;; ++number) {
    std::filesystem::path part = place;
    part += number == 0 ? ".part" : "." + std::to_string(number) + ".part";
    if (std::FILE* const file = std::fopen(part.c_str(), "wxb")) {
      std::fclose(file);
      return part;
    }
    if (errno != EEXIST) {
      const std::string reason = std::generic_category().message(errno);
      throw FileError(path.string() + ": cannot be written: " + part.string() +
                      " cannot be made: " + reason);
    }
  }
}

/// @param part  what is written, and removed if that fails: beside the path, or the path itself if
///              that is a device
void write_part(const std::filesystem::path& path, const std::filesystem::path& part,
                const std::function<void(std::ostream&)>& write) {
  const auto give_up = [&] {
    if (part != path) {
      std::error_code error;
      std::filesystem::remove(part, error);
    }
  };
  std::ofstream stream(part, std::ios::binary | std::ios::trunc);
  if (!stream) {
    give_up();
    throw FileError(path.string() + ": cannot be written: " + part.string() + " cannot be opened");
  }
  try {
    write(stream);
  } catch (...) {
    give_up();
    throw;
  }
  stream.close();
  if (!stream) {
    give_up();
    throw FileError(path.string() + ": writing failed; is the disk full?");
  }
}

}  // namespace

void write_file(const std::filesystem::path& path, std::string_view bytes) {
  write_file(path, [bytes](std::ostream& stream) {
    stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  });
}

void write_file(const std::filesystem::path& path,
                const std::function<void(std::ostream&)>& write) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (std::filesystem::is_directory(status)) {
    throw FileError(path.string() + ": is a directory");
  }
  if (std::filesystem::is_other(status)) {
    write_part(path, path, write);
    return;
  }
  const std::filesystem::path place = follow_links(path);
  const std::filesystem::path part = make_part(path, place);
  write_part(path, part, write);
  if (std::filesystem::exists(status)) {
    std::filesystem::permissions(part, status.permissions(), error);
  }
  std::filesystem::rename(part, place, error);
  if (error) {
    const std::string reason = error.message();
    std::filesystem::remove(part, error);
    throw FileError(path.string() + ": cannot be replaced: " + reason);
  }
}

}  // namespace pbdsurg
