// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What the benchmarks of CPU and CUDA colour, and how they report it.

#include <map>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "pbdsurg/anatomy/cholecystectomy_anatomy.h"
#include "pbdsurg/coloring/color.h"
#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/mesh/topology.h"

#include "bench/support/sample_meshes.h"

namespace pbdsurg::bench {

struct SampleMesh {
  Tets mesh;
  std::vector<Edge> edges;
};

/// Made once.
///   lattice  24 tetrahedra at each inner vertex: the hard case
///   split    very irregular
///   organ    a liver of well-shaped tetrahedra
inline const SampleMesh& sample_mesh(const std::string& kind, Index tets) {
  static std::map<std::pair<std::string, Index>, SampleMesh> meshes;
  const auto [entry, is_new] = meshes.try_emplace({kind, tets});
  if (is_new) {
    Tets& mesh = entry->second.mesh;
    if (kind == "lattice") {
      Index side = 1;
      while (6 * side * side * side < tets) {
        ++side;
      }
      mesh = lattice_mesh(side);
    } else if (kind == "split") {
      mesh = split_mesh(tets);
    } else {
      OrganRecipe liver = organ_recipe(Organ::liver);
      liver.options.spacing = 0;
      liver.options.vertex_count = tets / 11 * 2;
      const TetMesh organ = tetrahedralize(liver.shape, liver.options).mesh;
      mesh = {{organ.tets().begin(), organ.tets().end()}, organ.vertex_count()};
    }
    entry->second.edges = find_edges(mesh.tets);
  }
  return entry->second;
}

struct ColoringSample {
  std::string kind;
  Index tets;
  bool edges;

  [[nodiscard]] std::string name() const {
    return kind + "/" + std::to_string(tets) + "/" + (edges ? "edges" : "tets");
  }
  [[nodiscard]] ConstraintVertices constraints() const {
    const SampleMesh& sample = sample_mesh(kind, tets);
    if (edges) {
      return {std::span<const Edge>(sample.edges), sample.mesh.vertex_count};
    }
    return sample.mesh.view();
  }
};

inline std::vector<ColoringSample> coloring_samples() {
  std::vector<ColoringSample> samples;
  for (const bool edges : {false, true}) {
    for (const Index tets : {10'000, 100'000, 1'000'000}) {
      samples.push_back({"lattice", tets, edges});
      samples.push_back({"split", tets, edges});
      samples.push_back({"organ", tets, edges});
    }
  }
  return samples;
}

struct NamedColoring {
  std::string name;
  ColoringOptions options;
};

/// Each parallel algorithm plain, and with all that is done to it.
inline std::vector<NamedColoring> parallel_colorings() {
  std::vector<NamedColoring> result;
  const auto add = [&](ColoringAlgorithm algorithm, bool repair, bool balance) {
    ColoringOptions options;
    options.algorithm = algorithm;
    options.repair = repair;
    options.balance = balance;
    result.push_back(
        {std::string(name_of(algorithm)) + (repair ? "+repair" : "") + (balance ? "+balance" : ""),
         options});
  };
  for (const ColoringAlgorithm algorithm :
       {ColoringAlgorithm::greedy, ColoringAlgorithm::luby, ColoringAlgorithm::jones_plassmann,
        ColoringAlgorithm::random_disc}) {
    add(algorithm, false, false);
  }
  for (const ColoringAlgorithm algorithm :
       {ColoringAlgorithm::greedy, ColoringAlgorithm::random_disc}) {
    add(algorithm, false, true);
    add(algorithm, true, false);
    add(algorithm, true, true);
  }
  return result;
}

/// Colours beside their bound; fails on an invalid colouring.
inline void report_coloring(benchmark::State& state, const ConstraintVertices& constraints,
                            const Coloring& coloring) {
  const ColoringStatistics statistics = measure_coloring(coloring, constraints);
  state.counters["constraints"] = statistics.constraints;
  state.counters["colors"] = statistics.colors;
  state.counters["clique_bound"] = statistics.clique_bound;
  state.counters["rsd"] = statistics.relative_deviation;
  state.counters["max_over_mean"] = statistics.max_over_mean;
  if (find_conflict(coloring, constraints)) {
    state.SkipWithError("the colouring is not valid");
  }
}

}  // namespace pbdsurg::bench
