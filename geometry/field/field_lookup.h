// The loop behind ToolField: many look-ups at once, with the processor's vector instructions.
#pragma once

#include <array>

namespace kerf::internal {

enum class TableForm : int {
  kSpatial,
  kRevolved,
  kPlate,
  kBox  ///< no table: the distance to the box from `low` to `high` is a formula
};

/// A tool's table for the loop: see ToolField.
struct FieldTable {
  const float* values = nullptr;  ///< kBox: not read
  TableForm form = TableForm::kSpatial;
  float inverse = 1;                             ///< samples per mm
  float half = 0;                                ///< half thickness of a plate, mm
  float reach = 0;                               ///< valid range of the table beyond the solid, mm
  std::array<float, 3> low{}, high{}, origin{};  ///< box of the solid, and the table's first sample, mm
  std::array<int, 3> size{0, 0, 1};
};

/// Distances at n points, n a multiple of 8. The same bits with any instruction set: no fused multiply-add, no
/// reordering between lanes.
void lookUp(const FieldTable& table, const float* x, const float* y, const float* z, float* out, int n) noexcept;

}  // namespace kerf::internal
