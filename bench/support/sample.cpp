// SPDX-License-Identifier: Apache-2.0
#include "bench/support/sample.h"

#include "pbdsurg/base/error.h"
#include "pbdsurg/coloring/edge_ownership.h"

namespace pbdsurg::bench {

Sample::Sample(int table2_row, Table2Kind table2_kind)
    : row(table2_row),
      kind(table2_kind),
      mesh(table2_mesh(row, kind)),
      edges(find_edges(mesh.tets())),
      max_owned(
          assign_edges_to_tets(static_cast<Index>(edges.size()), find_tet_edges(mesh.tets(), edges))
              .max_owned) {}

const char* name_of(Table2Kind kind) noexcept {
  return kind == Table2Kind::hollow ? "hollow" : "surface_filled";
}

std::list<Sample> make_samples(const std::vector<int>& rows, const std::vector<Table2Kind>& kinds,
                               std::vector<std::string>& notes) {
  std::list<Sample> samples;
  for (const Table2Kind kind : kinds) {
    try {
      for (const int row : rows) {
        samples.emplace_back(row, kind);
      }
    } catch (const BackendUnavailable& error) {
      notes.push_back(std::string(name_of(kind)) + " is left out: " + error.what());
    }
  }
  return samples;
}

}  // namespace pbdsurg::bench
