// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/settings.h"

#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"

namespace cholecystectomy {

using pbdsurg::testing::Approx;
using pbdsurg::testing::ContainsSubstring;

namespace {

Settings load(const pbdsurg::testing::TemporaryFolder& folder, const std::string& text,
              std::string& complaint) {
  return load_settings(folder.put("settings.json", text), complaint);
}

}  // namespace

// Would catch a setting that is forgotten.
TEST_CASE("settings: what is saved is loaded", "[unit]") {
  const pbdsurg::testing::TemporaryFolder folder;
  Settings settings;
  settings.detail = Detail::low;
  settings.quality = PictureQuality::quick;
  settings.is_left_handed = true;
  settings.follows_tips = false;
  settings.motion_scale = 0.5;
  settings.text_scale = 2;
  settings.volume = 0.25;
  settings.cut_power = 45;
  settings.coagulation_power = 20;
  settings.width = 800;
  settings.height = 600;
  const auto path = folder / "new" / "folder" / "settings.json";
  REQUIRE(save_settings(path, settings).empty());
  std::string complaint = "before";
  const Settings loaded = load_settings(path, complaint);
  CHECK(complaint.empty());
  CHECK(loaded.detail == Detail::low);
  CHECK(loaded.quality == PictureQuality::quick);
  CHECK(loaded.is_left_handed);
  CHECK(loaded.follows_tips == false);
  CHECK(loaded.motion_scale == 0.5);
  CHECK(loaded.text_scale == 2);
  CHECK(loaded.volume == 0.25);
  CHECK(loaded.cut_power == 45);
  CHECK(loaded.coagulation_power == 20);
  CHECK(loaded.width == 800);
  CHECK(loaded.height == 600);
  settings.follows_tips.reset();  // whom nobody asked
  REQUIRE(save_settings(path, settings).empty());
  CHECK_FALSE(load_settings(path, complaint).follows_tips.has_value());
}

// Would catch a file of another hand that ends the program or sets what cannot be.
TEST_CASE("settings: what is wrong keeps its default and is named", "[unit]") {
  const pbdsurg::testing::TemporaryFolder folder;
  std::string complaint;
  CHECK(load_settings(folder / "none.json", complaint).volume == 0.5);
  CHECK(complaint.empty());
  CHECK(load(folder, "{ not json", complaint).volume == 0.5);
  CHECK_THAT(complaint, ContainsSubstring("settings.json") && ContainsSubstring("no JSON"));
  const Settings settings =
      load(folder,
           R"({"volume": 7, "width": "wide", "left_handed": 1, "detail": "some", "cut_power_w": 50,
          "follows_tips": "yes"})",
           complaint);
  CHECK(settings.volume == 0.5);
  CHECK(settings.width == 1280);
  CHECK_FALSE(settings.is_left_handed);
  CHECK_FALSE(settings.follows_tips.has_value());
  CHECK(settings.detail == Detail::full);
  CHECK(settings.cut_power == 50);
  for (const char* part :
       {"volume must be from 0.0 to 1.0", "width must", "left_handed must be true",
        "follows_tips must be true", "detail must be one of \"full\", \"low\""}) {
    CHECK_THAT(complaint, ContainsSubstring(part));
  }
}

TEST_CASE("settings: where they cannot be kept, one sentence says so", "[unit]") {
  const pbdsurg::testing::TemporaryFolder folder;
  CHECK_THAT(save_settings({}, {}), ContainsSubstring("neither"));
  // a name without a folder
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder / "");
  CHECK(save_settings("bare.json", {}).empty());
  CHECK(std::filesystem::exists(folder / "bare.json"));
  std::filesystem::current_path(before);
  CHECK_THAT(save_settings(folder.put("file", "in the way") / "settings.json", {}),
             ContainsSubstring("not kept"));
}

}  // namespace cholecystectomy
