// Grid headers of a .vdb file, read without OpenVDB: some damaged files crash that library, and hashing half a gigabyte
// first takes longer than the rest of `kerf info`.
//
// Layout (openvdb/io/Archive.cc, GridDescriptor.cc, math/Transform.cc; version 222 and later, little endian):
//
//   file   int64 magic, u32 version, u32 major, u32 minor, u8 has_offsets, 36 characters, metadata, i32 grids
//   grid   string name, string type, string parent, i64 begin, i64 block, i64 end; the next one stands at `end`
//   begin  u32 compression, metadata, string map, 3 doubles scale, 3 doubles voxel size, ...
//   metadata  i32 entries; of each string name, string type, i32 size, its bytes       string  i32 size, its bytes
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "geometry/field/vdb_bytes.h"
#include "geometry/field/vdb_io.h"

namespace kerf {
namespace {

using internal::VdbReader;

// A grid, from its header.
std::optional<VdbGridInfo> readGrid(VdbReader& in, std::string name, std::string type) {
  constexpr std::string_view kHalf = "_HalfFloat";  // how the values are stored is not part of the type
  if (type.ends_with(kHalf)) type.resize(type.size() - kHalf.size());
  VdbGridInfo out{std::move(name), std::move(type)};

  in.number<std::uint32_t>();
  in.metadata([&](const std::string& key, const std::string&, std::int32_t size) {
    if (key == "file_voxel_count" && size == sizeof out.active_voxels) out.active_voxels = in.number<std::uint64_t>();
  });

  const std::string map = in.text();
  for (int axis = 0; axis < 3; ++axis) in.number<double>();
  out.voxel = in.number<double>();
  if (!in.isGood() || !map.starts_with("UniformScale") || !std::isfinite(out.voxel)) return std::nullopt;
  return out;
}

}  // namespace

Expected<std::vector<VdbGridInfo>> inspectVdb(const std::filesystem::path& path) {
  const auto refuse = [&path](const std::string& place, const std::string& found) {
    return fail({.code = Error::Code::kUnreadable,
                 .file = path.string(),
                 .place = place,
                 .found = found,
                 .expected = "an OpenVDB file written by Kerf",
                 .hint = "bake the case again"});
  };

  std::error_code ignored;
  if (std::filesystem::exists(path, ignored) && !std::filesystem::is_regular_file(path, ignored))
    return refuse("file", "a folder, a pipe or a device");
  VdbReader in(path);
  if (in.number<std::int64_t>() != internal::kVdbMagic) return refuse("header", "no OpenVDB file, or none at all");
  const auto version = in.number<std::uint32_t>();
  if (version < internal::kOldestVdb || version > internal::kNewestVdb)
    return refuse("header", fmt::format("version {}", version));
  in.number<std::uint64_t>();  // of the library
  if (in.number<std::uint8_t>() == 0) return refuse("header", "no index of its grids");
  for (int n = 0; n < 36; ++n) in.number<char>();  // identifier
  in.metadata([](const std::string&, const std::string&, std::int32_t) {});

  const auto count = in.number<std::int32_t>();
  if (!in.isGood() || count < 0 || count > internal::kMostVdbEntries) return refuse("header", "damaged");
  std::vector<VdbGridInfo> grids;
  for (std::int32_t n = 0; n < count; ++n) {
    std::string name = in.text(), type = in.text();
    in.text();  // parent
    const auto begin = in.number<std::int64_t>();
    in.number<std::int64_t>();
    const auto end = in.number<std::int64_t>();

    in.goTo(begin);
    auto grid = readGrid(in, std::move(name), std::move(type));
    if (!grid) return refuse(fmt::format("grid {} of {}", n + 1, count), "damaged, or not a plain uniform scale");
    grids.push_back(std::move(*grid));
    in.goTo(end);
    if (!in.isGood()) return refuse(fmt::format("grid {} of {}", n + 1, count), "cut short");
  }
  std::sort(grids.begin(), grids.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return grids;
}

}  // namespace kerf
