#include "sim/session/state_bytes.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <unordered_map>

#include "sim/pieces/make_piece.h"

namespace kerf {
namespace {

constexpr std::uint32_t kHasHole = 1u << 16;  // in the count of a cut's planes

constexpr std::uint32_t kStateVersion = 8;

// Little-endian, doubles with every bit.
class Writer {
 public:
  void u32(std::uint32_t v) { put(v); }
  void u64(std::uint64_t v) { put(v); }
  void f64(double v) { put(std::bit_cast<std::uint64_t>(v)); }
  void vec(const Vec3d& v) {
    f64(v[0]);
    f64(v[1]);
    f64(v[2]);
  }
  void brick(const Vec3i& v) {
    for (int c = 0; c < 3; ++c) u32(static_cast<std::uint32_t>(v[c]));
  }
  void pose(const Rigid3& p) {
    f64(p.rotation.w());
    vec(p.rotation.vec());
    vec(p.translation);
  }
  void floats(const float* from, int count) {
    for (int n = 0; n < count; ++n) u32(std::bit_cast<std::uint32_t>(from[n]));
  }
  void bytes(const std::uint8_t* from, int count) {
    for (int n = 0; n < count; ++n) out.push_back(std::byte{from[n]});
  }
  std::vector<std::byte> out;

 private:
  template <class T>
  void put(T v) {
    for (std::size_t i = 0; i < sizeof(T); ++i) out.push_back(static_cast<std::byte>(v >> (8 * i)));
  }
};

// After the end it gives zeros and clears `is_good`; check that after each part.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> from) : from_(from) {}
  std::uint8_t u8() { return get<std::uint8_t>(); }
  std::uint32_t u32() { return get<std::uint32_t>(); }
  std::uint64_t u64() { return get<std::uint64_t>(); }
  double f64() { return std::bit_cast<double>(u64()); }
  Vec3d vec() {
    const double x = f64(), y = f64();
    return {x, y, f64()};
  }
  Vec3i brick() {
    Vec3i v;
    for (int c = 0; c < 3; ++c) v[c] = static_cast<int>(u32());
    return v;
  }
  Rigid3 pose() {
    Rigid3 p;
    p.rotation.w() = f64();
    p.rotation.vec() = vec();
    p.translation = vec();
    return p;
  }
  /// Reads a count of things of at least `bytes_each` bytes that can still follow; fails for a larger one.
  std::size_t count(std::size_t bytes_each) {
    const std::uint64_t claimed = u64();
    if (claimed > (from_.size() - at_) / bytes_each) is_good = false;
    return is_good ? static_cast<std::size_t>(claimed) : 0;
  }
  bool isAtEnd() const { return at_ == from_.size(); }
  std::size_t at() const { return at_; }
  bool is_good = true;

 private:
  template <class T>
  T get() {
    if (from_.size() - at_ < sizeof(T)) {
      is_good = false;
      at_ = from_.size();
      return 0;
    }
    T v = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i)
      v = static_cast<T>(v | static_cast<T>(std::to_integer<T>(from_[at_ + i]) << (8 * i)));
    at_ += sizeof(T);
    return v;
  }
  std::span<const std::byte> from_;
  std::size_t at_ = 0;
};

bool hasOtherMaterials(const CutObject::Slot& slot) {
  return slot.own_materials && std::memcmp(slot.own_materials, slot.baked_materials, kBrickNodes) != 0;
}

