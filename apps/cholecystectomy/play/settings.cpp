// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/settings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <system_error>
#include <type_traits>
#include <utility>

#include <nlohmann/json.hpp>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/write_file.h"

namespace cholecystectomy {
namespace {

using nlohmann::json;

constexpr std::array<std::pair<const char*, Detail>, 2> kDetails{
    {{"full", Detail::full}, {"low", Detail::low}}};
constexpr std::array<std::pair<const char*, PictureQuality>, 3> kQualities{
    {{"automatic", PictureQuality::automatic},
     {"quick", PictureQuality::quick},
     {"full", PictureQuality::full}}};

// Calls visit(key, value, least, most) for each number of the settings.
template <class AnySettings, class Visit>
void for_each_number(AnySettings& settings, const Visit& visit) {
  visit("motion_scale", settings.motion_scale, 0.2, 3.0);
  visit("text_scale", settings.text_scale, 0.7, 3.0);
  visit("volume", settings.volume, 0.0, 1.0);
  visit("cut_power_w", settings.cut_power, 1.0, 120.0);
  visit("coagulation_power_w", settings.coagulation_power, 1.0, 120.0);
  visit("width", settings.width, 160, 16384);
  visit("height", settings.height, 120, 16384);
}

void read(const json& file, Settings& settings, std::string& complaint) {
  const auto complain = [&](const std::string& key, const std::string& rule) {
    complaint += (complaint.empty() ? "" : "; ") + key + " must be " + rule;
  };
  for_each_number(settings, [&](const char* key, auto& value, auto least, auto most) {
    if (!file.contains(key)) {
      return;
    }
    const json& found = file.at(key);
    const double number = found.is_number() ? found.get<double>() : std::nan("");
    if (number >= least && number <= most) {
      value = static_cast<std::remove_reference_t<decltype(value)>>(number);
    } else {
      complain(key, "from " + json(least).dump() + " to " + json(most).dump());
    }
  });
  const auto read_switch = [&](const char* key, auto& value) {
    if (file.contains(key)) {
      const json& found = file.at(key);
      found.is_boolean() ? static_cast<void>(value = found.get<bool>())
                         : complain(key, "true or false");
    }
  };
  read_switch("left_handed", settings.is_left_handed);
  read_switch("follows_tips", settings.follows_tips);
  const auto read_word = [&](const char* key, const auto& words, auto& value) {
    if (!file.contains(key)) {
      return;
    }
    std::string known;
    for (const auto& [word, meaning] : words) {
      if (file.at(key) == word) {
        value = meaning;
        return;
      }
      known += std::string(known.empty() ? "" : ", ") + '"' + word + '"';
    }
    complain(key, "one of " + known);
  };
  read_word("detail", kDetails, settings.detail);
  read_word("pictures", kQualities, settings.quality);
}

template <class Words, class Value>
const char* word_of(const Words& words, Value value) {
  return std::ranges::find(words, value, &Words::value_type::second)->first;
}

}  // namespace

std::filesystem::path default_settings_path() {
  const auto folder = [](const char* variable) {
    const char* const value = std::getenv(variable);
    return std::filesystem::path(value == nullptr ? "" : value);
  };
  std::filesystem::path base = folder("XDG_CONFIG_HOME");
  if (base.empty() && !folder("HOME").empty()) {
    base = folder("HOME") / ".config";
  }
  return base.empty() ? base : base / "pbdsurg" / "cholecystectomy.json";
}

Settings load_settings(const std::filesystem::path& path, std::string& complaint) {
  complaint.clear();
  Settings settings;
  std::error_code error;
  if (path.empty() || !std::filesystem::exists(path, error)) {
    return settings;
  }
  std::ifstream stream(path);
  const json file = json::parse(stream, nullptr, false);
  if (!file.is_object()) {
    complaint = path.string() + " is no JSON object, so settings have their defaults";
    return settings;
  }
  read(file, settings, complaint);
  if (!complaint.empty()) {
    complaint = path.string() + ": " + complaint;
  }
  return settings;
}

std::string save_settings(const std::filesystem::path& path, const Settings& settings) {
  if (path.empty()) {
    return "settings are not kept: neither XDG_CONFIG_HOME nor HOME is set";
  }
  json file;
  for_each_number(settings,
                  [&](const char* key, const auto& value, auto, auto) { file[key] = value; });
  file["left_handed"] = settings.is_left_handed;
  if (settings.follows_tips) {
    file["follows_tips"] = *settings.follows_tips;
  }
  file["detail"] = word_of(kDetails, settings.detail);
  file["pictures"] = word_of(kQualities, settings.quality);
  try {
    if (!path.parent_path().empty()) {
      std::filesystem::create_directories(path.parent_path());
    }
    pbdsurg::write_file(path, file.dump(2) + "\n");
  } catch (const std::exception& error) {
    return std::string("settings are not kept: ") + error.what();
  }
  return {};
}

}  // namespace cholecystectomy
