// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/coloring/color.h"

#include <chrono>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/write_file.h"
#include "pbdsurg/coloring/conflict_graph.h"
#include "pbdsurg/coloring/edge_ownership.h"
#include "pbdsurg/mesh/read.h"

#include "apps/pbdsurg/commands.h"
#include "apps/pbdsurg/mesh_file.h"
#include "apps/pbdsurg/options.h"
#include "apps/support/executors.h"

namespace pbdsurg {
namespace {

enum class Kind { distance, volume, joint, vertex };

struct ColorOptions {
  std::string path;
  Kind kind = Kind::volume;
  ColoringOptions coloring;
  std::string executor = "threads:1";
  UnitOptions unit;
  std::string output;
  std::string graph;
  bool json = false;
};

const char* name_of(Kind kind) {
  switch (kind) {
    case Kind::distance:
      return "distance";
    case Kind::volume:
      return "volume";
    case Kind::joint:
      return "joint";
    case Kind::vertex:
      return "vertex";
  }
  return "unknown";
}

// What two constraints that conflict have in common.
const char* shared_by(Kind kind) {
  return kind == Kind::vertex ? "tet" : "vertex";
}

const char* name_of(Palette palette) {
  return palette == Palette::clique_bound ? "clique_bound" : "conflicts";
}

// What is to be coloured, with the arrays that the view looks into beside the mesh's own.
struct Constraints {
  std::vector<Edge> edges;
  IndexLists vertex_tets;
  std::optional<int> max_owned;  // edges of one tet, of joint constraints
  ConstraintVertices view;
};

Constraints find_constraints(Kind kind, const TetMesh& mesh) {
  Constraints result;
  result.view = {mesh.tets(), mesh.vertex_count()};
  switch (kind) {
    case Kind::distance:
      result.edges = find_edges(mesh.tets());
      result.view = {std::span<const Edge>(result.edges), mesh.vertex_count()};
      break;
    case Kind::volume:
      break;
    case Kind::joint: {
      const std::vector<Edge> edges = find_edges(mesh.tets());
      result.max_owned =
          assign_edges_to_tets(static_cast<Index>(edges.size()), find_tet_edges(mesh.tets(), edges))
              .max_owned;
      break;
    }
    case Kind::vertex:
      result.vertex_tets = find_vertex_constraints(result.view);
      result.view = {result.vertex_tets, mesh.tet_count()};
      break;
  }
  return result;
}

struct Timed {
  Coloring coloring;
  double milliseconds;
  std::string executor;  // who worked
};

Timed color(const ColorOptions& options, const ConstraintVertices& constraints) {
  ColoringOptions how = options.coloring;
  how.executor = programs::executor_named(options.executor);
  if (how.executor.kind() == ExecutorKind::device) {
    // the first call also starts the driver and loads the kernels, a hundred times as long
    (void)color_constraints(constraints, how);
  }
  const auto start = std::chrono::steady_clock::now();
  Coloring coloring = color_constraints(constraints, how);
  const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - start;
  return {std::move(coloring), time.count(), how.executor.name()};
}

void write_colors(const std::string& path, const Coloring& coloring) {
  std::string lines;
  for (const Index color : coloring.color_of) {
    lines += std::to_string(color) + '\n';
  }
  write_file(path, lines);
}

void write_graph(const ColorOptions& options, const ConstraintVertices& constraints) {
  const std::string comment = std::string(name_of(options.kind)) + " constraints of " +
                              std::filesystem::path(options.path).filename().string() +
                              ": an entry is a pair that shares a " + shared_by(options.kind);
  write_file(options.graph,
             [&](std::ostream& stream) { write_conflict_graph(stream, constraints, comment); });
}

nlohmann::ordered_json to_json(const ColorOptions& options, const Constraints& constraints,
                               const ColoringStatistics& statistics, const Timed& timed,
                               bool valid) {
  nlohmann::ordered_json json{{"constraints", statistics.constraints},
                              {"colors", statistics.colors},
                              {"clique_bound", statistics.clique_bound},
                              {"rsd", statistics.relative_deviation},
                              {"top10", statistics.top10},
                              {"mid80", statistics.mid80},
                              {"last10", statistics.last10},
                              {"ms", timed.milliseconds},
                              {"valid", valid},
                              {"max_over_mean", statistics.max_over_mean},
                              {"overflow", statistics.overflow},
                              {"algorithm", name_of(options.coloring.algorithm)}};
  if (options.coloring.algorithm == ColoringAlgorithm::greedy) {
    json["order"] = name_of(options.coloring.order);
  }
  json["executor"] = timed.executor;
  json["seed"] = options.coloring.seed;
  if (constraints.max_owned) {
    json["max_owned"] = *constraints.max_owned;
  }
  return json;
}

void print_text(const ColorOptions& options, const Constraints& constraints,
                const ColoringStatistics& statistics, const Timed& timed) {
  std::cout.precision(3);
  std::cout << options.path << ": " << statistics.constraints << ' ' << name_of(options.kind)
            << " constraints\n"
            << "  colours             " << statistics.colors
            << "; without anything left over, at least " << statistics.clique_bound << '\n'
            << "  sizes               deviate by " << 100 * statistics.relative_deviation
            << " % from their mean; the largest is " << statistics.max_over_mean << " times it\n"
            << "  shares              " << 100 * statistics.top10 << " % in the largest tenth, "
            << 100 * statistics.last10 << " % in the smallest tenth of the colours\n"
            << "  left over           " << statistics.overflow << '\n';
  if (constraints.max_owned) {
    std::cout << "  edges of one tet    " << *constraints.max_owned << " at most\n";
  }
  std::cout << "  time                " << timed.milliseconds << " ms, "
            << name_of(options.coloring.algorithm) << " on " << timed.executor << '\n';
}

/// @return  whether the colouring is valid
bool run(const ColorOptions& options) {
  for (const std::string& output : {options.output, options.graph}) {
    check_is_not_input(options.path, output);
  }
  const TetMesh mesh = to_tet_mesh(read_with_unit(options.path, options.unit).mesh, options.path);
  const Constraints constraints = find_constraints(options.kind, mesh);
  const Timed timed = color(options, constraints.view);
  const Coloring& coloring = timed.coloring;
  const std::optional<ColorConflict> conflict = find_conflict(coloring, constraints.view);
  const ColoringStatistics statistics = measure_coloring(coloring, constraints.view);
  if (!options.output.empty()) {
    write_colors(options.output, coloring);
  }
  if (!options.graph.empty()) {
    write_graph(options, constraints.view);
  }
  if (options.json) {
    std::cout << to_json(options, constraints, statistics, timed, !conflict).dump(2) << '\n';
  } else {
    print_text(options, constraints, statistics, timed);
  }
  if (conflict) {
    std::cerr << "pbdsurg: " << options.path << ": constraints " << conflict->first << " and "
              << conflict->second << " of colour " << conflict->color << " share "
              << shared_by(options.kind) << ' ' << conflict->vertex << '\n';
  }
  return !conflict;
}

template <class T>
std::vector<std::pair<std::string, T>> by_name(std::initializer_list<T> values) {
  std::vector<std::pair<std::string, T>> result;
  for (const T value : values) {
    result.emplace_back(name_of(value), value);
  }
  return result;
}

// An option that would change nothing is a mistake.
void require(bool condition, const CLI::Option& option, const std::string& needed) {
  if (option.count() > 0 && !condition) {
    throw InvalidArgument(option.get_name() + ' ' + option.results().front() + " is for " + needed +
                          " only");
  }
}

}  // namespace

void add_color(CLI::App& app, int& status) {
  CLI::App& command = *app.add_subcommand(
      "color", "Colour the constraints of a mesh; exit status 1 if two of one colour conflict");
  const auto options = std::make_shared<ColorOptions>();
  ColoringOptions& coloring = options->coloring;
  command.add_option("file", options->path, "Mesh of tetrahedra")->required();
  add_choice(command, "--constraints", options->kind,
             by_name({Kind::distance, Kind::volume, Kind::joint, Kind::vertex}),
             "Edges; tets; tets that own their edges; vertices with all tets around them")
      ->required();
  add_choice(command, "--algorithm", coloring.algorithm,
             by_name({ColoringAlgorithm::greedy, ColoringAlgorithm::luby,
                      ColoringAlgorithm::jones_plassmann, ColoringAlgorithm::random_disc}),
             "Default: greedy");
  const CLI::Option* order =
      add_choice(command, "--order", coloring.order,
                 by_name({GreedyOrder::natural, GreedyOrder::largest_valence,
                          GreedyOrder::smallest_last, GreedyOrder::saturation}),
                 "Of greedy (default: natural)");
  command.add_flag("--repair", coloring.repair, "Then move constraints out of the highest colours");
  command.add_flag("--balance", coloring.balance, "Then make the colours equally large");
  add_whole_number(command, "--max-colors", coloring.max_colors, 1,
                   "Keep so many colours and leave the rest over");
  const CLI::Option* palette =
      add_choice(command, "--palette", coloring.disc.palette,
                 by_name({Palette::clique_bound, Palette::conflicts}),
                 "Of random_disc: where it starts (default: clique_bound)");
  const CLI::Option* shrink =
      command
          .add_option("--shrink", coloring.disc.shrink, "Of this palette, from 1 on (default: 2)")
          ->type_name("S");
  command
      .add_option("--executor", options->executor,
                  "best, serial, threads:N, cuda or cuda:N (default: threads:1); the colours are "
                  "the same")
      ->type_name("NAME");
  add_whole_number<std::uint64_t>(command, "--seed", coloring.seed, 0, "Default: 0");
  add_unit_options(command, options->unit);
  const CLI::Validator names_a_file(
      [](const std::string& path) {
        return path.empty() ? std::string("must name a file") : std::string();
      },
      "FILE");
  command
      .add_option("--output", options->output,
                  "Write one colour a line, -1 where left over; of joint constraints, those of the "
                  "tets")
      ->check(names_a_file);
  command
      .add_option(
          "--graph", options->graph,
          "Write which constraints conflict, in Matrix Market format; of joint constraints, "
          "the tets")
      ->check(names_a_file);
  command.add_flag("--json", options->json, "Print JSON");
  command.callback([options, order, palette, shrink, &status] {
    const ColoringAlgorithm algorithm = options->coloring.algorithm;
    require(algorithm == ColoringAlgorithm::greedy, *order, "--algorithm greedy");
    require(algorithm == ColoringAlgorithm::random_disc, *palette, "--algorithm random_disc");
    require(algorithm == ColoringAlgorithm::random_disc &&
                options->coloring.disc.palette == Palette::conflicts,
            *shrink, "--algorithm random_disc --palette conflicts");
    if (!options->graph.empty() && options->graph == options->output) {
      throw InvalidArgument("--graph and --output both name " + options->graph);
    }
    status = run(*options) ? 0 : 1;
  });
}

}  // namespace pbdsurg
