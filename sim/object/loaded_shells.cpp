#include "sim/object/loaded_shells.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <span>

#include "sim/object/huge_pages.h"

namespace kerf {

void LoadedShells::reserve(const BakedObject& baked, std::size_t most_chunks) {
  if (!ring_.empty()) return;
  const std::size_t chunks = std::clamp(baked.shellChunks(), std::size_t{kShellChunks}, most_chunks);
  internal::reserveLarge(ring_, chunks);
  ring_.resize(chunks);
  owners_.assign(chunks, kNobody);
}

void LoadedShells::make(BrickStore& bricks, int s) noexcept {
  BrickSlot& slot = bricks.slot(s);
  assert(!slot.owns_shell && slot.shell_count > 0);
  const auto chunks = static_cast<std::size_t>(chunkCount(slot.shell_count));
  if (next_ + chunks > ring_.size()) next_ = 0;
  for (std::size_t c = 0; c < chunks; ++c) free(bricks, next_ + c);

  // The last chunk is filled up to its end: no write goes beyond these.
  const BakedObject& baked = bricks.baked();
  const std::int32_t loaded = baked.directory().find(slot.brick);
  baked.shellOf(baked.slots()[static_cast<std::size_t>(loaded)], &ring_[next_]);
  std::array<ShellChunk*, kShellChunks> made{};
  for (std::size_t c = 0; c < chunks; ++c) {
    made[c] = &ring_[next_ + c];
    owners_[next_ + c] = s;
  }
  slot.setShell(std::span(made).first(chunks));
  next_ += chunks;
}

// Takes the shell from the former owner, unless that slot has none or another one by now.
void LoadedShells::free(BrickStore& bricks, std::size_t chunk) noexcept {
  if (owners_[chunk] == kNobody) return;
  BrickSlot& owner = bricks.slot(owners_[chunk]);
  if (!owner.shell || owner.owns_shell) return;
  // A shell of the ring is a row of its chunks.
  const auto first = static_cast<std::size_t>(owner.shell - ring_.data());
  if (first <= chunk && chunk < first + static_cast<std::size_t>(chunkCount(owner.shell_count))) owner.shell = nullptr;
}

}  // namespace kerf
