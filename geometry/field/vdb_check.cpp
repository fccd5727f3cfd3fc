// OpenVDB's reader allocates by counts and lengths from the file, and some of them make it read past a buffer. This
// walk takes the same steps through the file and rejects every inconsistency.
//
// Reason for a walk, and no child process with limits as for DICOM slices: a child would read every grid a second time,
// and a limit that lets a field of 2 GB pass also lets a small forged file take 2 GB.
//
// Layout of a grid (openvdb/tree/RootNode.h, InternalNode.h, LeafNode.h, io/Compression.h), after the part in
// vdb_header.cpp:
//
//   grid     u32 compression, metadata, string map, 15 doubles of a UniformScaleMap, i32 buffers = 1, root, buffers
//   root     background, u32 tiles, u32 children; tile: 3 i32, value, bool; child: 3 i32, node
//   node     child mask, value mask, values, its children: 32^3 of nodes, 16^3 of leaves; leaf: value mask
//   buffers  of each leaf: value mask, values
//   values   i8 kind, 0 to 2 inactive values, a mask of 0 or 1 bits for each, the values in a block
//   block    with compression i64 bytes: packed size, or the negative of the unpacked size; then these bytes
#include "geometry/field/vdb_check.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "geometry/field/vdb_bytes.h"

namespace kerf::internal {
namespace {

constexpr std::uint32_t kZip = 1, kActiveMask = 2, kBlosc = 4;
constexpr std::int64_t kValue = 4;                // bytes of a float or an int32
constexpr std::int64_t kMostMetadata = 16 << 20;  // bytes of one entry
constexpr std::int32_t kRootSide = 4096;          // nodes along a child of the root
constexpr std::int32_t kFarthest = 1 << 23;       // of a node from the origin: the range of coordKey()
constexpr std::int64_t kLeafNodes = 512, kLowNodes = 4096, kHighNodes = 32768;
constexpr std::int64_t kLeastHighNode = 2 * kHighNodes / 8 + 1;

const std::map<std::string_view, std::int32_t> kFixedSizes{{"bool", 1},   {"int32", 4},  {"float", 4},  {"int64", 8},
                                                           {"double", 8}, {"vec2i", 8},  {"vec2s", 8},  {"vec2d", 16},
                                                           {"vec3i", 12}, {"vec3s", 12}, {"vec3d", 24}, {"vec4i", 16},
                                                           {"vec4s", 16}, {"vec4d", 32}, {"mat4s", 64}, {"mat4d", 128}};

class GridWalk {
 public:
  GridWalk(VdbReader& in, std::string_view type) : in_(in), type_(type) {}

  /// The inconsistency and its byte; empty if the grid is safe to read.
  std::string fault() const {
    if (fault_.empty() && in_.isGood()) return {};
    return fmt::format("byte {}: {}", in_.at(), fault_.empty() ? "cut short, or a length that no file has" : fault_);
  }

  void file(const std::string& name) {
    if (in_.number<std::int64_t>() != kVdbMagic) return refuse("no OpenVDB file");
    const auto version = in_.number<std::uint32_t>();
    if (version < kOldestVdb || version > kNewestVdb) return refuse(fmt::format("version {}", version));
    in_.skip(8);  // version of the library
    if (in_.number<std::uint8_t>() != 1) return refuse("no index of its grids");
    in_.skip(36);  // identifier
    metadata();

    const auto count = in_.number<std::int32_t>();
    if (count < 0 || count > kMostVdbEntries) return refuse(fmt::format("{} grids", count));
    std::optional<Place> wanted;
    for (std::int32_t n = 0; n < count && isGood(); ++n) {
      const std::string found = in_.text(), stored = in_.text(), parent = in_.text();
      const Place place{in_.number<std::int64_t>(), in_.number<std::int64_t>(), in_.number<std::int64_t>()};
      if (place.begin < in_.at() || place.block < place.begin || place.end < place.block)
        return refuse("an index of grids that goes backwards");
      // OpenVDB cuts a name off at this character, and would find two equal names.
      if (found.find('\x1e') != found.npos || (found == name && wanted)) return refuse("two grids of one name");
      if (found == name) {
        if (stored != type_) return refuse(fmt::format("a grid of type {}", stored.substr(0, 40)));
        if (!parent.empty()) return refuse("a grid that shares the nodes of another");
        wanted = place;
      }
      in_.goTo(place.end);
    }
    if (!isGood() || !wanted) return;

    in_.goTo(wanted->begin);
    grid();
    if (isGood() && in_.at() != wanted->end) refuse(fmt::format("its end, which the index puts at {}", wanted->end));
  }

