// Names of the numbers in a grid of materials: text on the grid, "material_11" = "composite".
#pragma once

#include <openvdb/openvdb.h>

#include <charconv>
#include <cstdint>
#include <map>
#include <string>

namespace kerf::internal {

inline constexpr const char* kMaterialKey = "material_";

inline void writeMaterialNames(const std::map<std::uint8_t, std::string>& names, openvdb::MetaMap& grid) {
  for (const auto& [number, id] : names)
    grid.insertMeta(kMaterialKey + std::to_string(number), openvdb::StringMetadata(id));
}

/// Skips other entries, and texts too long for an id.
inline std::map<std::uint8_t, std::string> materialNamesOf(const openvdb::MetaMap& grid) {
  std::map<std::uint8_t, std::string> out;
  const std::string key = kMaterialKey;
  constexpr std::size_t kMostBytes = 100;
  for (auto entry = grid.beginMeta(); entry != grid.endMeta(); ++entry) {
    const auto text = openvdb::DynamicPtrCast<openvdb::StringMetadata>(entry->second);
    if (!text || !entry->first.starts_with(key) || text->value().size() > kMostBytes) continue;
    std::uint8_t number = 0;
    const char* const end = entry->first.data() + entry->first.size();
    const auto [last, failed] = std::from_chars(entry->first.data() + key.size(), end, number);
    if (failed == std::errc{} && last == end && number > 0) out[number] = text->value();
  }
  return out;
}

}  // namespace kerf::internal
