// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Colouring on a CUDA device, with the same result as on the CPU, bit for bit.

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/owned.h"
#include "pbdsurg/coloring/color.h"

namespace pbdsurg::cuda {

/// Constraints in the memory of the current device, and colourings of them that are made there.
///
/// Buffers are kept between calls, so the second colouring with the same options allocates nothing
/// on the device. One object is used by one thread at a time.
class PBDSURG_API DeviceColoring {
 public:
  /// Copies the constraints to the device.
  /// @throws InvalidArgument     as check_constraints()
  /// @throws BackendUnavailable  if there is no device, or it cannot launch cooperative grids
  /// @throws DeviceError         naming the CUDA call that failed
  explicit DeviceColoring(const ConstraintVertices& constraints);
  ~DeviceColoring();
  /// Takes over. The other can then only be destroyed or assigned to.
  DeviceColoring(DeviceColoring&&) noexcept;
  DeviceColoring& operator=(DeviceColoring&&) noexcept;  ///< likewise

  /// Colours them as color_constraints() does on the CPU, and waits for the end. The colours stay
  /// on the device.
  ///
  /// ColoringAlgorithm::greedy follows its order as far as it is parallel: a constraint waits for
  /// those before it at its vertices, which takes hundreds of rounds, or thousands where the order
  /// follows a mesher through the mesh; at least as many as constraints at a vertex.
  /// What balance leaves uneven by more than 2 % goes to the host and back: see balance_coloring().
  /// @param options  without regard to `executor`
  /// @throws InvalidArgument  as color_constraints(), and for the orders smallest_last and
  ///                          saturation, which are sequential by nature; the colouring is then as
  ///                          it was
  /// @throws DeviceError      naming the CUDA call that failed; then there is no colouring
  void color(const ColoringOptions& options);

  /// Of the last colouring; none before the first.
  [[nodiscard]] Index color_count() const;

  /// [constraint_count] in device memory, as Coloring::color_of; nullptr if there is none
  [[nodiscard]] const Index* device_colors() const;

  /// The last colouring, copied to the host.
  /// @throws DeviceError  naming the CUDA call that failed
  [[nodiscard]] Coloring download() const;

 private:
  struct Data;
  Owned<Data> data_;
};

/// All of it in one call: there, colour, back.
/// @throws InvalidArgument, BackendUnavailable, DeviceError  as DeviceColoring
[[nodiscard]] PBDSURG_API Coloring color_constraints(const ConstraintVertices& constraints,
                                                     const ColoringOptions& options = {});

}  // namespace pbdsurg::cuda
