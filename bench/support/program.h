// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What main() of a program that makes a table does.

#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <functional>
#include <thread>

#include <CLI/CLI.hpp>

namespace pbdsurg::bench {

/// Adds `--threads`.
inline void add_threads_option(CLI::App& app, int& threads) {
  app.add_option("--threads", threads, "of the threaded backend; 0: one a processor")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
}

/// What it asks for.
inline int thread_count(int threads) {
  return threads > 0 ? threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

/// Reads the arguments, makes the folder `out`, runs.
/// @return  the exit status; 2 after an error, which is printed
inline int run_program(CLI::App& app, int argc, char** argv, std::filesystem::path& out,
                       const std::function<void()>& run) {
  app.add_option("--out", out, "folder for the files that this writes")->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    std::filesystem::create_directories(out);
    run();
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", app.get_name().c_str(), error.what());
    return 2;
  }
}

}  // namespace pbdsurg::bench
