// Proves that a piece of code neither allocates nor frees: while an AllocationGuard lives, operator new and delete of
// this thread end the program with a message. Link tests/support/allocation_guard.cpp, which replaces the operators;
// only its test programs do. A direct malloc() is not detected.
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
