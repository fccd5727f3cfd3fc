#include "preprocess/volume/label_names.h"

#include <charconv>
#include <fstream>
#include <optional>

namespace kerf {
namespace {

constexpr std::size_t kMostNamesHeader = 1 << 20;  // bytes
constexpr std::size_t kLongestName = 200;          // bytes

std::optional<int> numberOf(const std::string& text) {
  int out = 0;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), out);
  if (failed != std::errc{} || end != text.data() + text.size()) return {};
  return out;
}

// "Segment12_Name:=Mandible" of the key "Name": 12 and "Mandible".
struct Entry {
  int segment = 0;
  std::string key, value;
};
std::optional<Entry> entryOf(const std::string& line) {
  constexpr std::string_view kSegment = "Segment";
  const std::size_t sign = line.find(":="), bar = line.find('_');
  if (!line.starts_with(kSegment) || sign == line.npos || bar == line.npos || bar > sign) return {};
  const auto number = numberOf(line.substr(kSegment.size(), bar - kSegment.size()));
  if (!number) return {};
  return Entry{*number, line.substr(bar + 1, sign - bar - 1), line.substr(sign + 2)};
}

}  // namespace

std::map<std::uint16_t, std::string> labelNames(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::string line;
  if (path.extension() != ".nrrd" || !std::getline(in, line) || !line.starts_with("NRRD")) return {};

  std::map<int, std::string> names;
  std::map<int, int> values;
  std::size_t read = line.size();
  while (read < kMostNamesHeader && std::getline(in, line)) {
    read += line.size() + 1;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty()) break;  // the values follow
    const auto entry = entryOf(line);
    if (!entry) continue;
    if (entry->key == "Name") names[entry->segment] = entry->value.substr(0, kLongestName);
    if (entry->key == "LabelValue") values[entry->segment] = numberOf(entry->value).value_or(0);
  }

  std::map<std::uint16_t, std::string> out;
  for (const auto& [segment, name] : names) {
    const auto value = values.find(segment);
    if (value == values.end() || value->second < 1 || value->second > 65535 || name.empty()) continue;
    // Segments of different layers may share a number: the first keeps it.
    out.emplace(static_cast<std::uint16_t>(value->second), name);
  }
  return out;
}

}  // namespace kerf
