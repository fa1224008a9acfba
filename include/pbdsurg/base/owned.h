// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What objects are made of that can be moved from.

#include <memory>
#include <string>
#include <utility>

#include "pbdsurg/base/error.h"

namespace pbdsurg {

/// Refuses a call to what was moved from.
/// @param who  "a solver"
/// @throws InvalidArgument  saying that it was moved from
[[noreturn]] inline void throw_moved_from(const char* who) {
  throw InvalidArgument(std::string(who) +
                        " was moved from; it can only be destroyed or assigned to");
}

/// The sole owner of what an object is made of. Once that has moved on, it throws in place of
/// following a null pointer: keep a reference to what it owns in loops.
/// @tparam T  may be incomplete; says in `static constexpr const char* kWho` of what it is the
/// inside
template <class T>
class Owned {
 public:
  Owned() = default;
  /// Takes over what may be null.
  Owned(std::unique_ptr<T> object) noexcept : object_(std::move(object)) {}

  /// What it owns.
  /// @throws InvalidArgument  if there is none
  T& operator*() const {
    if (object_ == nullptr) {
      throw_moved_from(T::kWho);
    }
    return *object_;
  }
  /// Likewise.
  /// @throws InvalidArgument  if there is none
  T* operator->() const { return &**this; }

  /// Takes over another.
  /// @return  what there was
  std::unique_ptr<T> exchange(std::unique_ptr<T> object) noexcept {
    object_.swap(object);
    return object;
  }

 private:
  std::unique_ptr<T> object_;
};

}  // namespace pbdsurg
