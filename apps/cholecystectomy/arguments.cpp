// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/arguments.h"

#include <array>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/version.h"

#include "apps/pbdsurg/options.h"

namespace cholecystectomy {
namespace {

void add_organ(const std::string& text, OrganFiles& organs) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size()) {
    throw pbdsurg::InvalidArgument("--organ " + text + ": expected NAME=FILE");
  }
  const pbdsurg::Organ name = find_organ(text.substr(0, equals));
  if (!organs.paths.emplace(name, text.substr(equals + 1)).second) {
    throw pbdsurg::InvalidArgument("--organ " + text + ": this organ is given twice");
  }
}

// Ways to run the demo.
constexpr unsigned kScript = 1, kVirtualTime = 2, kRigCheck = 4, kWindow = 8;
constexpr std::array kWays{std::pair(kScript, "--headless"),
                           std::pair(kVirtualTime, "--virtual-time"),
                           std::pair(kRigCheck, "--rig-check"), std::pair(kWindow, "the window")};

unsigned way_of(const Arguments& arguments) {
  return arguments.is_headless    ? kScript
         : arguments.is_rig_check ? kRigCheck
         : arguments.is_virtual   ? kVirtualTime
                                  : kWindow;
}

// Options that not all ways have.
constexpr std::array kOwnOptions{std::pair("--seed", kScript),
                                 std::pair("--time-scale", kScript),
                                 std::pair("--no-pictures", kScript | kVirtualTime),
                                 std::pair("--virtual-time", kVirtualTime | kRigCheck),
                                 std::pair("--settings", kWindow),
                                 std::pair("--pictures", kWindow),
                                 std::pair("--devices", kVirtualTime | kRigCheck | kWindow),
                                 std::pair("--seconds", kVirtualTime),
                                 std::pair("--record", kVirtualTime | kWindow),
                                 std::pair("--organ", kScript | kVirtualTime | kWindow),
                                 std::pair("--out", kScript | kVirtualTime | kWindow),
                                 std::pair("--executor", kScript | kVirtualTime | kWindow),
                                 std::pair("--paper", kScript | kVirtualTime | kWindow),
                                 std::pair("--detail", kScript | kVirtualTime | kWindow)};

void refuse_foreign_options(const CLI::App& app, const Arguments& arguments) {
  for (const auto& own : kOwnOptions) {
    if (app.count(own.first) > 0 && (own.second & way_of(arguments)) == 0) {
      std::string whose;
      for (const auto& way : kWays) {
        whose += (own.second & way.first) != 0
                     ? (whose.empty() ? "" : " and ") + std::string(way.second)
                     : "";
      }
      throw pbdsurg::InvalidArgument(std::string(own.first) + " is of " + whose);
    }
  }
}

}  // namespace

