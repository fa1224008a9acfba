// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Heat and its marks on the surface of a body, as a renderer wants them.

#include <cstdint>
#include <span>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/heat/tissue_color.h"
#include "pbdsurg/views/change_log.h"
#include "pbdsurg/views/live_surface.h"

namespace pbdsurg {

/// State of tissue at scene vertices, all [vertex_count], as a heat field has it.
struct SurfaceFields {
  std::span<const double> temperatures;  ///< degrees Celsius; for equation 7 without forgetting,
                                         ///< the highest so far
  std::span<const double> survival;      ///< share not yet damaged
  std::span<const double> water;         ///< share left
  std::span<const double> charred;       ///< share that is char
};

/// BurnMarks in 8 bits, four bytes as a texture of bytes has them.
struct BurnBytes {
  std::uint8_t white = 0;    ///< coagulated
  std::uint8_t brown = 0;    ///< dried
  std::uint8_t charred = 0;  ///< carbonised
  std::uint8_t unused = 0;   ///< fills a texel of four bytes

  /// Whether all bytes are the same.
  friend bool operator==(const BurnBytes&, const BurnBytes&) = default;
};

/// As shares again.
PBDSURG_HOST_DEVICE constexpr BurnMarks burn_marks(const BurnBytes& bytes) {
  return {static_cast<float>(bytes.white) / 255, static_cast<float>(bytes.brown) / 255,
          static_cast<float>(bytes.charred) / 255};
}

/// The state of the heated volume at the vertices of its surface: the one temperature there is, not
/// a second one solved on the surface. Values are rounded to what can be seen, so that only what
/// changes visibly is sent to a renderer, and depend on the fields alone, not on what was before.
///
/// Follows a surface by its changes: update it after steps and edits, as often as pictures need it.
/// Vertices come with the surface, as edits bare them. Cost of an update: O(changed); the first one
/// takes all of the surface. Allocates when edits bring new vertices.
class PBDSURG_API SurfaceMap {
 public:
  static constexpr float kTemperatureStep = 1.0F / 16;  ///< K, to which temperatures are rounded

  /// Takes over what changed since the last update.
  /// @param surface  always the same, no older than the fields
  /// @param changed  scene vertices whose fields may have changed, in any order, those of other
  ///                 bodies and of the inside included: the active vertices of a heat field, of
  ///                 all its steps since the last update
  /// @throws InvalidArgument  if the fields differ in size, or the vertex that is changed or on the
  ///                          surface is not in them; then nothing has changed
  void update(const LiveSurface& surface, const SurfaceFields& fields,
              std::span<const Index> changed);

  /// The same where any vertex may have changed. Cost: O(vertex_count).
  void update(const LiveSurface& surface, const SurfaceFields& fields);

  /// [vertex_count] degrees Celsius; of use where a triangle of the surface is
  [[nodiscard]] std::span<const float> temperatures() const noexcept { return temperatures_; }

  /// [vertex_count]
  [[nodiscard]] std::span<const BurnBytes> marks() const noexcept { return marks_; }

  /// Grows with every vertex that changes. Above zero.
  [[nodiscard]] std::uint64_t version() const noexcept { return changes_.version(); }

  /// Which vertices a reader has to copy that has seen a version (ChangeLog::collect).
  void collect_changes(std::uint64_t since, std::vector<SlotRange>& ranges,
                       Index gap = ChangeLog::kJoinedGap) const {
    changes_.collect(since, static_cast<Index>(temperatures_.size()), ranges, gap);
  }

 private:
  void begin(const LiveSurface& surface, const SurfaceFields& fields,
             std::span<const Index> changed);
  void take(const SurfaceFields& fields, Index vertex);

  std::vector<float> temperatures_;         // [vertex_count]
  std::vector<BurnBytes> marks_;            // [vertex_count]
  std::vector<std::uint8_t> has_surfaced_;  // [vertex_count]
  ChangeLog changes_;
  std::uint64_t seen_surface_ = 0;
  std::vector<SlotRange> ranges_;  // scratch
};

}  // namespace pbdsurg
