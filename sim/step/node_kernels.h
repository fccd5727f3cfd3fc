// Loops over the nodes of a brick: their places in the tool's frame, and the nodes that touch it. With the processor's
// vector instructions; the same bits with any.
#pragma once

#include <cstdint>

namespace kerf::internal {

/// Nodes of a brick in the tool's frame: base + i along[0] + j along[1] + k along[2], float32. @param out  3 x 512.
void placeNodes(const float base[3], const float along[3][3], float* x, float* y, float* z) noexcept;

/// The same for the nodes of a shell's chunk, given by their offsets; count a multiple of 8.
void placeShell(const float base[3], const float along[3][3], const std::uint16_t* offsets, int count, float* x,
                float* y, float* z) noexcept;
/// values[offsets[n]], count a multiple of 8.
void valuesAt(const float* values, const std::uint16_t* offsets, int count, float* out) noexcept;

/// values[numbers[n]] for 256 values, one per number of a material; count a multiple of 8.
void valuesOf(const float* values, const std::uint8_t* numbers, int count, float* out) noexcept;

/// Largest of n numbers, n a multiple of 8.
float largestOf(const float* values, int n) noexcept;

/// Bits of those of a brick's 64 rows of 8 values, along its last axis, that have a value below `limit`.
std::uint64_t rowsBelow(const float* values, float limit) noexcept;

/// Nodes of `count` <= 64 that touch a tool: bits of those with min(cut, body) + phi < -least_overlap. Lowers
/// `least_gap` to the least of these sums. Reads all arrays up to the next multiple of 8.
/// @param body  null: none near.   @param least_overlap  mm: see ToolField::leastOverlap().
std::uint64_t touchingNodes(const float* cut, const float* body, const float* phi, int count, float least_overlap,
                            float& least_gap) noexcept;

}  // namespace kerf::internal