void packObject(const CutObject& object, const ContactTurns& turns, std::size_t loaded, Writer& to) {
  const bool has_turns = turns.isActiveFor(object);
  to.u32(static_cast<std::uint32_t>(loaded));
  to.u32((object.bricks().isPiece() ? 1u : 0u) | (object.isFrozen() ? 2u : 0u) | (object.is_core_clear ? 4u : 0u) |
         (has_turns ? 8u : 0u) | (object.is_tip_clear ? 16u : 0u));
  to.u32(object.id);
  to.pose(object.T_world_object);
  to.f64(object.core_load);
  to.f64(object.cut_area.byLedger());
  to.f64(object.cut_area.byShell());
  for (std::size_t m = 0; m < 256; ++m) {
    to.f64(object.removed_mm3[m]);
    to.f64(object.added_mm3[m]);
  }

  const std::size_t sides = object.plane_sides ? object.plane_sides->size() : 0;
  to.u64(sides);
  for (std::size_t n = 0; n < sides; ++n) {
    const PlaneSide& side = (*object.plane_sides)[n];
    to.u32(side.cut);
    to.u32(side.is_above);
    to.f64(side.planes.kerf_mm);
    to.u32(side.planes.count | (side.planes.hasHole() ? kHasHole : 0));
    for (std::size_t p = 0; p < side.planes.count; ++p)
      for (const double number : side.planes.numbers[p]) to.f64(number);
    if (side.planes.hasHole())
      for (const double number : side.planes.hole_numbers) to.f64(number);
  }

  // A piece's first bricks; then, for any object, air bricks that it took on.
  const auto putBricks = [&](int begin, int end) {
    std::uint64_t count = 0;
    for (int n = begin; n < end; ++n) count += object.bricks().has(n);
    to.u64(count);
    for (int n = begin; n < end; ++n)
      if (object.bricks().has(n)) to.brick(object.slot(n).brick);
  };
  if (object.bricks().isPiece()) putBricks(0, object.bricks().firstSlotCount());
  putBricks(object.bricks().firstSlotCount(), object.slotCount());

  // Values and materials that differ from the loaded ones.
  std::vector<int> changed;
  for (int n = 0; n < object.slotCount(); ++n)
    if (object.slot(n).own && (std::memcmp(object.slot(n).own, object.slot(n).baked, sizeof(BrickValues)) != 0 ||
                               hasOtherMaterials(object.slot(n))))
      changed.push_back(n);
  to.u64(changed.size());
  for (const int s : changed) {
    const CutObject::Slot& slot = object.slot(s);
    to.brick(slot.brick);
    to.u32(hasOtherMaterials(slot));
    to.floats(slot.own, kBrickNodes);
    if (hasOtherMaterials(slot)) to.bytes(slot.own_materials, kBrickNodes);
  }

  if (!has_turns) return;
  ContactTurns packed = turns;
  packed.forEachNumber([&](double& number) { to.f64(number); });
}

struct ChangedBrick {
  BrickEdit edit;
  bool has_materials = false;
  std::array<std::uint8_t, kBrickNodes> materials{};
};

std::vector<Vec3i> readBricks(Reader& from) {
  std::vector<Vec3i> out(from.count(12));
  for (Vec3i& brick : out) brick = from.brick();
  return out;
}

std::vector<ChangedBrick> readChanged(Reader& from) {
  std::vector<ChangedBrick> out(from.count(16 + 4 * kBrickNodes));
  for (ChangedBrick& c : out) {
    c.edit.brick = from.brick();
    c.has_materials = from.u32() != 0;
    for (float& v : c.edit.phi) {
      v = std::bit_cast<float>(from.u32());
      from.is_good = from.is_good && std::isfinite(v);
    }
    if (c.has_materials)
      for (std::uint8_t& m : c.materials) m = from.u8();
  }
  return out;
}

PlaneSides readPlaneSides(Reader& from) {
  std::vector<PlaneSide> out(from.count(20));
  for (PlaneSide& side : out) {
    side.cut = from.u32();
    side.is_above = from.u32() != 0;
    side.planes.kerf_mm = from.f64();
    const std::uint32_t count = from.u32();
    side.planes.count = std::min<std::uint32_t>(count & ~kHasHole, CutPlanes::kMost + 1);
    for (std::size_t p = 0; p < std::min<std::size_t>(side.planes.count, CutPlanes::kMost); ++p)
      for (double& number : side.planes.numbers[p]) number = from.f64();
    if (count & kHasHole)
      for (double& number : side.planes.hole_numbers) number = from.f64();
    from.is_good = from.is_good && side.planes.isUsable();
  }
  return out.empty() ? nullptr : std::make_shared<const std::vector<PlaneSide>>(std::move(out));
}

// The bricks of a piece in the form for makePiece(); empty if `whole` lacks any, or one is there twice.
PieceBricks pieceOf(CutObject& whole, std::vector<Vec3i> bricks, const std::vector<ChangedBrick>& changed) {
  const auto isBefore = [](const Vec3i& a, const Vec3i& b) { return coordKey(a) < coordKey(b); };
  std::sort(bricks.begin(), bricks.end(), isBefore);
  std::unordered_map<std::uint64_t, const BrickEdit*> edits;
  for (const ChangedBrick& c : changed) edits[coordKey(c.edit.brick)] = &c.edit;

  PieceBricks out;
  for (std::size_t n = 0; n < bricks.size(); ++n) {
    const Vec3i& c = bricks[n];
    if (n > 0 && bricks[n - 1] == c) return {};
    if (whole.find(c) < 0 && whole.addAir(c) < 0) return {};
    const auto edit = edits.find(coordKey(c));
    const bool is_constant =
        edit == edits.end() && whole.slot(whole.find(c)).phi[0] < 0 && !whole.baked().phi0().valuesAt(c);
    if (is_constant) {
      out.interior.push_back(c);
      continue;
    }
    out.bricks.push_back(c);
    out.at_edge.push_back(c);
    if (edit != edits.end()) out.changed.push_back(*edit->second);
  }
  return out;
}

