// Proves that a piece of code neither allocates nor frees: while an AllocationGuard lives, operator new and delete of
// this thread end the program with a message. Link tests/support/allocation_guard.cpp, which replaces the operators;
// only the test programs that use it do. malloc() called by name is not seen.
#pragma once

namespace kerf {

class AllocationGuard {
 public:
  AllocationGuard() noexcept;
  ~AllocationGuard();
  AllocationGuard(const AllocationGuard&) = delete;
  AllocationGuard& operator=(const AllocationGuard&) = delete;

 private:
  bool was_on_;
};

}  // namespace kerf
