// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/coloring/conflict_graph.h"

#include <algorithm>
#include <cstdint>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"

#include "tests/support/catch.h"
#include "tests/support/sample_constraints.h"

namespace pbdsurg {
namespace {

using testing::ContainsSubstring;

// Reads what it says, knowing nothing of constraints.
struct PatternMatrix {
  std::string banner;
  std::int64_t rows = 0, columns = 0, entry_count = 0;
  std::vector<std::pair<Index, Index>> entries;

  explicit PatternMatrix(const std::string& text) {
    std::istringstream in(text);
    std::getline(in, banner);
    while (in.peek() == '%') {
      std::string comment;
      std::getline(in, comment);
    }
    in >> rows >> columns >> entry_count;
    for (Index row = 0, column = 0; in >> row >> column;) {
      entries.emplace_back(row, column);
    }
    CHECK(in.eof());
  }
};

std::string graph_of(const ConstraintVertices& constraints, const std::string& comment = "") {
  std::ostringstream out;
  write_conflict_graph(out, constraints, comment);
  return out.str();
}

bool share_a_vertex(const ConstraintVertices& constraints, Index a, Index b) {
  const auto ids = constraints[b];
  return std::any_of(constraints[a].begin(), constraints[a].end(),
                     [&](Index v) { return std::find(ids.begin(), ids.end(), v) != ids.end(); });
}

}  // namespace

// A conflict that is missing, named twice, in the upper triangle or numbered from 0 would fail
// here.
TEST_CASE("conflict graph: every pair that shares a vertex once, and no other", "[property]") {
  std::vector<testing::SampleConstraints> samples = testing::all_samples();
  samples.push_back(testing::crowded_sample(1));
  for (const testing::SampleConstraints& sample : samples) {
    INFO(sample.name);
    const ConstraintVertices constraints = sample.view();
    const Index count = constraints.constraint_count();
    const PatternMatrix graph(graph_of(constraints));
    CHECK(graph.banner == "%%MatrixMarket matrix coordinate pattern symmetric");
    CHECK(graph.rows == count);
    CHECK(graph.columns == count);
    CHECK(graph.entry_count == static_cast<std::int64_t>(graph.entries.size()));

    std::vector<std::pair<Index, Index>> wanted;
    for (Index row = 1; row <= count; ++row) {
      for (Index column = 1; column < row; ++column) {
        if (share_a_vertex(constraints, row - 1, column - 1)) {
          wanted.emplace_back(row, column);
        }
      }
    }
    CHECK(graph.entries == wanted);
  }
}

TEST_CASE("conflict graph: no comment ends its lines early", "[unit]") {
  const std::vector<Edge> path{{0, 1}, {1, 2}};
  const ConstraintVertices constraints(std::span<const Edge>(path), 3);
  CHECK(graph_of(constraints, "edges of\n3 3 3\n") ==
        "%%MatrixMarket matrix coordinate pattern symmetric\n"
        "% edges of\n% 3 3 3\n% \n2 2 1\n2 1\n");
}

TEST_CASE("conflict graph: bad constraints are refused before a byte is written", "[unit]") {
  const std::vector<Edge> bad{{0, 1}, {2, 2}};
  std::ostringstream out;
  CHECK_THROWS_WITH(write_conflict_graph(out, {std::span<const Edge>(bad), 3}, ""),
                    ContainsSubstring("constraint 1"));
  CHECK(out.str().empty());
}

}  // namespace pbdsurg
