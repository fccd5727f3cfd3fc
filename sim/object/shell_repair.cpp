#include "sim/object/shell_repair.h"

namespace kerf {

void ShellRepair::reserve(std::size_t slots, bool is_touched) {
  dirty_.reserve(slots);
  to_repair_.reserve(slots);
  wanted_in_.assign(slots, 0);
  if (!is_touched) return;
  dirty_.reserveTouched(slots);
  to_repair_.resize(slots);
  to_repair_.clear();
}

bool ShellRepair::repairOne(int s, BrickStore& bricks, BrickMemory& memory) noexcept {
  BrickSlot& slot = bricks.slot(s);
  bricks.touch(s);
  const int count = shellOfBrick(bricks.around(slot), slot.materials, bricks.baked().voxel(), scratch_.data());
  const auto chunks = static_cast<std::size_t>(chunkCount(count));
  const std::size_t owned = slot.owns_shell ? static_cast<std::size_t>(chunkCount(slot.shell_count)) : 0;
  if (memory.freeChunks() + owned < chunks) return false;

  // Refills its own chunks. Takes more from memory, or gives back surplus ones.
  std::array<ShellChunk*, kShellChunks> next{};
  for (std::size_t c = 0; c < chunks; ++c)
    next[c] = c < owned ? const_cast<ShellChunk*>(&slot.chunk(c)) : memory.takeChunk();
  for (std::size_t c = chunks; c < owned; ++c) memory.giveBack(const_cast<ShellChunk*>(&slot.chunk(c)));

  for (std::size_t c = 0; c < chunks; ++c) *next[c] = scratch_[c];
  slot.setShell(std::span(next).first(chunks));
  slot.shell_count = static_cast<std::int16_t>(count);
  slot.owns_shell = true;
  return true;
}

void ShellRepair::spread(BrickStore& bricks) noexcept {
  for (std::size_t n = 0, count = dirty_.count(); n < count; ++n) {
    BrickSlot& slot = bricks.slot(dirty_.numbers()[n]);
    for (int face = 0; slot.changed_faces != 0 && face < 6; ++face) {
      if (!(slot.changed_faces >> face & 1)) continue;
      const int neighbor = bricks.findBeside(slot, face);
      if (neighbor >= 0 && bricks.slot(neighbor).shell_count > 0) dirty_.add(bricks.slot(neighbor), neighbor);
    }
    slot.changed_faces = 0;
  }
}

bool ShellRepair::repair(BrickStore& bricks, BrickMemory& memory) noexcept {
  ++round_;
  if (dirty_.isEmpty()) return true;  // frozen: others may read it, so write nothing

  // The dirty bricks, and the neighbours whose gradients they change, each once.
  to_repair_.clear();
  const auto want = [this](int s) {
    std::uint32_t& wanted_in = wanted_in_[static_cast<std::size_t>(s)];
    if (wanted_in == round_) return;
    wanted_in = round_;
    to_repair_.push_back(s);
  };
  for (const int s : dirty_.numbers()) {
    const BrickSlot& slot = bricks.slot(s);
    want(s);
    // A neighbour keeps its set of nodes, because its values did not change. Only gradients change, if it has nodes.
    for (int face = 0; face < 6; ++face) {
      if (!(slot.changed_faces >> face & 1)) continue;
      Vec3i next = slot.brick;
      next[face / 2] += face & 1 ? 1 : -1;
      const int neighbor = bricks.find(next);
      if (neighbor >= 0 && bricks.slot(neighbor).shell_count > 0) want(neighbor);
    }
  }

  for (const int s : to_repair_)
    if (!repairOne(s, bricks, memory)) return false;

  for (const int s : dirty_.numbers()) bricks.slot(s).changed_faces = 0;
  dirty_.clear(bricks.slots());
  return true;
}

}  // namespace kerf
