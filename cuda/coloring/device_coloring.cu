// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include <cub/device/device_radix_sort.cuh>
#include <cuda_runtime_api.h>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/cuda/coloring.h"
#include "pbdsurg/cuda/device.h"

#include "cuda/buffer.cuh"
#include "cuda/check.cuh"
#include "cuda/coloring/first_fit_program.cuh"
#include "cuda/coloring/grid_team.cuh"
#include "cuda/coloring/kernels.cuh"
#include "cuda/coloring/workspace.cuh"
#include "lib/coloring/balance_program.h"
#include "lib/coloring/chain_balance.h"
#include "lib/coloring/claims.h"
#include "lib/coloring/color_masks.h"
#include "lib/coloring/color_tables.h"
#include "lib/coloring/coloring_options.h"
#include "lib/coloring/constraint_access.h"
#include "lib/coloring/disc_palette.h"
#include "lib/coloring/luby_program.h"
#include "lib/coloring/random_disc_program.h"
#include "lib/coloring/repair_program.h"

namespace pbdsurg::cuda {

struct DeviceColoring::Data : ColoringWorkspace {
  static constexpr const char* kWho = "a device colouring";

  // Blocks a multiprocessor: for programs that go over all constraints in most phases, and for
  // those of many short phases.
  static constexpr int kWideGrid = 3;
  static constexpr int kNarrowGrid = 1;

  // --- algorithms ------------------------------------------------------------------------------

  // First fit; no constraint gets a higher colour than it has conflicts.
  void first_fit(const std::uint32_t* ranks, Index bound) {
    list_vertex_constraints(ranks);
    Index* const colors =
        color_of.fill(static_cast<std::size_t>(count), 0xFF, stream);  // kInvalidIndex
    // one word more than the bound fills, so that more than one window is rare
    const int words = bound / 64 + 1;
    with_access([&](const auto& access) {
      Index uncolored = count;
      for (Index window = 0; uncolored > 0; window += 64 * words) {
        FirstFitProgram<std::decay_t<decltype(access)>> program;
        program.constraints = access;
        program.vertex_count = vertex_count;
        program.window = window;
        program.offsets = vertex_offsets.get();
        program.entries = vertex_entries.get();
        program.masks = empty_masks(words);
        program.color_of = colors;
        program.next = vertex_state.fill(static_cast<std::size_t>(vertex_count), 0, stream);
        program.ready = lists[0].fill(static_cast<std::size_t>(count), 0, stream);
        program.queue = lists[1].reserve(static_cast<std::size_t>(count));
        program.pushed = scalars.fill(kScalars, 0, stream);
        run_on_grid(program, count, kNarrowGrid, stream);
        uncolored = list_uncolored_in(lists[1]);
      }
    });
    close_gaps(std::min<std::int64_t>(count, std::int64_t{max_arity} * bound + 1));
  }

  // @return how many there are
  Index list_uncolored_in(DeviceBuffer<Index>& list) {
    Index* const list_count = scalars.fill(kScalars, 0, stream);
    launch(list_uncolored, count, stream, color_of.get(),
           list.reserve(static_cast<std::size_t>(count)), list_count);
    return read(list_count, 1)[0];
  }

  const std::uint32_t* valence_ranks() {
    const auto size = static_cast<std::size_t>(count);
    std::uint64_t* const keys = wide_keys[0].reserve(size);
    std::uint64_t* const sorted_keys = wide_keys[1].reserve(size);
    Index* const ids = lists[0].reserve(size);
    Index* const order = lists[1].reserve(size);
    std::uint32_t* const result = rank_of.reserve(size);
    with_access([&](const auto& access) {
      launch(make_valence_keys<std::decay_t<decltype(access)>>, count, stream, access,
             valence.get(), keys, ids);
    });
    with_scratch([&](void* memory, std::size_t& bytes) {
      return cub::DeviceRadixSort::SortPairsDescending(memory, bytes, keys, sorted_keys, ids, order,
                                                       count, 0, 64, stream);
    });
    launch(invert_order, count, stream, order, result);
    return result;
  }

  const std::uint32_t* shuffled_ranks(std::uint64_t seed) {
    std::uint32_t* const result = rank_of.reserve(static_cast<std::size_t>(count));
    launch(shuffle_ranks, count, stream, rank_bits_for(count), random_bits(seed, 0), result);
    return result;
  }

  void luby(std::uint64_t seed, Index bound) {
    const auto size = static_cast<std::size_t>(count);
    with_access([&](const auto& access) {
      LubyProgram<std::decay_t<decltype(access)>> program;
      program.constraints = access;
      program.seed = seed;
      program.claims = claim_table(1);
      program.last_color = vertex_state.fill(static_cast<std::size_t>(vertex_count), 0xFF, stream);
      program.color_of = color_of.fill(size, 0xFF, stream);
      for (int i = 0; i < 2; ++i) {
        program.candidates[i] = lists[i].reserve(size);
        program.waiting[i] = lists[2 + i].reserve(size);
      }
      program.more_rounds = scalars.fill(kScalars, 0, stream);
      program.more_colors = program.more_rounds + 3;
      run_on_grid(program, count, kWideGrid, stream);
    });
    close_gaps(std::min<std::int64_t>(count, std::int64_t{max_arity} * bound + 1));
  }

