// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The arrays of a colouring on a device, and what all algorithms do with them.

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_reduce.cuh>
#include <cub/device/device_scan.cuh>
#include <cuda_runtime_api.h>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/types.h"

#include "cuda/buffer.cuh"
#include "cuda/check.cuh"
#include "cuda/coloring/grid_team.cuh"
#include "cuda/coloring/kernels.cuh"
#include "cuda/stream.cuh"
#include "lib/coloring/balance_program.h"
#include "lib/coloring/claims.h"
#include "lib/coloring/color_masks.h"
#include "lib/coloring/constraint_access.h"

namespace pbdsurg::cuda {

/// For one set of constraints on the current device; what was reserved is kept for the next
/// colouring.
struct ColoringWorkspace {
  static constexpr std::size_t kScalars = 8;

  // the constraints
  int arity = 0;  // 0: offsets say
  Index count = 0;
  Index vertex_count = 0;
  Index entry_count = 0;
  Index max_arity = 0;
  DeviceBuffer<Index> vertices;
  DeviceBuffer<Index> constraint_offsets;

  // the colouring
  DeviceBuffer<Index> color_of, given_colors;  // the second: before they were balanced
  Index color_count = 0;
  bool has_colors = false;

  // what making it takes
  DeviceBuffer<Index> valence;   // [vertex_count]
  DeviceBuffer<Index> scalars;   // [kScalars] counters and flags
  DeviceBuffer<Index> lists[4];  // [count] each
  DeviceBuffer<Index> vertex_offsets, vertex_entries, entry_owners, narrow_keys, holder_table;
  DeviceBuffer<std::uint64_t> masks, wide_keys[2], best, targets;
  DeviceBuffer<std::uint32_t> claim_keys, rank_of, odds;
  DeviceBuffer<Index> vertex_state, palette_of, sizes, changes, begins, counts;
  DeviceBuffer<Unevenness> unevenness;
  DeviceBuffer<unsigned char> scratch;
  Stream own_stream;
  cudaStream_t stream = own_stream.get();

  int device = 0;

  ColoringWorkspace() {
    PBDSURG_CUDA_CHECK(cudaGetDevice(&device));
    int launches_cooperatively = 0;
    PBDSURG_CUDA_CHECK(
        cudaDeviceGetAttribute(&launches_cooperatively, cudaDevAttrCooperativeLaunch, device));
    if (launches_cooperatively == 0) {
      throw BackendUnavailable("CUDA device " + std::to_string(device) +
                               " cannot launch cooperative grids, which colouring needs");
    }
  }

  template <class F>
  void with_access(F&& f) const {
    switch (arity) {
      case 2:
        return f(FixedArity<2>{vertices.get(), count});
      case 4:
        return f(FixedArity<4>{vertices.get(), count});
      default:
        return f(AnyArity{vertices.get(), arity == 0 ? constraint_offsets.get() : nullptr, count,
                          arity});
    }
  }

