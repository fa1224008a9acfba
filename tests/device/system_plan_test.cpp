// SPDX-License-Identifier: Apache-2.0
#include "lib/device/system_plan.h"

#include "lib/heat/local_system.h"
#include "tests/support/catch.h"
#include "tests/support/meshes.h"

namespace pbdsurg::cuda {

// Would catch rows that no block has or two have, more slices than a block has sums for, and a
// store that is too small for its block.
TEST_CASE("system plan: blocks share all rows, and each has room for its own", "[unit]") {
  for (const Index cells : {1, 3, 6, 11, 16}) {
    const TetMesh mesh = pbdsurg::testing::make_box({cells, cells, cells}, 1);
    LocalSystem system;
    for (const Index groups : {0, 1, 5, 17, 64}) {
      system.set_rows(mesh.vertex_count(), mesh.tets());
      std::vector<Index> starts;
      for (Index i = 0; i <= groups && groups > 0; ++i) {
        starts.push_back(mesh.vertex_count() * i / groups);
      }
      if (groups > 0) {
        system.set_groups(starts);
      }
      for (const Index most : {1, 8, 16}) {
        const SystemRows rows = system.rows();
        const SystemPlan plan = plan_system(rows, most, 100'000);
        REQUIRE(plan.block_count >= 1);
        REQUIRE(plan.block_count <= most);
        REQUIRE(plan.piece_count() <= kMostPieces);
        CHECK(plan.pieces.front() == 0);
        CHECK(plan.pieces.back() == rows.row_count());
        CHECK(std::is_sorted(plan.pieces.begin(), plan.pieces.end()));
        CHECK(plan.first_piece(0) == 0);
        CHECK(plan.first_piece(plan.block_count) == plan.piece_count());
        for (Index block = 0; block < plan.block_count; ++block) {
          const Index pieces = plan.first_piece(block + 1) - plan.first_piece(block);
          CHECK(pieces >= 1);
          CHECK(pieces * plan.slices_per_piece <= kMostPieces);
          const Index first = plan.pieces[plan.first_piece(block)];
          const Index end = plan.pieces[plan.first_piece(block + 1)];
          CHECK(plan.block_bytes >=
                kRowBytes * (end - first) + kEntryBytes * (rows.starts[end] - rows.starts[first]));
        }
        CHECK(plan.block_bytes % 16 == 0);
        CHECK(plan.is_in_shared_memory == (plan.block_bytes <= 100'000));
        CHECK((groups == 0 || plan.piece_count() == groups));
      }
    }
  }
}

}  // namespace pbdsurg::cuda
