// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/coloring/constraint_vertices.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"

#include "lib/coloring/constraint_access.h"
#include "lib/coloring/valences.h"

namespace pbdsurg {
namespace {

// The part of check_constraints() that does not look at every id.
void check_shape(const ConstraintVertices& constraints) {
  if (constraints.vertex_count < 0 || constraints.arity < 0) {
    throw InvalidArgument(std::to_string(constraints.vertex_count) + " vertices and " +
                          std::to_string(constraints.arity) +
                          " vertices a constraint: neither can be negative");
  }
  // a little less than an Index holds, so that loops may step past the end
  constexpr std::size_t kLargest = (std::size_t{1} << 31) - (std::size_t{1} << 24);
  for (const std::size_t size : {constraints.vertices.size(), constraints.offsets.size()}) {
    if (size > kLargest) {
      throw InvalidArgument(std::to_string(size) +
                            " constraints or vertices named by them; there can be at most " +
                            std::to_string(kLargest));
    }
  }
  if (constraints.arity > 0) {
    if (constraints.vertices.size() % static_cast<std::size_t>(constraints.arity) != 0) {
      throw InvalidArgument(std::to_string(constraints.vertices.size()) +
                            " ids do not make constraints of " + std::to_string(constraints.arity) +
                            " vertices each");
    }
    return;
  }
  const std::span<const Index> offsets = constraints.offsets;
  if (offsets.empty() || offsets.front() != 0 ||
      static_cast<std::size_t>(offsets.back()) != constraints.vertices.size() ||
      !std::is_sorted(offsets.begin(), offsets.end())) {
    throw InvalidArgument("offsets of constraints must rise from 0 to the " +
                          std::to_string(constraints.vertices.size()) + " ids there are");
  }
}

[[noreturn]] void refuse_vertex(Index constraint, Index vertex, Index vertex_count) {
  throw InvalidArgument("constraint " + std::to_string(constraint) + " refers to vertex " +
                        std::to_string(vertex) + "; ids must be in [0, " +
                        std::to_string(vertex_count) + ")");
}

[[noreturn]] void refuse_repetition(Index constraint, Index vertex) {
  throw InvalidArgument("constraint " + std::to_string(constraint) + " lists vertex " +
                        std::to_string(vertex) + " twice; its vertices must differ");
}

template <int kArity>
void check_ids(const FixedArity<kArity>& constraints, Index vertex_count) {
  for (Index c = 0; c < constraints.count; ++c) {
    const auto ids = constraints[c];
    for (int i = 0; i < kArity; ++i) {
      if (ids[i] < 0 || ids[i] >= vertex_count) {
        refuse_vertex(c, ids[i], vertex_count);
      }
      for (int j = 0; j < i; ++j) {
        if (ids[i] == ids[j]) {
          refuse_repetition(c, ids[i]);
        }
      }
    }
  }
}

void check_ids(const AnyArity& constraints, Index vertex_count) {
  std::vector<Index> last(static_cast<std::size_t>(vertex_count), kInvalidIndex);
  for (Index c = 0; c < constraints.count; ++c) {
    for (const Index v : constraints[c]) {
      if (v < 0 || v >= vertex_count) {
        refuse_vertex(c, v, vertex_count);
      }
      if (last[v] == c) {
        refuse_repetition(c, v);
      }
      last[v] = c;
    }
  }
}

}  // namespace

std::vector<Index> count_valences(const ConstraintVertices& constraints) {
  std::vector<Index> valence(static_cast<std::size_t>(constraints.vertex_count), 0);
  for (const Index v : constraints.vertices) {
    ++valence[v];
  }
  return valence;
}

void check_constraints(const ConstraintVertices& constraints) {
  check_shape(constraints);
  with_arity(constraints, [&](const auto& access) { check_ids(access, constraints.vertex_count); });
}

Index clique_bound(const ConstraintVertices& constraints) {
  check_constraints(constraints);
  const std::vector<Index> valence = count_valences(constraints);
  return valence.empty() ? 0 : *std::max_element(valence.begin(), valence.end());
}

IndexLists find_vertex_constraints(const ConstraintVertices& constraints) {
  check_constraints(constraints);
  IndexLists lists;
  lists.offsets.assign(static_cast<std::size_t>(constraints.vertex_count) + 1, 0);
  const std::vector<Index> valence = count_valences(constraints);
  std::partial_sum(valence.begin(), valence.end(), lists.offsets.begin() + 1);
  lists.entries.resize(constraints.vertices.size());
  std::vector<Index> next(lists.offsets.begin(), lists.offsets.end() - 1);
  with_arity(constraints, [&](const auto& access) {
    for (Index c = 0; c < access.count; ++c) {
      for (const Index v : access[c]) {
        lists.entries[next[v]++] = c;
      }
    }
  });
  return lists;
}

}  // namespace pbdsurg
