// SPDX-License-Identifier: Apache-2.0
// Colours the tets of a mesh, then visits them on two threads, colour by colour, without atomics.
#include "pbdsurg/coloring/color.h"

#include <cstdio>
#include <exception>
#include <numeric>
#include <thread>
#include <vector>

#include "pbdsurg/anatomy/table2_family.h"
#include "pbdsurg/mesh/read.h"

int main(int argc, char** argv) try {
  const pbdsurg::TetMesh organ =
      argc > 1 ? pbdsurg::read_tet_mesh(argv[1]) : pbdsurg::table2_mesh(1);

  const pbdsurg::ConstraintVertices constraints(organ.tets(), organ.vertex_count());
  const pbdsurg::Coloring coloring =
      pbdsurg::color_constraints(constraints, {.repair = true, .balance = true});
  const pbdsurg::ColoringStatistics found = pbdsurg::measure_coloring(coloring, constraints);
  std::printf("%d tets in %d colours (the bound is %d), sizes deviate by %.1f %%\n",
              found.constraints, found.colors, found.clique_bound, 100 * found.relative_deviation);

  std::vector<std::vector<pbdsurg::Tet>> phases(coloring.color_count);
  for (pbdsurg::Index tet = 0; tet < organ.tet_count(); ++tet) {
    phases[coloring.color_of[tet]].push_back(organ.tets()[tet]);
  }
  std::vector<double> share(organ.vertex_count());  // m^3, a quarter of each tet around a vertex
  for (const std::vector<pbdsurg::Tet>& phase : phases) {
    const auto visit = [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        for (const pbdsurg::Index vertex : phase[i]) {  // in no other tet of this phase
          share[vertex] += pbdsurg::tet_volume(organ.positions(), phase[i]) / 4;
        }
      }
    };
    const std::jthread other(visit, 0, phase.size() / 2);
    visit(phase.size() / 2, phase.size());
  }
  std::printf("%.3f ml in all\n", 1e6 * std::accumulate(share.begin(), share.end(), 0.0));
} catch (const std::exception& error) {
  std::fprintf(stderr, "color: %s\n", error.what());
  return 2;
}
