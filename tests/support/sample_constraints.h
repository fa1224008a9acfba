// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Constraints to colour in tests.

#include <algorithm>
#include <array>
#include <set>
#include <string>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/coloring/coloring.h"
#include "pbdsurg/mesh/topology.h"

#include "tests/support/meshes.h"

namespace pbdsurg::testing {

/// A set of constraints that owns its vertices.
struct SampleConstraints {
  std::string name;
  int arity = 0;  ///< 0: varying
  IndexLists lists;
  Index vertex_count = 0;

  [[nodiscard]] ConstraintVertices view() const {
    ConstraintVertices result(lists, vertex_count);
    if (arity > 0) {
      result.offsets = {};
      result.arity = arity;
    }
    return result;
  }
};

template <std::size_t kArity>
SampleConstraints make_sample(const std::string& name,
                              std::span<const std::array<Index, kArity>> constraints,
                              Index vertex_count) {
  SampleConstraints sample{name, static_cast<int>(kArity), {}, vertex_count};
  for (const auto& ids : constraints) {
    sample.lists.entries.insert(sample.lists.entries.end(), ids.begin(), ids.end());
    sample.lists.offsets.push_back(static_cast<Index>(sample.lists.entries.size()));
  }
  return sample;
}

/// Constraints over random vertices that lie close together, some vertices far more popular than
/// others: valences as uneven as in bad meshes.
/// @param arity  0: 1 to 7 vertices each
inline SampleConstraints random_sample(const std::string& name, Index count, Index vertex_count,
                                       int arity, std::uint64_t seed) {
  SampleConstraints sample{name, arity, {}, vertex_count};
  for (Index c = 0; c < count; ++c) {
    const auto size = static_cast<std::size_t>(
        arity > 0 ? arity : 1 + static_cast<int>(random_bits(seed, c, 999) % 7));
    std::set<Index> ids;
    const double start = random_unit(seed, c, 0) * vertex_count;
    for (std::uint64_t draw = 1; ids.size() < size; ++draw) {
      const double u = random_unit(seed, c, draw);
      const auto id = static_cast<Index>(start + 40 * u * u) % vertex_count;
      ids.insert(random_bits(seed, c, draw) % 16 == 0 ? id - id % 16 : id);
    }
    sample.lists.entries.insert(sample.lists.entries.end(), ids.begin(), ids.end());
    sample.lists.offsets.push_back(static_cast<Index>(sample.lists.entries.size()));
  }
  return sample;
}

/// Constraints of six vertices out of little more than as many: colourings stay above the bound.
inline SampleConstraints crowded_sample(std::uint64_t seed) {
  const auto draw = [&](std::uint64_t element, std::uint64_t round, Index below) {
    return static_cast<Index>(random_bits(seed, element, round) %
                              static_cast<std::uint64_t>(below));
  };
  constexpr std::size_t kArity = 6;
  SampleConstraints sample{"crowded", kArity, {}, 40 + draw(0, 1, 400)};
  const Index count = 600 + draw(0, 2, 2500);
  for (Index c = 0; c < count; ++c) {
    const Index start = draw(c, 3, sample.vertex_count);
    const Index span = 8 + draw(c, 4, 8);
    std::set<Index> ids;
    for (std::uint64_t round = 5; ids.size() < kArity; ++round) {
      ids.insert((start + draw(c, round, span)) % sample.vertex_count);
    }
    sample.lists.entries.insert(sample.lists.entries.end(), ids.begin(), ids.end());
    sample.lists.offsets.push_back(static_cast<Index>(sample.lists.entries.size()));
  }
  return sample;
}

/// Edges from one vertex to all others.
inline SampleConstraints hub_sample(Index spokes) {
  std::vector<Edge> edges;
  for (Index i = 1; i <= spokes; ++i) {
    edges.push_back({0, i});
  }
  return make_sample<2>("hub of " + std::to_string(spokes), edges, spokes + 1);
}

/// What an algorithm must cope with.
inline std::vector<SampleConstraints> all_samples() {
  const TetMesh box = make_box({9, 7, 6}, 1e-3, 0.1);
  const std::vector<Edge> edges = find_edges(box.tets());
  // the same box twice, joined by nothing
  std::vector<Tet> twins(box.tets().begin(), box.tets().end());
  for (const Tet& tet : box.tets()) {
    twins.push_back(tet);
    for (Index& v : twins.back()) {
      v += box.vertex_count();
    }
  }
  std::vector<SampleConstraints> samples{
      make_sample<2>("nothing", {}, 5),
      make_sample<4>("nothing at no vertex", {}, 0),
      make_sample<4>("one tet", std::vector<Tet>{{3, 1, 0, 2}}, 4),
      make_sample<4>("tets of a lattice", box.tets(), box.vertex_count()),
      make_sample<2>("edges of a lattice", std::span<const Edge>(edges), box.vertex_count()),
      make_sample<4>("two bodies", std::span<const Tet>(twins), 2 * box.vertex_count()),
      random_sample("random edges", 4000, 700, 2, 1),
      random_sample("random tets", 3000, 700, 4, 2),
      random_sample("more than 256 colours", 4000, 90, 4, 3),
      random_sample("random triangles", 2000, 500, 3, 4),
      random_sample("single vertices", 300, 50, 1, 5),
      random_sample("varying arity", 2500, 900, 0, 6),
      hub_sample(300),
  };
  // constraints that touch nothing, alone and among others
  samples.push_back({"no vertices in a set of none", 0, {{0, 0, 0, 0}, {}}, 0});
  samples.push_back({"no vertices in a set of five", 0, {{0, 0, 0, 0}, {}}, 5});
  samples.push_back({"some without vertices", 0, {{0, 0, 2, 2, 3, 6}, {0, 1, 0, 2, 1, 0}}, 5});
  // vertex blocks: no colouring comes down to their bound
  samples.push_back({"vertex blocks", 0,
                     find_vertex_constraints(ConstraintVertices(box.tets(), box.vertex_count())),
                     box.tet_count()});
  return samples;
}

/// Whether colours are 0 .. color_count - 1, each of them used.
inline bool has_no_gap(const Coloring& coloring) {
  const std::vector<Index> sizes = color_sizes(coloring);
  return std::find(sizes.begin(), sizes.end(), 0) == sizes.end();
}

/// Whether every constraint has a neighbour of each lower colour: true of first fit in any order
/// and of maximal independent sets.
inline bool leaves_no_lower_color_free(const Coloring& coloring,
                                       const ConstraintVertices& constraints) {
  std::vector<std::set<Index>> seen(static_cast<std::size_t>(constraints.vertex_count));
  for (Index c = 0; c < constraints.constraint_count(); ++c) {
    for (const Index v : constraints[c]) {
      seen[v].insert(coloring.color_of[c]);
    }
  }
  for (Index c = 0; c < constraints.constraint_count(); ++c) {
    std::set<Index> near;
    for (const Index v : constraints[c]) {
      near.insert(seen[v].begin(), seen[v].lower_bound(coloring.color_of[c]));
    }
    if (static_cast<Index>(near.size()) != coloring.color_of[c]) {
      return false;
    }
  }
  return true;
}

}  // namespace pbdsurg::testing