// Null: the bytes do not describe such an object.
// @param turns  of the object.
std::optional<CutObject> unpackObject(Reader& from, const LoadedObjects& loaded, ContactTurns& turns) {
  // All of its bytes.
  const std::size_t index = from.u32();
  const std::uint32_t flags = from.u32();
  const std::uint32_t id = from.u32();
  const bool is_piece = flags & 1;
  const Rigid3 pose = from.pose();
  const double core_load = from.f64();
  const double by_ledger = from.f64(), by_shell = from.f64();
  std::array<double, 256> removed{}, added{};
  for (std::size_t m = 0; m < 256; ++m) {
    removed[m] = from.f64();
    added[m] = from.f64();
  }
  PlaneSides sides = readPlaneSides(from);
  std::vector<Vec3i> own;
  if (is_piece) own = readBricks(from);
  const std::vector<Vec3i> air = readBricks(from);
  const std::vector<ChangedBrick> changed = readChanged(from);
  if (flags & 8) {
    turns.forEachNumber([&](double& number) {
      number = from.f64();
      const bool is_number = std::abs(number) < 1e15;  // an integer that it may become can hold it
      from.is_good = from.is_good && is_number;
      if (!is_number) number = 0;
    });
    from.is_good = from.is_good && turns.isUsable();
  }
  if (!from.is_good || index >= loaded.size() || !pose.isUsable() || !(core_load >= 0) || !std::isfinite(core_load) ||
      !(by_ledger >= 0) || !std::isfinite(by_ledger) || !(by_shell >= 0) || !std::isfinite(by_shell) ||
      air.size() > CutObject::kMostAdded)
    return {};

  // The object as loaded or as it came off, then what changed.
  CutObject object(loaded[index], is_piece ? 1 : changed.size() + 64);
  if (is_piece) {
    const std::size_t wanted = own.size();
    const PieceBricks bricks = pieceOf(object, std::move(own), changed);
    if (wanted == 0 || bricks.bricks.size() + bricks.interior.size() != wanted) return {};
    object = makePiece(object, bricks);
  }
  for (const Vec3i& brick : air)
    if (object.find(brick) >= 0 || object.addAir(brick) < 0) return {};
  for (const ChangedBrick& c : changed) {
    const int s = object.find(c.edit.brick);
    if (s < 0 || !object.restore(s, c.edit.phi, c.has_materials ? c.materials.data() : nullptr)) return {};
  }
  while (!object.repair())
    if (!object.reserve(1024)) return {};

  object.strokes().end();  // initial state: nothing to undo
  object.T_world_object = pose;
  object.id = id;
  object.plane_sides = std::move(sides);
  object.core_load = core_load;
  object.cut_area = CutArea(by_ledger, by_shell);
  object.is_core_clear = flags & 4;
  object.is_tip_clear = flags & 16;
  if (flags & 2) object.freeze();
  object.removed_mm3 = removed;
  object.added_mm3 = added;
  turns.belongTo(object.contactEpoch());
  return object;
}

// Everything outside the objects, in this order.
void packHead(const State& state, Writer& to) {
  to.u64(state.tick);
  to.u64(state.tool);
  to.f64(state.speed);
  to.f64(state.ramp);
  to.u32(static_cast<std::uint32_t>(state.adds));
  to.u32(static_cast<std::uint32_t>(state.adds_to));
  to.u32((state.has_device ? 1u : 0u) | (state.is_latched ? 2u : 0u));

  to.pose(state.body.pose);
  to.vec(state.body.velocity);
  to.vec(state.body.angular);
  to.pose(state.device.pose);
  to.vec(state.device.velocity);
  to.vec(state.device.angular);
  to.vec(state.last_force.force);
  to.vec(state.last_force.torque);
  to.f64(state.core_drag.drag);
  to.vec(state.core_drag.moment);
  for (int column = 0; column < 3; ++column) to.vec(state.core_drag.second.col(column));
  for (const double number : state.core_drag.normal.reshaped()) to.f64(number);
  for (const double number : state.grip) to.f64(number);
  to.u32(state.next_id);
}

