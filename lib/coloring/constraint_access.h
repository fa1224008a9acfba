// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// ConstraintVertices as inner loops read them, on host and device: the arities that matter are
/// known at compile time.

#include <utility>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/coloring/constraint_vertices.h"

namespace pbdsurg {

/// The vertices of one constraint, in registers.
template <int kArity>
struct alignas(kArity == 4 ? 16 : (kArity == 2 ? 8 : 4)) VertexIds {
  Index ids[kArity];

  PBDSURG_HOST_DEVICE static constexpr int size() { return kArity; }
  PBDSURG_HOST_DEVICE Index operator[](int i) const { return ids[i]; }
  PBDSURG_HOST_DEVICE const Index* begin() const { return ids; }
  PBDSURG_HOST_DEVICE const Index* end() const { return ids + kArity; }
};

template <int kArity>
struct FixedArity {
  const Index* vertices = nullptr;  ///< [count * kArity]
  Index count = 0;

  /// Where the vertices of a constraint begin.
  PBDSURG_HOST_DEVICE static Index first_entry(Index constraint) { return constraint * kArity; }

  PBDSURG_HOST_DEVICE VertexIds<kArity> operator[](Index constraint) const {
#if defined(__CUDA_ARCH__)
    // device arrays are aligned for one wide load
    return reinterpret_cast<const VertexIds<kArity>*>(vertices)[constraint];
#else
    VertexIds<kArity> result;
    for (int i = 0; i < kArity; ++i) {
      result.ids[i] = vertices[first_entry(constraint) + i];
    }
    return result;
#endif
  }
};

/// The vertices of one constraint, in memory.
struct VertexRange {
  const Index* first;
  const Index* last;

  PBDSURG_HOST_DEVICE int size() const { return static_cast<int>(last - first); }
  PBDSURG_HOST_DEVICE Index operator[](int i) const { return first[i]; }
  PBDSURG_HOST_DEVICE const Index* begin() const { return first; }
  PBDSURG_HOST_DEVICE const Index* end() const { return last; }
};

struct AnyArity {
  const Index* vertices = nullptr;
  const Index* offsets = nullptr;  ///< [count + 1], or nullptr: `arity` vertices each
  Index count = 0;
  int arity = 0;

  PBDSURG_HOST_DEVICE Index first_entry(Index constraint) const {
    return offsets != nullptr ? offsets[constraint] : constraint * arity;
  }

  PBDSURG_HOST_DEVICE VertexRange operator[](Index constraint) const {
    const Index* first = vertices + first_entry(constraint);
    return {first, offsets != nullptr ? vertices + offsets[constraint + 1] : first + arity};
  }
};

/// Calls f(access) with a FixedArity or AnyArity made of these arrays.
template <class F>
void with_arity(const ConstraintVertices& constraints, F&& f) {
  const Index* vertices = constraints.vertices.data();
  const Index count = constraints.constraint_count();
  switch (constraints.arity) {
    case 2:
      return std::forward<F>(f)(FixedArity<2>{vertices, count});
    case 4:
      return std::forward<F>(f)(FixedArity<4>{vertices, count});
    default:
      return std::forward<F>(f)(
          AnyArity{vertices, constraints.arity == 0 ? constraints.offsets.data() : nullptr, count,
                   constraints.arity});
  }
}

}  // namespace pbdsurg
