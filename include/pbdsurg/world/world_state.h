// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A world at a moment, to go back to.

#include <cstddef>
#include <memory>

#include "pbdsurg/base/export.h"

namespace pbdsurg {

/// A world at a moment: World::save() makes it, and a World is made of it. A handle: its copies
/// mean the same moment. Lives in memory, and does not need the world that it is of.
class PBDSURG_API WorldState {
 public:
  /// Of no world.
  WorldState() = default;

  /// Bytes of this moment alone: about 190 a vertex that heat reaches, 70 for others, 8 for each
  /// link, and 16 for each edit since World::record().
  [[nodiscard]] std::size_t memory_bytes() const noexcept;

  /// Bytes that it shares with the other states since the same call of World::record(): tissue and
  /// constraints as they were then, and edits since.
  [[nodiscard]] std::size_t shared_bytes() const noexcept;

 private:
  friend class World;
  struct Data;
  std::shared_ptr<const Data> data_;
};

}  // namespace pbdsurg
