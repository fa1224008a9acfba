// SPDX-License-Identifier: Apache-2.0
// Table 1 of Pan et al. 2020, and figure 8: the organ's constraints, coloured by every algorithm.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <list>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "pbdsurg/core/error.h"

#include "figure8.h"
#include "gpu_coloring.h"
#include "measure.h"
#include "report.h"

namespace pbdsurg::bench {
namespace {

struct Arguments {
  std::filesystem::path out = "out/tables";
  bool no_pictures = false;
  bool quick = false;
};

void draw_pictures(const std::list<Sample>& samples, const std::filesystem::path& folder) {
  try {
    for (const Sample& sample : samples) {
      std::fprintf(stderr, "drew %s\n", draw_figure8(sample, folder).c_str());
    }
  } catch (const BackendUnavailable& error) {
    std::fprintf(stderr, "no pictures: %s\n", error.what());
  }
}

void run(const Arguments& arguments) {
  std::filesystem::create_directories(arguments.out);
  std::vector<std::string> notes{"CUDA: " + describe_gpu()};
  std::list<Sample> samples;
  if (arguments.quick) {
    samples.emplace_back(1, Table2Kind::hollow);
  } else {
    samples.emplace_back(2, Table2Kind::hollow);
    try {
      samples.emplace_back(2, Table2Kind::surface_filled);
    } catch (const BackendUnavailable& error) {
      notes.push_back(std::string("surface_filled is left out: ") + error.what());
    }
  }
  const Repetitions repetitions = arguments.quick ? Repetitions{1, 1} : Repetitions{15, 25};
  std::vector<Row> rows;
  for (const Sample& sample : samples) {
    const std::vector<Row> measured = measure(sample, repetitions);
    rows.insert(rows.end(), measured.begin(), measured.end());
  }
  const nlohmann::ordered_json json = to_json(rows);
  const std::string markdown = to_markdown(json, notes);
  std::fputs(markdown.c_str(), stdout);
  write_text(arguments.out / "table1.md", markdown);
  write_text(arguments.out / "table1.csv", to_csv(json));
  merge_into_json(arguments.out / "tables.json", "table1", json);
  if (!arguments.no_pictures) {
    draw_pictures(samples, arguments.out);
  }
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  CLI::App app("Table 1 and figure 8: an organ's constraints, coloured by every algorithm.");
  pbdsurg::bench::Arguments arguments;
  app.add_option("--out", arguments.out, "folder for table1.md, table1.csv, tables.json, pictures")
      ->capture_default_str();
  app.add_flag("--no-pictures", arguments.no_pictures, "leave out figure 8");
  app.add_flag("--quick", arguments.quick, "the smallest mesh, everything once: to see it work");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    pbdsurg::bench::run(arguments);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "table1: %s\n", error.what());
    return 2;
  }
}