 private:
  struct Place {
    std::int64_t begin, block, end;
  };

  bool isGood() const { return fault_.empty() && in_.isGood(); }
  void refuse(std::string found) {
    if (fault_.empty()) fault_ = std::move(found);
  }

  void grid() {
    compression_ = in_.number<std::uint32_t>();
    if (compression_ > (kZip | kActiveMask | kBlosc)) return refuse(fmt::format("compression {}", compression_));
    metadata();
    transform();
    if (const auto buffers = in_.number<std::int32_t>(); buffers != 1)
      return refuse(fmt::format("{} buffers", buffers));
    root();
    if (isGood() && noted_leaves_ > leaves_)
      return refuse(fmt::format("notes on {} leaves, of which there are {}", noted_leaves_, leaves_));

    for (std::int64_t leaf = 0; leaf < leaves_ && isGood(); ++leaf) values(mask<kLeafNodes>(), kLeafNodes);
  }

  // OpenVDB reads an entry by its type, and ignores its size.
  void metadata() {
    in_.metadata([this](const std::string& name, const std::string& type, std::int32_t size) {
      if (size > kMostMetadata) return refuse(fmt::format("metadata of {} bytes", size));
      if (name == "is_saved_as_half_float" && in_.number<std::uint8_t>() != 0) return refuse("values of 16 bits");
      if (type == "string") return;
      if (type == "__delayedload") return delayedLoad(size);

      const auto fixed = kFixedSizes.find(type);
      if (fixed == kFixedSizes.end()) return refuse("metadata of a type that Kerf does not write");
      if (size != fixed->second) return refuse(fmt::format("metadata {} of {} bytes", type, size));
      if (type == "bool" && name != "is_saved_as_half_float" && in_.number<std::uint8_t>() > 1)
        refuse("metadata neither true nor false");
    });
  }

  // Places of the leaves' blocks, as grid metadata of OpenVDB: a count, and two lists of that length.
  void delayedLoad(std::int32_t size) {
    if (size == 0) return;
    const std::int64_t end = in_.at() + size;
    const auto count = in_.number<std::uint32_t>();
    noted_leaves_ = std::max<std::int64_t>(noted_leaves_, count);
    for (const std::int64_t width : {1, 8}) {
      const auto packed = in_.number<std::uint32_t>();
      const std::int64_t plain = width * count;
      if (width == 8 && packed == UINT32_MAX) break;  // none
      const std::int64_t bytes = packed > 0 ? packed : plain;
      if (bytes > end - in_.at()) return refuse("notes longer than their entry");
      if (packed > 0) {
        // Short lists are packed with zeros behind them, 128 bytes in all.
        bloscHeader(packed, std::max<std::int64_t>(plain, 128));
        in_.skip(packed - 16);
      } else {
        in_.skip(plain);
      }
    }
    if (isGood() && in_.at() != end) refuse("notes shorter than their entry");
  }

  void transform() {
    if (const std::string map = in_.text(); map != "UniformScaleMap")
      return refuse("a transform that is more than a uniform scale");
    // Scale, voxel size, and three vectors that follow from them.
    for (int n = 0; n < 15 && isGood(); ++n)
      if (const auto x = in_.number<double>(); !(x > 0 && std::isfinite(x)))
        return refuse("a transform without a size");
  }

  void root() {
    in_.skip(kValue);  // background
    const auto tiles = in_.number<std::uint32_t>(), children = in_.number<std::uint32_t>();
    constexpr std::int64_t kTile = 3 * 4 + kValue + 1;
    if (tiles > in_.left() / kTile || children > in_.left() / kLeastHighNode)
      return refuse(fmt::format("{} tiles and {} nodes in a file with {} bytes left", tiles, children, in_.left()));

    for (std::uint32_t n = 0; n < tiles && isGood(); ++n) {
      origin();
      in_.skip(kValue);
      if (in_.number<std::uint8_t>() > 1) refuse("a tile neither active nor not");
    }
    for (std::uint32_t n = 0; n < children && isGood(); ++n) {
      origin();
      highNode();
    }
  }