  void random_disc(std::uint64_t seed, const RandomDiscOptions& options, Index bound) {
    const auto size = static_cast<std::size_t>(count);
    const Index* palettes = nullptr;
    Index largest = std::max(bound, 1);
    if (options.palette == Palette::conflicts) {
      list_vertex_constraints(nullptr);
      Index* const result = palette_of.reserve(size);
      with_access([&](const auto& access) {
        launch(make_palettes<std::decay_t<decltype(access)>>, count, stream, access,
               vertex_offsets.get(), vertex_entries.get(), options.shrink, result);
      });
      largest = maximum(result, count);
      palettes = result;
    }
    const int words = (largest + 63) / 64;
    color_of.fill(size, 0xFF, stream);
    Index pending = count;
    Index limit = 0;
    with_access([&](const auto& access) {
      for (int window = 0; pending > 0; ++window) {
        RandomDiscProgram<std::decay_t<decltype(access)>> program;
        program.constraints = access;
        program.pending = window == 0 ? nullptr : lists[2].get();
        program.pending_count = pending;
        program.seed = window_seed(seed, window);
        program.window = 64 * words * window;
        program.palettes = window == 0 ? palettes : nullptr;
        program.palette = window == 0 ? largest : 1;
        program.masks = empty_masks(words);
        program.claims = claim_table(slots_for(largest, kDiscSlots));
        program.color_of = color_of.get();
        program.drawn = lists[3].reserve(size);
        program.lists[0] = lists[0].reserve(size);
        program.lists[1] = lists[1].reserve(size);
        program.more = scalars.fill(kScalars, 0, stream);
        run_on_grid(program, pending, kWideGrid, stream);
        limit += 64 * words;
        pending = list_uncolored_in(lists[2]);
      }
    });
    close_gaps(limit);
  }

  // --- improvements ----------------------------------------------------------------------------

  // Down to the target or as near as it gets; with gives_up, what does not fit stays above it.
  void lower_colors(Index target, bool gives_up, RepairSwaps swaps, std::uint64_t seed) {
    const auto size = static_cast<std::size_t>(count);
    count_sizes(color_count);
    ColorHolders holders;
    holders.width = color_count;
    if (ColorHolders::fits(vertex_count, color_count, static_cast<std::size_t>(entry_count))) {
      holders.table = holder_table.reserve(static_cast<std::size_t>(vertex_count) *
                                           static_cast<std::size_t>(color_count));
    } else {
      list_vertex_constraints(nullptr);
      holders.offsets = vertex_offsets.get();
      holders.entries = vertex_entries.get();
    }
    with_access([&](const auto& access) {
      if (holders.table != nullptr) {
        launch(fill_holders<std::decay_t<decltype(access)>>, count, stream, access, color_of.get(),
               holders);
      }
      RepairProgram<std::decay_t<decltype(access)>> program;
      program.constraints = access;
      program.seed = seed;
      program.color_count = color_count;
      program.target = target;
      program.gives_up = gives_up;
      program.swaps_with_two = swaps == RepairSwaps::with_two;
      program.masks = color_masks();
      program.claims = claim_table(1);
      program.holders = holders;
      program.color_of = color_of.get();
      program.sizes = sizes.get();
      program.lists[0] = lists[0].reserve(size);
      program.lists[1] = lists[1].reserve(size);
      program.best = best.fill(size, 0, stream);
      program.counts = scalars.fill(kScalars, 0, stream);
      run_on_grid(program, count, kNarrowGrid, stream);
    });
  }

  void repair(RepairSwaps swaps, std::uint64_t seed, Index bound) {
    if (color_count > bound) {
      lower_colors(std::max(bound, 1), false, swaps, seed);
      close_gaps(color_count);
    }
  }

  void limit_colors(Index max_colors, std::uint64_t seed) {
    if (color_count <= max_colors) {
      return;
    }
    renumber(numbers_by_size(read_sizes(color_count)));
    lower_colors(max_colors, true, RepairSwaps::with_one, seed);
    launch(overflow_colors, count, stream, max_colors, color_of.get());
    close_gaps(max_colors);
  }

