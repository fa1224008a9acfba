// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Words that wait to be written on a device.

#include <algorithm>
#include <bit>
#include <cstddef>
#include <vector>

#include "buffer.cuh"
#include "solver/word_kernels.h"

namespace pbdsurg::cuda {

/// Batches are written one after another. In one, words that are listed twice are alike; the next
/// may write the same words again.
class WordQueue {
 public:
  /// The batch that is being made, to be appended to.
  [[nodiscard]] std::vector<WordChange>& batch() noexcept { return batch_; }

  void begin_batch() {
    if (!batch_.empty()) {
      words_.insert(words_.end(), batch_.begin(), batch_.end());
      ends_.push_back(words_.size());
      batch_.clear();
    }
  }

  [[nodiscard]] bool is_empty() const noexcept { return batch_.empty() && words_.empty(); }

  void clear() noexcept {
    batch_.clear();
    words_.clear();
    ends_.clear();
  }

  /// Enqueues all and forgets them. What was written before is done.
  void write(const ArrayStarts& arrays, cudaStream_t stream) {
    begin_batch();
    // the device reads them where they are; edits differ in size
    WordChange* const shared = shared_.reserve(std::bit_ceil(words_.size()));
    std::ranges::copy(words_, shared);
    std::size_t first = 0;
    for (const std::size_t end : ends_) {
      write_words(arrays, shared + first, static_cast<Index>(end - first), stream);
      first = end;
    }
    clear();
  }

 private:
  std::vector<WordChange> batch_;
  std::vector<WordChange> words_;  // of the batches before
  std::vector<std::size_t> ends_;  // [batch]
  PinnedBuffer<WordChange> shared_;
};

}  // namespace pbdsurg::cuda