std::optional<Arguments> parse_arguments(int argument_count, const char* const* values) {
  CLI::App app(
      "A laparoscopic cholecystectomy, in a window to play with mouse and keyboard, or with "
      "--headless as a script: drag, burn, separate. Not a medical device, not validated.");
  app.footer(
      "Exit status: 0 done, with warnings or without; 1 a line of --rig-check failed, the tissue\n"
      "was lost, or the script touched nothing, burnt\n"
      "nothing, lost an organ or could not go on; 2 bad input; 130 interrupted, after writing "
      "what\n"
      "there is.");
  app.set_version_flag("--version", std::string("cholecystectomy, pbdsurg ") + pbdsurg::build_id());
  Arguments arguments;
  OrganFiles& files = arguments.organs;
  std::vector<std::string> organs;
  app.add_flag("--headless", arguments.is_headless,
               "run the scripted operation, without a window or a display");
  app.add_option(
         "--out", arguments.out,
         "folder for pictures, report.json, CSV files, series.pvd: they are written to "
         "run.part in it, and at the end replace the files that an earlier run's report "
         "lists; other files stay, and one of a name that a run may write is refused. Of the "
         "window: for screenshots")
      ->capture_default_str();
  app.add_option("--organ", organs, "NAME=FILE: use this mesh for an organ (repeatable)")
      ->allow_extra_args(false)
      ->type_name("");
  pbdsurg::add_unit_options(app, files.unit);
  app.add_flag("--keep-placement", files.keeps_placement,
               "move all these files by one motion, as those of one scan, not each into its place");
  pbdsurg::add_whole_number(app, "--max-tets", files.max_tets, pbdsurg::Index{1},
                            "most tetrahedra of one of these organs")
      ->default_str(std::to_string(files.max_tets));
  pbdsurg::add_whole_number(app, "--seed", arguments.seed, std::uint64_t{0}, "of the hands' tremor")
      ->default_str(std::to_string(arguments.seed));
  pbdsurg::add_number(
      app, "--time-scale", arguments.time_scale, "number from 0.01 to 10",
      [](double scale) { return scale >= 0.01 && scale <= 10; },
      "length of the operation relative to the full script")
      ->default_str("1");
  app.add_option("--executor", arguments.executor,
                 "who steps: best (a CUDA device where there is one), serial, threads, threads:N, "
                 "cuda or cuda:N")
      ->type_name("NAME")
      ->capture_default_str();
  app.add_flag("--no-pictures", arguments.no_pictures, "leave out pictures and plots");
  app.add_flag(
      "--paper", arguments.paper,
      "the paper's solver: one substep, 30 iterations, stiffness fractions, colours by the "
      "random colouring disc");
  pbdsurg::add_choice<std::optional<Detail>>(app, "--detail", arguments.detail,
                                             {{"full", Detail::full}, {"low", Detail::low}},
                                             "of the built-in organs; low: a third of the "
                                             "tetrahedra. By default full, of the window as its "
                                             "settings have it");
  app.add_option("--settings", arguments.settings,
                 "file in which the window keeps its settings, by default "
                 "~/.config/pbdsurg/cholecystectomy.json")
      ->type_name("FILE");
  pbdsurg::add_whole_number(app, "--pictures", arguments.pictures, std::int64_t{1},
                            "close the window after so many");
  app.add_option("--devices", arguments.devices,
                 "what hands hold: mouse; openhaptics or emulator, haptic arms; the file of a "
                 "device trace; one word for both hands or LEFT,RIGHT; or the file of a rig, see "
                 "docs/rig.md")
      ->type_name("NAME")
      ->capture_default_str();
  app.add_flag("--record", arguments.is_recorded,
               "at the end write what hands did to left.trace and right.trace in --out, for "
               "--devices to play again");
  app.add_flag("--virtual-time", arguments.is_virtual,
               "without a window, in one thread, the same bits each time: emulated or recorded "
               "hands operate, and hands.csv has what they would feel");
  app.add_flag("--rig-check", arguments.is_rig_check,
               "two minutes with a person at the terminal: devices, calibration, force, jaws, "
               "pedals, sound, pictures; prints a sheet to sign");
  pbdsurg::add_number(
      app, "--seconds", arguments.seconds, "number from 0.1 to 3600",
      [](double seconds) { return seconds >= 0.1 && seconds <= 3600; },
      "of virtual time, by default as long as scripts and traces are");
  try {
    app.parse(argument_count, values);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {  // --help
      app.exit(error);
      return std::nullopt;
    }
    throw pbdsurg::InvalidArgument(error.what());
  }
  if (organs.empty()) {
    for (const char* option : {"--unit", "--scale", "--keep-placement", "--max-tets"}) {
      if (app.count(option) > 0) {
        throw pbdsurg::InvalidArgument(std::string(option) + " needs --organ");
      }
    }
  }
  if (arguments.is_headless && arguments.is_rig_check) {
    throw pbdsurg::InvalidArgument("--headless and --rig-check: one or the other");
  }
  refuse_foreign_options(app, arguments);
  if (arguments.is_virtual && !arguments.is_rig_check && app.count("--devices") == 0) {
    arguments.devices = "emulator";  // a mouse needs a window
  }
  if (arguments.is_virtual && app.count("--executor") == 0) {
    arguments.executor = "serial";  // the same bits on all machines with this build
  }
  for (const std::string& organ : organs) {
    add_organ(organ, files);
  }
  return arguments;
}

}  // namespace cholecystectomy