  void balance(std::uint64_t seed) {
    const std::vector<Index> sizes_before = read_sizes(color_count);
    const auto colors = sizes_before.size();
    if (colors == 0) {
      return;
    }
    Index* const given = given_colors.reserve(static_cast<std::size_t>(count));
    PBDSURG_CUDA_CHECK(cudaMemcpyAsync(given, color_of.get(),
                                       static_cast<std::size_t>(count) * sizeof(Index),
                                       cudaMemcpyDeviceToDevice, stream));
    with_access([&](const auto& access) {
      BalanceProgram<std::decay_t<decltype(access)>> program;
      program.constraints = access;
      program.seed = seed;
      program.color_count = color_count;
      program.colored_count = count_from(sizes_before, 0);
      program.masks = color_masks();
      program.claims = claim_table(slots_for(color_count, kBalanceSlots));
      program.color_of = color_of.get();
      program.sizes = sizes.get();
      program.changes = changes.fill(colors, 0, stream);
      program.odds = odds.reserve(colors);
      program.begins = begins.reserve(colors);
      program.counts = counts.reserve(colors);
      program.volunteers = lists[0].reserve(static_cast<std::size_t>(count));
      program.drawn = lists[1].reserve(static_cast<std::size_t>(count));
      program.targets = targets.reserve(static_cast<std::size_t>(program.masks.words));
      program.unevenness = unevenness.fill(3, 0, stream);
      run_on_grid(program, count, kNarrowGrid, stream);
    });
    if (!is_even(close_gaps(color_count))) {
      even_out(given, static_cast<Index>(colors));
    }
  }

  // On the host, from the colours before balance(); it takes a long time, but few meshes need it.
  void even_out(const Index* given, Index given_count) {
    const auto size = static_cast<std::size_t>(count);
    const std::vector<Index> entries = read(vertices.get(), static_cast<std::size_t>(entry_count));
    const std::vector<Index> offsets =
        read(constraint_offsets.get(), arity == 0 ? size + 1 : std::size_t{0});
    ConstraintVertices constraints;
    constraints.vertices = entries;
    constraints.offsets = offsets;
    constraints.arity = arity;
    constraints.vertex_count = vertex_count;
    const Coloring result = more_even_coloring(
        {read(given, size), given_count}, {read(color_of.get(), size), color_count}, constraints);
    color_count = result.color_count;
    color_of.upload(result.color_of, stream);
    PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));  // `result` ends here
  }
};

DeviceColoring::DeviceColoring(const ConstraintVertices& constraints) {
  check_constraints(constraints);
  const DeviceList devices = find_devices();
  if (devices.devices.empty()) {
    throw BackendUnavailable("no CUDA device: " + devices.reason);
  }
  data_ = std::make_unique<Data>();
  data_->arity = constraints.arity;
  data_->count = constraints.constraint_count();
  data_->vertex_count = constraints.vertex_count;
  data_->entry_count = static_cast<Index>(constraints.vertices.size());
  data_->max_arity = constraints.arity;
  for (Index c = 0; c < data_->count && constraints.arity == 0; ++c) {
    data_->max_arity = std::max(data_->max_arity, static_cast<Index>(constraints[c].size()));
  }
  data_->vertices.upload(constraints.vertices, data_->stream);
  data_->constraint_offsets.upload(constraints.offsets, data_->stream);
  PBDSURG_CUDA_CHECK(cudaStreamSynchronize(data_->stream));
}

DeviceColoring::~DeviceColoring() = default;
DeviceColoring::DeviceColoring(DeviceColoring&&) noexcept = default;
DeviceColoring& DeviceColoring::operator=(DeviceColoring&&) noexcept = default;

void DeviceColoring::color(const ColoringOptions& options) {
  check_coloring_options(options);
  if (options.algorithm == ColoringAlgorithm::greedy &&
      (options.order == GreedyOrder::smallest_last || options.order == GreedyOrder::saturation)) {
    throw InvalidArgument(std::string("greedy order ") + name_of(options.order) +
                          " is sequential by nature: on CUDA, use natural or largest_valence");
  }
  Data& data = *data_;
  const CurrentDevice scope(data.device);
  data.has_colors = false;
  data.color_count = 0;
  if (data.count == 0) {
    return;
  }
  const Index bound = data.find_clique_bound();
  switch (options.algorithm) {
    case ColoringAlgorithm::greedy:
      data.first_fit(options.order == GreedyOrder::natural ? nullptr : data.valence_ranks(), bound);
      break;
    case ColoringAlgorithm::luby:
      data.luby(options.seed, bound);
      break;
    case ColoringAlgorithm::jones_plassmann:
      data.first_fit(data.shuffled_ranks(options.seed), bound);
      break;
    case ColoringAlgorithm::random_disc:
      data.random_disc(options.seed, options.disc, bound);
      break;
  }
  if (options.repair) {
    data.repair(repair_swaps(options), options.seed, bound);
  }
  if (options.max_colors > 0) {
    data.limit_colors(options.max_colors, options.seed);
  }
  if (options.balance) {
    data.balance(options.seed);
  }
  data.has_colors = true;
}

Index DeviceColoring::color_count() const {
  return data_->color_count;
}

const Index* DeviceColoring::device_colors() const {
  return data_->has_colors ? data_->color_of.get() : nullptr;
}

Coloring DeviceColoring::download() const {
  Coloring coloring;
  coloring.color_count = data_->color_count;
  if (data_->has_colors) {
    const CurrentDevice scope(data_->device);
    coloring.color_of = data_->read(data_->color_of.get(), static_cast<std::size_t>(data_->count));
  }
  return coloring;
}

Coloring color_constraints(const ConstraintVertices& constraints, const ColoringOptions& options) {
  DeviceColoring device(constraints);
  device.color(options);
  return device.download();
}

}  // namespace pbdsurg::cuda
