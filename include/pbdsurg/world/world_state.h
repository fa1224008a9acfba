// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A world at a moment, to go back to.

#include <cstddef>
#include <memory>

#include "pbdsurg/base/export.h"

namespace pbdsurg {

/// A world at a moment: World::save() makes it, and a World is made of it. A handle: its copies
/// mean the same moment. Lives in memory, and does not need the world that it is of; keeps its
/// executor's threads or device. Nothing changes it: several threads may make worlds of one.
class PBDSURG_API WorldState {
 public:
  /// Of no world.
  WorldState() = default;

  /// Edits since World::record(), which a world that is made of it goes through. Cost: O(1).
  [[nodiscard]] std::size_t edit_count() const noexcept;

  /// Bytes of this moment alone. For a vertex, some 40 of each replica, 52 of one with forces, and
  /// 48 of each cautery; for a link, 8 of each cautery; and 16 for an edit since World::record().
  /// Cost: O(replicas + cauteries + tools).
  [[nodiscard]] std::size_t memory_bytes() const noexcept;

  /// Bytes that it shares with the other states since the same call of World::record(): tissue and
  /// constraints as they were then, and edits since. Cost: O(edits).
  [[nodiscard]] std::size_t shared_bytes() const noexcept;

 private:
  friend class World;
  friend class WorldFile;  // which reads and writes its parts
  struct Data;
  std::shared_ptr<const Data> data_;
};

}  // namespace pbdsurg
