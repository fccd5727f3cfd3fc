#include "tests/support/allocation_guard.h"

#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <new>

namespace {

thread_local bool guard_is_on = false;

void forbid(const char* what) noexcept {
  if (!guard_is_on) return;
  guard_is_on = false;  // the message may allocate
  std::fprintf(stderr, "%s under an AllocationGuard\n", what);
  std::abort();
}

void* allocate(std::size_t size, std::size_t alignment) {
  forbid("operator new");
  if (size == 0) size = 1;
  // aligned_alloc wants a multiple of the alignment.
  void* p = alignment <= alignof(std::max_align_t)
                ? std::malloc(size)
                : std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (p == nullptr) throw std::bad_alloc();
  return p;
}

void release(void* p) noexcept {
  if (p != nullptr) forbid("operator delete");
  std::free(p);
}

}  // namespace

// The array forms call these. The nothrow forms would too, except for AddressSanitizer's own.
void* operator new(std::size_t size) { return allocate(size, 1); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<std::size_t>(alignment));
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  try {
    return allocate(size, 1);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}
void operator delete(void* p) noexcept { release(p); }
void operator delete(void* p, std::size_t) noexcept { release(p); }
void operator delete(void* p, const std::nothrow_t&) noexcept { release(p); }
void operator delete(void* p, std::align_val_t) noexcept { release(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { release(p); }

namespace kerf {

AllocationGuard::AllocationGuard() noexcept : was_on_(guard_is_on) { guard_is_on = true; }
AllocationGuard::~AllocationGuard() { guard_is_on = was_on_; }

}  // namespace kerf
