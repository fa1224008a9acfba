// SPDX-License-Identifier: Apache-2.0
// A user's program: enough of the library to need its code, its headers and its dependencies.
#include <cstdio>

#include "pbdsurg/mesh/partition.h"
#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/mesh/topology.h"

#if defined(CONSUMER_WITH_CUDA)
#include "pbdsurg/cuda/device.h"
#endif

int main() {
  const pbdsurg::TetMesh mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}},
                              {{0, 1, 2, 3}, {1, 2, 3, 4}});
  const auto edges = pbdsurg::find_edges(mesh.tets());
  const auto parts = pbdsurg::partition_vertices(edges, mesh.positions(), 2);
  std::printf("%zu edges, %d parts\n", edges.size(), parts.part_count);
#if defined(CONSUMER_WITH_CUDA)
  const auto list = pbdsurg::cuda::find_devices();
  std::printf("%zu devices %s\n", list.devices.size(), list.reason.c_str());
#endif
  return edges.size() == 9 && parts.part_count == 2 ? 0 : 1;
}
