// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/views/change_log.h"

#include <algorithm>

namespace pbdsurg {
namespace {

// The smallest memory of changes.
constexpr std::size_t kFewestChanges = 1024;

}  // namespace

ChangeLog::ChangeLog(Index slot_count)
    : slots_(std::max(kFewestChanges, static_cast<std::size_t>(slot_count))) {}

void ChangeLog::note_again(std::uint64_t since) noexcept {
  const std::uint64_t end = version_;
  if (end - since > slots_.size()) {
    note_all();
    return;
  }
  for (std::uint64_t v = since; v < end; ++v) {
    note(slots_[v % slots_.size()]);
  }
}

void ChangeLog::reserve(Index slot_count) {
  if (static_cast<std::size_t>(slot_count) > slots_.size()) {
    slots_.resize(std::max(static_cast<std::size_t>(slot_count), 2 * slots_.size()));
    note_all();
  }
}

void ChangeLog::collect(std::uint64_t since, Index slot_count, std::vector<SlotRange>& ranges,
                        Index gap) const {
  ranges.clear();
  if (since == 0 || version_ - since > slots_.size()) {
    ranges.push_back({0, slot_count});
    return;
  }
  for (std::uint64_t v = since; v < version_; ++v) {
    const Index slot = slots_[v % slots_.size()];
    if (slot < slot_count) {
      ranges.push_back({slot, slot + 1});
    }
  }
  std::sort(ranges.begin(), ranges.end(),
            [](const SlotRange& a, const SlotRange& b) { return a.first < b.first; });
  std::size_t count = 0;
  for (const SlotRange& range : ranges) {
    if (count > 0 && range.first < ranges[count - 1].end + gap) {
      ranges[count - 1].end = range.end;
    } else {
      ranges[count++] = range;
    }
  }
  ranges.resize(count);
}

}  // namespace pbdsurg
