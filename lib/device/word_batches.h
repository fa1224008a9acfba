// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Words that wait to be written on a device.

#include <cstddef>
#include <span>
#include <vector>

#include "lib/device/stages.h"

namespace pbdsurg::cuda {

/// Batches are to be written one after another. In one, words that are listed twice are alike; the
/// next may write the same words again.
class WordBatches {
 public:
  /// The batch that is being made, to be appended to.
  [[nodiscard]] std::vector<WordChange>& last() noexcept { return last_; }

  /// Begins another, unless the last is empty.
  void begin() {
    if (!last_.empty()) {
      words_.insert(words_.end(), last_.begin(), last_.end());
      ends_.push_back(words_.size());
      last_.clear();
    }
  }

  /// Of all batches but the last.
  [[nodiscard]] std::span<const WordChange> words() const noexcept { return words_; }
  /// [batch] where in words() it ends
  [[nodiscard]] std::span<const std::size_t> ends() const noexcept { return ends_; }

  void clear() noexcept {
    last_.clear();
    words_.clear();
    ends_.clear();
  }

 private:
  std::vector<WordChange> last_;
  std::vector<WordChange> words_;  // of the batches before it
  std::vector<std::size_t> ends_;
};

}  // namespace pbdsurg::cuda
