// SPDX-License-Identifier: Apache-2.0
#include "lib/heat/region_joints.h"

namespace pbdsurg {
namespace {

constexpr int kRings = 3;

constexpr Index kLoose = -2;  // as a parent: nothing that conducts is left there

}  // namespace

bool RegionJoints::hold_without(std::span<const Index> gone, const ThermalMesh& mesh,
                                const PotentialRegion& region, const RegionSearch& search,
                                const ElementSpan& conductivities) {
  if (parents_.size() < region.vertices.size()) {
    parents_.resize(region.vertices.size(), kInvalidIndex);
  }
  const bool hold = search_rings(gone, mesh, region, search, conductivities);
  for (const Index row : met_) {
    parents_[row] = kInvalidIndex;
  }
  met_.clear();
  return hold;
}

bool RegionJoints::search_rings(std::span<const Index> gone, const ThermalMesh& mesh,
                                const PotentialRegion& region, const RegionSearch& search,
                                const ElementSpan& conductivities) {
  for (const Index i : gone) {
    for (const Index row : region.corners[i]) {
      if (region.is_ground[row] != 0) {
        return false;
      }
      meet(row);
    }
  }
  bool has_loose = false;
  std::size_t next = 0;
  for (int ring = 0; ring < kRings; ++ring) {
    for (const std::size_t end = met_.size(); next < end; ++next) {
      const Index row = met_[next];
      bool is_loose = true;
      mesh.for_each_element(region.vertices[row], [&](Index t) {
        if (conductivities[t] == 0) {
          return;
        }
        is_loose = false;
        for (const Index v : mesh.corners(t)) {
          const Index other = search.row_of(v);
          if (region.is_ground[other] == 0) {
            meet(other);
            parents_[root(other)] = root(row);
          }
        }
      });
      if (is_loose) {
        parents_[row] = kLoose;
        has_loose = true;
      }
    }
    bool holds = true;
    Index common = kInvalidIndex;
    for (const Index i : gone) {
      if (!has_loose) {  // else they may have hung together by what is loose alone
        common = kInvalidIndex;
      }
      holds = holds && are_joined(region.corners[i], common);
    }
    if (holds) {
      return true;
    }
  }
  return false;
}

void RegionJoints::meet(Index row) {
  if (parents_[row] == kInvalidIndex) {
    parents_[row] = row;
    met_.push_back(row);
  }
}

Index RegionJoints::root(Index row) {
  while (parents_[row] != row) {
    row = parents_[row] = parents_[parents_[row]];
  }
  return row;
}

// Whether those of four rows that are not loose have a common root: this one, or if that is none
// yet, it becomes theirs.
bool RegionJoints::are_joined(const Tet& rows, Index& common) {
  for (const Index row : rows) {
    if (parents_[row] == kLoose) {
      continue;
    }
    const Index its = root(row);
    if (common != kInvalidIndex && its != common) {
      return false;
    }
    common = its;
  }
  return true;
}

}  // namespace pbdsurg
