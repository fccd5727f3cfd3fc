#include "sim/pieces/joined_field.h"

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <vector>

namespace kerf {
namespace {

void collect(const BrickField& field, std::vector<std::uint64_t>& keys) {
  for (std::size_t b = 0; b < field.brickCount(); ++b) keys.push_back(coordKey(field.brickCoord(b)));
  for (const Vec3i& brick : field.interiorBricks()) keys.push_back(coordKey(brick));
}

// Lowers `out` to the part's values in a brick.
void lowerTo(const FieldPart& part, const Vec3i& brick, BrickValues& out) {
  const BrickValues* values = part.changed ? part.changed->valuesAt(brick) : nullptr;
  if (!values && part.begin) values = part.begin->valuesAt(brick);
  if (values) {
    for (std::size_t n = 0; n < out.size(); ++n) out[n] = std::min(out[n], (*values)[n]);
    return;
  }
  if (!part.begin) return;
  const float constant = part.begin->constantAt(brick);
  for (float& value : out) value = std::min(value, constant);
}

std::vector<Vec3i> bricksOf(std::initializer_list<const BrickField*> fields) {
  std::vector<std::uint64_t> keys;
  for (const BrickField* const field : fields)
    if (field) collect(*field, keys);
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());

  std::vector<Vec3i> out;
  out.reserve(keys.size());
  for (const std::uint64_t key : keys) {
    const auto at = coordOfKey(key);
    out.push_back({at[0], at[1], at[2]});
  }
  return out;
}

bool isAsLoaded(const BrickField& loaded, const Vec3i& brick, const BrickValues& values) {
  if (const BrickValues* const before = loaded.valuesAt(brick)) return *before == values;
  const float constant = loaded.constantAt(brick);
  return std::all_of(values.begin(), values.end(), [constant](float value) { return value == constant; });
}

}  // namespace

BrickField joinedChanges(const BrickField& loaded, std::span<const FieldPart> parts) {
  std::vector<std::uint64_t> keys;
  collect(loaded, keys);
  for (const FieldPart& part : parts) {
    if (part.begin) collect(*part.begin, keys);
    if (part.changed) collect(*part.changed, keys);
  }
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());

  BrickField out(loaded.voxel(), loaded.background(), loaded.interior());
  BrickValues values;
  for (const std::uint64_t key : keys) {
    const auto at = coordOfKey(key);
    const Vec3i brick(at[0], at[1], at[2]);
    values.fill(loaded.background());
    for (const FieldPart& part : parts) lowerTo(part, brick, values);
    if (!isAsLoaded(loaded, brick, values)) out.add(brick, values);
  }
  return out;
}

Vec3d deepestPoint(const FieldPart& part) {
  constexpr float kFar = 1e9f;
  BrickValues values;
  float least = kFar;
  Vec3i node = Vec3i::Zero();
  for (const Vec3i& brick : bricksOf({part.begin, part.changed})) {
    values.fill(kFar);
    lowerTo(part, brick, values);
    const auto deepest = std::min_element(values.begin(), values.end());
    if (*deepest >= least) continue;
    least = *deepest;
    const auto n = static_cast<int>(deepest - values.begin());
    node = brick * kBrickSide + Vec3i(n >> (2 * kBrickLog), n >> kBrickLog & 7, n & 7);
  }
  const BrickField* const any = part.begin ? part.begin : part.changed;
  return any ? any->position(node) : Vec3d::Zero();
}

BrickField fieldOf(const CutObject& object) {
  const BrickField& loaded = object.baked().phi0();
  BrickField out(loaded.voxel(), loaded.background(), loaded.interior());
  for (int s = 0; s < object.slotCount(); ++s) {
    if (!object.bricks().has(s)) continue;
    const CutObject::Slot& slot = object.slot(s);
    const float* const end = slot.phi + kBrickNodes;
    const bool is_interior = std::all_of(slot.phi, end, [&](float v) { return v == loaded.interior(); });
    if (is_interior)
      out.markInterior(slot.brick);
    else
      out.add(slot.brick, std::span<const float, kBrickNodes>(slot.phi, kBrickNodes));
  }
  return out;
}

}  // namespace kerf