  template <class T>
  std::vector<T> read(const T* values, std::size_t size) const {
    std::vector<T> result(size);
    PBDSURG_CUDA_CHECK(
        cudaMemcpyAsync(result.data(), values, size * sizeof(T), cudaMemcpyDeviceToHost, stream));
    PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));
    return result;
  }

  // --- what colourings start from ----------------------------------------------------------------

  Index find_clique_bound() {
    Index* const valences = valence.fill(static_cast<std::size_t>(vertex_count), 0, stream);
    launch(count_valences, entry_count, stream, vertices.get(), valences);
    return maximum(valences, vertex_count);
  }

  Index maximum(const Index* values, Index size) {
    if (size == 0) {
      return 0;
    }
    Index* const result = scalars.reserve(kScalars);
    with_scratch([&](void* memory, std::size_t& bytes) {
      return cub::DeviceReduce::Max(memory, bytes, values, result, size, stream);
    });
    return read(result, 1)[0];
  }

  // Calls one of CUB's algorithms twice, as they want it: for the size of its memory, then for
  // good.
  template <class F>
  void with_scratch(const F& algorithm) {
    std::size_t bytes = 0;
    PBDSURG_CUDA_CHECK(algorithm(nullptr, bytes));
    PBDSURG_CUDA_CHECK(algorithm(scratch.reserve(bytes), bytes));
  }

  // The constraints at each vertex: those of smaller rank first, or in their natural order.
  // @param ranks  [count] or nullptr
  void list_vertex_constraints(const std::uint32_t* ranks) {
    const auto entries = static_cast<std::size_t>(entry_count);
    Index* const owners = entry_owners.reserve(entries);
    with_access([&](const auto& access) {
      launch(list_owners<std::decay_t<decltype(access)>>, count, stream, access, owners);
    });
    // the sort is stable, so by vertex alone it keeps the natural order
    if (ranks == nullptr) {
      sort_entries(vertices.get(), narrow_keys.reserve(entries), rank_bits_for(vertex_count));
    } else {
      std::uint64_t* const keys = wide_keys[0].reserve(entries);
      launch(make_rank_keys, entry_count, stream, vertices.get(), owners, ranks, keys);
      sort_entries(keys, wide_keys[1].reserve(entries), 32 + rank_bits_for(vertex_count));
    }
    Index* const offsets =
        vertex_offsets.fill(static_cast<std::size_t>(vertex_count) + 1, 0, stream);
    with_scratch([&](void* memory, std::size_t& bytes) {
      return cub::DeviceScan::InclusiveSum(memory, bytes, valence.get(), offsets + 1, vertex_count,
                                           stream);
    });
  }

  template <class Key>
  void sort_entries(const Key* keys, Key* sorted_keys, int bits) {
    Index* const sorted = vertex_entries.reserve(static_cast<std::size_t>(entry_count));
    with_scratch([&](void* memory, std::size_t& bytes) {
      return cub::DeviceRadixSort::SortPairs(memory, bytes, keys, sorted_keys, entry_owners.get(),
                                             sorted, entry_count, 0, bits, stream);
    });
  }

  ClaimTable claim_table(int slots) {
    const auto size = static_cast<std::size_t>(vertex_count) * slots;
    return {claim_keys.fill(size, 0, stream), size, slots, rank_bits_for(count)};
  }

  ColorMasks empty_masks(int words) {
    return {masks.fill(static_cast<std::size_t>(vertex_count) * words, 0, stream), words};
  }

  ColorMasks color_masks() {
    const ColorMasks result = empty_masks((color_count + 63) / 64);
    with_access([&](const auto& access) {
      launch(fill_masks<std::decay_t<decltype(access)>>, count, stream, access, color_of.get(),
             result);
    });
    return result;
  }

  // [colors] constraints of each colour below `colors`, in `sizes`
  void count_sizes(Index colors) {
    Index* const result = sizes.fill(static_cast<std::size_t>(colors), 0, stream);
    const std::size_t shared = colors <= kSharedColors ? colors * sizeof(Index) : 0;
    const int blocks = std::clamp(count / (8 * kBlock), 1, 1024);
    count_colors<<<static_cast<unsigned>(blocks), kBlock, shared, stream>>>(count, color_of.get(),
                                                                            result, colors);
    PBDSURG_CUDA_CHECK(cudaGetLastError());
  }

  std::vector<Index> read_sizes(Index colors) {
    count_sizes(colors);
    return read(sizes.get(), static_cast<std::size_t>(colors));
  }

  // color -> number[color]
  void renumber(const std::vector<Index>& number) {
    const Index* const numbers = counts.upload(number, stream);
    launch(renumber_colors, count, stream, numbers, color_of.get());
    PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));  // `number` is the caller's
  }

  // Renumbers the colours below `limit` that occur, and counts them.
  // @return their sizes
  std::vector<Index> close_gaps(Index limit) {
    std::vector<Index> used = read_sizes(limit);
    std::vector<Index> number(used.size(), kInvalidIndex);
    color_count = 0;
    Index highest = 0;
    for (Index color = 0; color < limit; ++color) {
      if (used[color] > 0) {
        number[color] = color_count++;
        highest = color + 1;
      }
    }
    if (highest > color_count) {
      renumber(number);
    }
    std::erase(used, 0);
    return used;
  }
};

}  // namespace pbdsurg::cuda