  void origin() {
    std::array<std::int32_t, 3> at{};
    for (std::int32_t& x : at) x = in_.number<std::int32_t>();
    for (const std::int32_t x : at)
      if (x % kRootSide != 0 || x < -kFarthest || x >= kFarthest)
        return refuse(fmt::format("a node at voxel {}, {}, {}: too far from the origin, or on no node's corner", at[0],
                                  at[1], at[2]));
    if (!origins_.insert(at).second) refuse(fmt::format("two nodes at voxel {}, {}, {}", at[0], at[1], at[2]));
  }

  void highNode() {
    const std::int64_t children = mask<kHighNodes>();
    const std::int64_t active = mask<kHighNodes>();
    values(active, kHighNodes);
    for (std::int64_t n = 0; n < children && isGood(); ++n) lowNode();
  }

  void lowNode() {
    const std::int64_t children = mask<kLowNodes>();
    const std::int64_t active = mask<kLowNodes>();
    values(active, kLowNodes);
    in_.skip(children * kLeafNodes / 8);
    leaves_ += children;
  }

  /// The bits that are set in a mask of `kBits`.
  template <std::int64_t kBits>
  std::int64_t mask() {
    std::array<std::uint64_t, static_cast<std::size_t>(kBits) / 64> words{};
    in_.read(reinterpret_cast<char*>(words.data()), sizeof words);
    std::int64_t on = 0;
    for (const std::uint64_t word : words) on += std::popcount(word);
    return on;
  }

  void values(std::int64_t active, std::int64_t all) {
    constexpr std::array<std::int64_t, 7> kInactiveValues{0, 0, 1, 0, 1, 2, 0};
    constexpr std::uint8_t kFirstWithMask = 3, kLastWithMask = 5, kAll = 6;
    const auto kind = in_.number<std::uint8_t>();
    if (kind > kAll) return refuse(fmt::format("values of kind {}", kind));

    in_.skip(kInactiveValues[kind] * kValue);
    if (kind >= kFirstWithMask && kind <= kLastWithMask) in_.skip(all / 8);
    block(kValue * ((compression_ & kActiveMask) != 0 && kind != kAll ? active : all));
  }

  void block(std::int64_t plain) {
    if ((compression_ & (kZip | kBlosc)) == 0) return in_.skip(plain);
    const auto packed = in_.number<std::int64_t>();
    if (packed == -plain) return in_.skip(plain);
    // Neither library makes a block longer by more than this.
    if (packed <= 0 || packed > plain + plain / 256 + 64)
      return refuse(fmt::format("a block of {} bytes for values of {}", packed, plain));
    if ((compression_ & kBlosc) == 0) return in_.skip(packed);
    bloscHeader(packed, plain);
    in_.skip(packed - 16);
  }

  // c-blosc, README_HEADER.rst: 4 bytes of versions and flags, then u32 unpacked, u32 block, u32 packed bytes.
  void bloscHeader(std::int64_t packed, std::int64_t plain) {
    in_.skip(4);
    const auto unpacked = in_.number<std::uint32_t>();
    in_.skip(4);
    const auto stated = in_.number<std::uint32_t>();
    if (packed < 16 || unpacked != plain || stated != packed)
      refuse(fmt::format("a packed block of {} bytes for {}, where {} for {} belong", stated, unpacked, packed, plain));
  }

  VdbReader& in_;
  std::string_view type_;
  std::string fault_;
  std::uint32_t compression_ = 0;
  std::int64_t leaves_ = 0, noted_leaves_ = 0;
  std::set<std::array<std::int32_t, 3>> origins_;
};

}  // namespace

Expected<void> checkVdbGrid(const std::filesystem::path& path, const std::string& name, std::string_view type) {
  VdbReader in(path);
  GridWalk walk(in, type);
  walk.file(name);
  if (const std::string fault = walk.fault(); !fault.empty())
    return fail({.code = Error::Code::kUnreadable,
                 .file = path.string(),
                 .place = "grid " + name,
                 .found = fault,
                 .expected = "an OpenVDB file written by Kerf",
                 .hint = "bake the case again"});
  return {};
}

}  // namespace kerf::internal
