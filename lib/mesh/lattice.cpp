// SPDX-License-Identifier: Apache-2.0
#include "lib/mesh/lattice.h"

#include <cmath>
#include <numbers>
#include <string>

#include "pbdsurg/base/error.h"

#include "lib/base/describe.h"

namespace pbdsurg {
namespace {

// Empty space between the box and the first lattice point, in cells. Odd numbers keep lattice
// points off the symmetry planes of shapes, where many edges would be cut at their ends.
const Eigen::Vector3d kMargin(1.137, 1.291, 1.413);

double checked_value(const ImplicitShape& shape, const Eigen::Vector3d& point) {
  const double value = shape(point);
  if (!std::isfinite(value)) {
    throw InvalidArgument("the shape has the value " + describe(value) + " at " + describe(point) +
                          "; it must be finite everywhere near its bounds");
  }
  return value;
}

}  // namespace

const std::array<Site, kDirectionCount> kDirections{{{2, 0, 0},
                                                     {-2, 0, 0},
                                                     {0, 2, 0},
                                                     {0, -2, 0},
                                                     {0, 0, 2},
                                                     {0, 0, -2},
                                                     {1, 1, 1},
                                                     {-1, -1, -1},
                                                     {1, 1, -1},
                                                     {-1, -1, 1},
                                                     {1, -1, 1},
                                                     {-1, 1, -1},
                                                     {1, -1, -1},
                                                     {-1, 1, 1}}};

Lattice::Lattice(const ImplicitShape& shape, double spacing, const Eigen::Vector3d& shift,
                 std::int64_t max_cells)
    : spacing_(spacing) {
  const Eigen::AlignedBox3d& box = shape.bounds();
  if (!box.min().allFinite() || !box.max().allFinite()) {
    throw InvalidArgument("the shape is unbounded: its box runs from " + describe(box.min()) +
                          " to " + describe(box.max()) + "; intersect it with a finite shape");
  }
  origin_ = box.min() - spacing * (kMargin + shift);
  const Eigen::Vector3d cells = ((box.max() - origin_) / spacing + kMargin).array() + 1;
  const Eigen::Vector3d blocks = (cells / kBlockCells).array().ceil();
  // One value is needed for each block, so the box is bounded too, though far less strictly.
  const double most_blocks = static_cast<double>(max_cells);
  if (!(blocks.prod() <= most_blocks)) {
    throw InvalidArgument("a spacing of " + describe(spacing) + " m needs " +
                          describe(cells.prod()) + " lattice cells for a box of " +
                          describe(Eigen::Vector3d(box.sizes())) + " m; the limit is " +
                          std::to_string(max_cells) + " near the shape; a larger one needs fewer");
  }
  block_count_ = blocks.cast<int>();
  slot_of_block_.assign(static_cast<std::size_t>(block_count_.prod()), kInvalidIndex);

  // A value of this size at its centre rules out a change of sign in a block and one cell around
  // it, for values that change 1.3 times as fast as a distance.
  const double far = 1.3 * (std::numbers::sqrt3 / 2 * kBlockCells + 1) * spacing;
  std::size_t block = 0;
  for (int z = 0; z < block_count_.z(); ++z) {
    for (int y = 0; y < block_count_.y(); ++y) {
      for (int x = 0; x < block_count_.x(); ++x, ++block) {
        const Site corner = 2 * kBlockCells * Site(x, y, z);
        const double middle = checked_value(shape, position(corner + Site::Constant(kBlockCells)));
        if (middle > far) {
          continue;
        }
        const auto slot = static_cast<Index>(block_of_slot_.size());
        constexpr int kCells = kBlockSites / 2;
        if (static_cast<std::int64_t>(slot + 1) * kCells > max_cells) {
          throw InvalidArgument("a spacing of " + describe(spacing) + " m needs more than " +
                                std::to_string(max_cells) +
                                " lattice cells in and near the shape (" + describe(cells.prod()) +
                                " in its box), which is the limit; a larger spacing needs fewer");
        }
        slot_of_block_[block] = slot;
        block_of_slot_.push_back(static_cast<Index>(block));
        values_.resize(values_.size() + kBlockSites, middle);
        if (middle >= -far) {
          const Index first = slot * kBlockSites;
          for (Index address = first; address < first + kBlockSites; ++address) {
            values_[address] = checked_value(shape, position(site_at(address)));
          }
        }
      }
    }
  }
}

Site Lattice::site_at(Index address) const {
  int local = address % kBlockSites;
  const int parity = local & 1;
  local >>= 1;
  const Site cell(local % kBlockCells, local / kBlockCells % kBlockCells,
                  local / (kBlockCells * kBlockCells));
  const int block = block_of_slot_[address / kBlockSites];
  const Site corner(block % block_count_.x(), block / block_count_.x() % block_count_.y(),
                    block / (block_count_.x() * block_count_.y()));
  return 2 * (kBlockCells * corner + cell) + Site::Constant(parity);
}

Index Lattice::address(const Site& site) const {
  if ((site.array() < 0).any()) {
    return kInvalidIndex;
  }
  const Site cell = site / 2;
  const Site corner = cell / kBlockCells;
  if ((corner.array() >= block_count_.array()).any()) {
    return kInvalidIndex;
  }
  const Index slot =
      slot_of_block_[(static_cast<std::size_t>(corner.z()) * block_count_.y() + corner.y()) *
                         block_count_.x() +
                     corner.x()];
  if (slot == kInvalidIndex) {
    return kInvalidIndex;
  }
  const Site local = cell - kBlockCells * corner;
  return slot * kBlockSites +
         2 * ((local.z() * kBlockCells + local.y()) * kBlockCells + local.x()) + (site.x() & 1);
}

}  // namespace pbdsurg
