#include "ui/app/tool/tool_search.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <sstream>
#include <string>

namespace kerf {
namespace {

std::string lowerCase(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

std::string allWordsOf(const Tool& tool) {
  const double mm = tool.head_diameter_mm;
  const std::string size = mm > 0 ? fmt::format("{:g} {:g}mm {:03.0f}", mm, mm, 10 * mm) : "";
  const char* const also = tool.kind == ToolKind::kBlade ? "saw" : "";
  return lowerCase(fmt::format("{} {} {} {} {} {} {} {}", tool.id, tool.name, tool.description, tool.shape,
                               kindName(tool.kind), also, tool.iso6360, size));
}

// "1.40" finds 1.4 mm, and so does "1,4".
bool isDiameter(const std::string& word, const Tool& tool) {
  double mm = 0;
  const auto [end, failed] = std::from_chars(word.data(), word.data() + word.size(), mm);
  const std::string_view rest(end, static_cast<std::size_t>(word.data() + word.size() - end));
  return failed == std::errc{} && (rest.empty() || rest == "mm") && std::abs(mm - tool.head_diameter_mm) < 1e-6;
}

}  // namespace

bool matchesSearch(const Tool& tool, std::string_view search) {
  const std::string all = allWordsOf(tool);
  std::istringstream words{lowerCase(std::string(search))};
  for (std::string word; words >> word;) {
    if (all.find(word) != std::string::npos) continue;
    std::replace(word.begin(), word.end(), ',', '.');
    if (all.find(word) == std::string::npos && !isDiameter(word, tool)) return false;
  }
  return true;
}

}  // namespace kerf
