// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/skin_record.h"

#include <algorithm>
#include <utility>

#include "pbdsurg/tissue/renumbering.h"
#include "pbdsurg/tissue/tissue_change.h"

namespace cholecystectomy {

using pbdsurg::Index;
using pbdsurg::kInvalidIndex;
using pbdsurg::Triangle;

SkinRecord::SkinRecord(const pbdsurg::Tissue& tissue, std::vector<Triangle> skin)
    : skin_(std::move(skin)) {
  for (Triangle& triangle : skin_) {
    std::ranges::sort(triangle);
  }
  std::ranges::sort(skin_);
  for (Index v = 0; v < tissue.vertex_count(); ++v) {
    origins_.push_back({v, kInvalidIndex, kInvalidIndex});
  }
  tissue.add_follower(*this);
}

SkinRecord::Origin SkinRecord::both(const Origin& a, const Origin& b) {
  if (a == kNone || b == kNone) {
    return kNone;
  }
  Origin sum = a;
  for (Index vertex : b) {
    for (Index& place : sum) {
      if (vertex == kInvalidIndex || vertex == place) {
        vertex = kInvalidIndex;
        break;
      }
      if (place == kInvalidIndex || vertex < place) {
        std::swap(place, vertex);
      }
    }
    if (vertex != kInvalidIndex) {
      return kNone;
    }
  }
  return sum;
}

bool SkinRecord::has(const Triangle& triangle) const {
  const auto& [a, b, c] = triangle;
  return std::ranges::binary_search(skin_, both(both(origins_[a], origins_[b]), origins_[c]));
}

void SkinRecord::follow(const pbdsurg::Tissue& tissue,
                        const pbdsurg::TissueChange& change) noexcept {
  for (const pbdsurg::NewVertex& vertex : change.edit.new_vertices) {
    origins_.push_back(both(origins_[vertex.first], origins_[vertex.second]));
  }
  origins_.resize(static_cast<std::size_t>(tissue.vertex_count()), kNone);  // of new bodies
}

void SkinRecord::undo(const pbdsurg::Tissue& tissue,
                      const pbdsurg::TissueChange& /*change*/) noexcept {
  origins_.resize(static_cast<std::size_t>(tissue.vertex_count()));
}

void SkinRecord::renumber(const pbdsurg::Tissue& tissue, const pbdsurg::Renumbering& ids) noexcept {
  std::vector<Origin> origins(static_cast<std::size_t>(tissue.vertex_count()), kNone);
  for (std::size_t v = 0; v < origins_.size(); ++v) {
    if (ids.vertices[v] != kInvalidIndex) {
      origins[ids.vertices[v]] = origins_[v];
    }
  }
  origins_ = std::move(origins);
}

}  // namespace cholecystectomy
