// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// An array that can take back what one edit wrote.

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// Entries that an edit of usual size writes to one array; there is room for them from the start
/// where room is asked for.
inline constexpr std::size_t kEntriesOfEdit = 4096;

/// An array whose writes since begin_edit() can be taken back. A write costs O(1) beside growth of
/// the array and its log, which keep their room; undo costs O(writes since begin_edit()). Ids are
/// not checked: it serves inner loops.
template <class T>
class UndoArray {
 public:
  UndoArray() = default;
  /// Takes over values.
  explicit UndoArray(std::vector<T> values) : values_(std::move(values)) {}

  /// Entries.
  [[nodiscard]] Index size() const noexcept { return static_cast<Index>(values_.size()); }
  /// One entry.
  [[nodiscard]] const T& operator[](Index i) const noexcept {
    return values_[static_cast<std::size_t>(i)];
  }
  /// [size()] valid until the size changes.
  [[nodiscard]] std::span<const T> values() const noexcept { return values_; }

  /// Writes an entry that there is.
  void set(Index i, const T& value) {
    log(i);
    values_[static_cast<std::size_t>(i)] = value;
  }
  /// Adds an entry behind the others.
  void push_back(const T& value) { values_.push_back(value); }
  /// Takes the last entry away; there must be one.
  void pop_back() {
    log(size() - 1);
    values_.pop_back();
  }

  /// Must not become shorter.
  void resize(std::size_t count, const T& value) { values_.resize(count, value); }

  /// From here on writes can be taken back; those before no longer.
  void begin_edit() noexcept {
    log_.clear();
    size_before_ = size();
  }

  /// Back to where begin_edit() was called.
  void undo() {
    undo([](Index) {});
  }

  /// Likewise.
  /// @param visit  void(Index i), after each write taken back to an entry that there was before
  template <class Visit>
  void undo(Visit&& visit) {
    values_.resize(static_cast<std::size_t>(size_before_));
    for (; !log_.empty(); log_.pop_back()) {
      const auto& [i, value] = log_.back();
      values_[static_cast<std::size_t>(i)] = value;
      visit(i);
    }
  }

  /// Makes room for so many more values, and for writes of an edit to so many of them.
  void reserve(std::size_t values, std::size_t writes = 0) {
    values_.reserve(values_.size() + values);
    log_.reserve(std::min(writes, kEntriesOfEdit));
  }

  /// Bytes that values and log hold, spare room included.
  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    return values_.capacity() * sizeof(T) + log_.capacity() * sizeof(log_[0]);
  }

 private:
  // what lies past the size before goes away with undo
  void log(Index i) {
    if (i < size_before_) {
      log_.emplace_back(i, values_[static_cast<std::size_t>(i)]);
    }
  }

  std::vector<T> values_;
  std::vector<std::pair<Index, T>> log_;  // index and value before, oldest first
  Index size_before_ = 0;
};

}  // namespace pbdsurg
