// SPDX-License-Identifier: Apache-2.0
#include "tests/support/allocation_count.h"

#include <cstddef>
#include <cstdlib>
#include <new>

namespace pbdsurg::testing {

std::atomic<long> allocation_count{0};
std::atomic<long> allocation_limit{kNoLimit};

namespace {

void* allocate(std::size_t size, std::size_t alignment) {
  if (allocation_count >= allocation_limit) {
    throw std::bad_alloc();
  }
  ++allocation_count;
  void* memory = std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (memory == nullptr) {
    throw std::bad_alloc();
  }
  return memory;
}

}  // namespace
}  // namespace pbdsurg::testing

void* operator new(std::size_t size) {
  return pbdsurg::testing::allocate(size, alignof(std::max_align_t));
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  return pbdsurg::testing::allocate(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}
