// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/coarse_choice.h"

#include <vector>

#include "lib/base/disjoint_sets.h"
#include "lib/solver/methods/coarse_kernel.h"

namespace pbdsurg {

bool leads_to_sheet(const Tissue& tissue, Index link) {
  const Link& ends = tissue.links()[link];
  return !tissue.triangles_at(ends.first).empty() || !tissue.triangles_at(ends.second).empty();
}

bool has_node_for_each_piece(const Tissue& tissue) {
  DisjointSets pieces(static_cast<std::size_t>(tissue.vertex_count()));
  std::vector<bool> is_joined(static_cast<std::size_t>(tissue.vertex_count()), false);
  const auto join = [&](Index a, Index b) {
    pieces.join(static_cast<std::size_t>(a), static_cast<std::size_t>(b));
    is_joined[a] = is_joined[b] = true;
  };
  for (Index e = 0; e < static_cast<Index>(tissue.edges().size()); ++e) {
    if (tissue.is_edge_alive(e)) {
      join(tissue.edges()[e][0], tissue.edges()[e][1]);
    }
  }
  for (Index l = 0; l < static_cast<Index>(tissue.links().size()); ++l) {
    if (tissue.is_link_alive(l) && !leads_to_sheet(tissue, l)) {
      join(tissue.links()[l].first, tissue.links()[l].second);
    }
  }
  Index free = 0, piece_count = 0;
  std::vector<bool> is_known(is_joined.size(), false);
  for (Index v = 0; v < tissue.vertex_count(); ++v) {
    if (!(tissue.masses()[v] > 0) || tissue.is_fixed(v)) {
      continue;
    }
    ++free;
    const std::size_t piece = pieces.root(static_cast<std::size_t>(v));
    if (is_joined[v] && !is_known[piece]) {
      is_known[piece] = true;
      ++piece_count;
    }
  }
  return piece_count <= most_nodes(free);
}

CoarseCorrection coarse_correction_for(const Tissue& tissue, const SolverOptions& options) {
  if (options.coarse_correction != CoarseCorrection::automatic) {
    return options.coarse_correction;
  }
  const bool follows_a_rule = options.iterations == kAutomatic ||
                              (options.substeps == kAutomatic && options.iterations > 1);
  return options.method == SolverMethod::vertex_block && follows_a_rule &&
                 has_node_for_each_piece(tissue)
             ? CoarseCorrection::on
             : CoarseCorrection::off;
}

}  // namespace pbdsurg