void unpackHead(Reader& from, State& out) {
  out.tick = from.u64();
  out.tool = from.u64();
  out.speed = from.f64();
  out.ramp = from.f64();
  out.adds = static_cast<Material>(from.u32() & 255);
  out.adds_to = from.u32();
  const std::uint32_t flags = from.u32();
  out.has_device = flags & 1;
  out.is_latched = flags & 2;

  out.body.pose = from.pose();
  out.body.velocity = from.vec();
  out.body.angular = from.vec();
  out.device.pose = from.pose();
  out.device.velocity = from.vec();
  out.device.angular = from.vec();
  out.last_force.force = from.vec();
  out.last_force.torque = from.vec();
  out.core_drag.drag = from.f64();
  out.core_drag.moment = from.vec();
  for (int column = 0; column < 3; ++column) out.core_drag.second.col(column) = from.vec();
  for (double& number : out.core_drag.normal.reshaped()) number = from.f64();
  for (double& number : out.grip) number = from.f64();
  out.next_id = from.u32();
}

bool isHeadUsable(const State& s) {
  return std::isfinite(s.speed) && std::isfinite(s.ramp) && s.body.velocity.allFinite() && s.body.angular.allFinite() &&
         s.device.velocity.allFinite() && s.device.angular.allFinite() && s.last_force.force.allFinite() &&
         s.last_force.torque.allFinite() && std::isfinite(s.core_drag.drag) && s.core_drag.moment.allFinite() &&
         s.core_drag.second.allFinite() && s.core_drag.normal.allFinite() && s.grip.allFinite() &&
         s.body.pose.isUsable() && s.device.pose.isUsable();
}

// The first object that breaks a rule: ids are unique and below next_id, and at most one object is frozen.
std::optional<std::size_t> firstThatClashes(const State& state) {
  for (std::size_t n = 0; n < state.objects.size(); ++n) {
    const CutObject& object = state.objects[n];
    if (object.id >= state.next_id) return n;
    for (std::size_t m = 0; m < n; ++m) {
      const CutObject& other = state.objects[m];
      if (other.id == object.id || (other.isFrozen() && object.isFrozen())) return n;
    }
  }
  return std::nullopt;
}

}  // namespace

bool isStateOfThisVersion(std::span<const std::byte> bytes) { return Reader(bytes).u32() == kStateVersion; }

std::vector<std::byte> packState(const State& state, const LoadedObjects& loaded) {
  Writer to;
  to.u32(kStateVersion);
  packHead(state, to);
  to.u32(static_cast<std::uint32_t>(state.objects.size()));
  for (std::size_t n = 0; n < state.objects.size(); ++n) {
    const CutObject& object = state.objects[n];
    std::size_t index = 0;
    while (index < loaded.size() && loaded[index].get() != &object.baked()) ++index;
    packObject(object, state.turns[n], index, to);
  }
  return std::move(to.out);
}

Expected<State> unpackState(std::span<const std::byte> bytes, const LoadedObjects& loaded, const std::string& file) {
  const auto refuse = [&](const std::string& what) {
    return fail({.code = Error::Code::kBadValue,
                 .file = file,
                 .place = "snapshot",
                 .found = what,
                 .expected = "the state of a session with these objects",
                 .hint = "the log fits another case or version; replay from its beginning"});
  };
  Reader from(bytes);
  if (const std::uint32_t version = from.u32(); version != kStateVersion)
    return refuse(fmt::format("version {}, not {}", version, kStateVersion));

  State out;
  unpackHead(from, out);
  const std::uint32_t count = from.u32();
  if (!from.is_good || !isHeadUsable(out) || count > kMostObjects)
    return refuse(fmt::format("no state in its first {} bytes", from.at()));

  out.objects.reserve(kMostObjects);
  for (std::uint32_t n = 0; n < count; ++n) {
    std::optional<CutObject> object = unpackObject(from, loaded, out.turns[n]);
    if (!object) return refuse(fmt::format("object {} is not loaded, or is cut short", n));
    out.objects.push_back(std::move(*object));
  }
  if (const auto n = firstThatClashes(out))
    return refuse(fmt::format("object {} has the id of another object, or is frozen together with another", *n));
  if (!from.isAtEnd()) return refuse(fmt::format("{} bytes too many", bytes.size() - from.at()));
  return out;
}

}  // namespace kerf
