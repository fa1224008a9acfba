// SPDX-License-Identifier: Apache-2.0
#include "cuda/heat/cuda_system.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"

#include "cuda/buffer.cuh"
#include "cuda/heat/system_kernel.h"
#include "cuda/stream.cuh"

namespace pbdsurg::cuda {
namespace {

static_assert(LocalSystem::kMostGroups <= kMostPieces);

int current_device() {
  int device = 0;
  PBDSURG_CUDA_CHECK(cudaGetDevice(&device));
  return device;
}

// With room to grow, for regions do, and memory of a device takes long to come by.
template <class Buffer>
auto* reserve(Buffer& buffer, std::size_t size) {
  return buffer.reserve(std::bit_ceil(size));
}

template <class T>
T* upload(DeviceBuffer<T>& buffer, std::span<const T> values, cudaStream_t stream) {
  reserve(buffer, values.size());
  return buffer.upload(values, stream);
}

class CudaSystem final : public DeviceSystem {
 public:
  CudaSystem() : device_(current_device()), limits_(prepare_system_kernel()) {
    result_.reserve(1);
    group_inverse_.reserve(kMostPieces * kMostPieces);
    sums_.reserve(kSystemSums * kMostPieces);
  }

  ~CudaSystem() override {  // what is at work there needs the buffers
    static_cast<void>(cudaStreamSynchronize(stream_.get()));
  }
  CudaSystem(const CudaSystem&) = delete;
  CudaSystem& operator=(const CudaSystem&) = delete;

  bool set_rows(const SystemRows& rows, std::span<const Tet> corners) override {
    if (rows.row_count() > kMostSystemRows) {
      return false;
    }
    const CurrentDevice current(device_);
    const cudaStream_t stream = stream_.get();
    const SystemPlan plan = plan_system(rows, limits_.most_blocks, limits_.shared_bytes);
    const auto row_count = static_cast<std::size_t>(rows.row_count());
    const auto tet_count = static_cast<std::size_t>(rows.tet_count());
    block_count_ = plan.block_count;
    arrays_.row_count = rows.row_count();
    arrays_.tet_count = rows.tet_count();
    arrays_.piece_count = plan.piece_count();
    arrays_.slices_per_piece = plan.slices_per_piece;
    arrays_.is_grouped = !rows.groups.empty();
    arrays_.is_in_shared_memory = plan.is_in_shared_memory;
    arrays_.block_bytes = plan.block_bytes;
    arrays_.pieces = upload<Index>(pieces_, plan.pieces, stream);
    arrays_.starts = upload(starts_, rows.starts, stream);
    arrays_.columns = upload(columns_, rows.columns, stream);
    arrays_.row_tet_starts = upload(row_tet_starts_, rows.row_tet_starts, stream);
    arrays_.row_tets = upload(row_tets_, rows.row_tets, stream);
    arrays_.corners = reinterpret_cast<const int4*>(upload(corners_, corners, stream));
    arrays_.store =
        plan.is_in_shared_memory
            ? nullptr
            : reserve(store_, plan.block_bytes * static_cast<std::size_t>(block_count_));
    arrays_.scales = reserve(scales_, tet_count);
    arrays_.tet_heat = reserve(tet_heat_, tet_count);
    arrays_.starting = reserve(starting_, row_count);
    arrays_.pairs = reserve(pairs_, row_count);
    arrays_.coarse =
        reserve(coarse_,
                static_cast<std::size_t>(plan.piece_count() * plan.slices_per_piece) * kMostPieces);
    arrays_.group_inverse = group_inverse_.get();
    arrays_.sums = sums_.get();
    reserve(row_values_, kRowArrays * row_count);
    reserve(tet_values_, 2 * tet_count);
    uses_of_inverse_ = LocalSystem::kMostUsesOfInverse;
    stream_.wait();  // the plan goes
    return true;
  }

  void set_conductances(std::span<const std::array<double, 6>> conductances) override {
    const CurrentDevice current(device_);
    const auto* const first = reinterpret_cast<const double*>(conductances.data());
    arrays_.conductances =
        upload<double>(conductances_, {first, 6 * conductances.size()}, stream_.get());
    uses_of_inverse_ = LocalSystem::kMostUsesOfInverse;
  }

  LinearSolveReport solve(const DeviceSolve& input, std::span<double> x) override {
    const CurrentDevice current(device_);
    const auto row_count = static_cast<std::size_t>(arrays_.row_count);
    const auto tet_count = static_cast<std::size_t>(arrays_.tet_count);
    const auto take = [&](std::span<const double> values, double* to) {
      std::copy(values.begin(), values.end(), to);
      return to;
    };
    double* const rows = row_values_.get();
    double* const tets = tet_values_.get();
    const SystemInput in{
        .scales = input.scales.empty() ? nullptr : take(input.scales, tets),
        .added = take(input.added, rows),
        .b = take(input.b, rows + row_count),
        .x = take(x, rows + 2 * row_count),
        .tolerance = input.options.tolerance,
        .most_iterations = input.options.most_iterations,
        .is_relative = input.is_relative,
        .inverts_groups = arrays_.is_grouped && uses_of_inverse_ >= LocalSystem::kMostUsesOfInverse,
    };
    const bool wants_heat = !input.tet_heat.empty();
    const SystemOutput out{.x = rows + 3 * row_count,
                           .tet_heat = wants_heat ? tets + tet_count : nullptr,
                           .row_heat = wants_heat ? rows + 4 * row_count : nullptr,
                           .result = result_.get()};
    solve_system(arrays_, in, out, block_count_, stream_.get());
    stream_.wait();
    uses_of_inverse_ = in.inverts_groups ? 1 : uses_of_inverse_ + 1;
    std::copy_n(out.x, row_count, x.begin());
    if (wants_heat) {
      std::copy_n(out.tet_heat, tet_count, input.tet_heat.begin());
      std::copy_n(out.row_heat, row_count, input.row_heat.begin());
    }
    const SystemResult& result = *result_.get();
    return {result.iterations, result.scale > 0 ? std::sqrt(result.squares / result.scale) : 0,
            result.squares <= input.options.tolerance * input.options.tolerance * result.scale};
  }

 private:
  static constexpr std::size_t kRowArrays = 5;  // added, b, x; x and heat of the solution

  int device_;
  SystemLimits limits_;
  Stream stream_;
  Index block_count_ = 1;
  int uses_of_inverse_ = LocalSystem::kMostUsesOfInverse;
  SystemArrays arrays_{};
  DeviceBuffer<Index> pieces_, starts_, columns_, row_tet_starts_;
  DeviceBuffer<RowTet> row_tets_;
  DeviceBuffer<Tet> corners_;
  DeviceBuffer<double> conductances_, scales_, tet_heat_, coarse_, group_inverse_, sums_;
  DeviceBuffer<double2> starting_, pairs_;
  DeviceBuffer<unsigned char> store_;
  PinnedBuffer<double> row_values_;  // [kRowArrays, row_count]
  PinnedBuffer<double> tet_values_;  // [2, tet_count] scales and heat
  PinnedBuffer<SystemResult> result_;
};

}  // namespace

std::unique_ptr<DeviceSystem> make_cuda_system() {
  try {
    return std::make_unique<CudaSystem>();
  } catch (const DeviceError& error) {
    throw BackendUnavailable(std::string("the CUDA device cannot take heat and potential: ") +
                             error.what());
  }
}

}  // namespace pbdsurg::cuda
