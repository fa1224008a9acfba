// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/coloring/conflict_graph.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

namespace pbdsurg {
namespace {

// The constraints before this one that share a vertex with it, rising.
// @param at_vertex  find_vertex_constraints()
void find_lower_conflicts(const ConstraintVertices& constraints, const IndexLists& at_vertex,
                          Index constraint, std::vector<Index>& found) {
  found.clear();
  for (const Index v : constraints[constraint]) {
    for (Index i = at_vertex.offsets[v]; at_vertex.entries[i] < constraint; ++i) {
      found.push_back(at_vertex.entries[i]);
    }
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
}

template <class Number>
void append(std::string& text, Number number, char end) {
  std::array<char, 24> digits;
  const auto result = std::to_chars(digits.data(), digits.data() + digits.size(), number);
  text.append(digits.data(), result.ptr);
  text += end;
}

}  // namespace

void write_conflict_graph(std::ostream& out, const ConstraintVertices& constraints,
                          std::string_view comment) {
  const IndexLists at_vertex = find_vertex_constraints(constraints);
  const Index count = constraints.constraint_count();
  std::vector<Index> conflicts;
  std::int64_t conflict_count = 0;
  for (Index c = 0; c < count; ++c) {
    find_lower_conflicts(constraints, at_vertex, c, conflicts);
    conflict_count += static_cast<std::int64_t>(conflicts.size());
  }
  std::string text = "%%MatrixMarket matrix coordinate pattern symmetric\n% ";
  for (const char character : comment) {
    // some readers end a line at other control characters, too
    text += character == '\n' || static_cast<unsigned char>(character) >= ' ' ? character : ' ';
    text += character == '\n' ? "% " : "";
  }
  text += '\n';
  append(text, count, ' ');
  append(text, count, ' ');
  append(text, conflict_count, '\n');
  constexpr std::size_t kEnough = 1 << 16;
  for (Index c = 0; c < count; ++c) {
    find_lower_conflicts(constraints, at_vertex, c, conflicts);
    for (const Index other : conflicts) {
      append(text, c + 1, ' ');
      append(text, other + 1, '\n');
    }
    if (text.size() > kEnough) {
      out << text;
      text.clear();
    }
  }
  out << text;
}

}  // namespace pbdsurg
