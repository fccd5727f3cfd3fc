#include "geometry/catalogue/csv.h"

#include <fmt/format.h>

#include <algorithm>

#include "geometry/base/text.h"

namespace kerf {
namespace {

constexpr std::string_view kBom = "\xef\xbb\xbf";

char separatorOf(std::string_view text) {
  std::size_t commas = 0, semicolons = 0, tabs = 0;
  bool is_quoted = false;
  for (const char c : text) {
    if (c == '"') is_quoted = !is_quoted;
    if (is_quoted) continue;
    if (c == '\n') break;
    commas += c == ',';
    semicolons += c == ';';
    tabs += c == '\t';
  }
  return tabs > std::max(commas, semicolons) ? '\t' : semicolons > commas ? ';' : ',';
}

std::string trimmed(const std::string& text) {
  constexpr const char* kSpaces = " \t\r\n";
  const std::size_t begin = text.find_first_not_of(kSpaces);
  return begin == text.npos ? "" : text.substr(begin, text.find_last_not_of(kSpaces) + 1 - begin);
}

}  // namespace

Expected<CsvTable> parseCsv(std::string_view text, const std::filesystem::path& file) {
  if (text.starts_with(kBom)) text.remove_prefix(kBom.size());
  CsvTable out{.separator = separatorOf(text), .rows = {}};
  std::size_t number = 1;
  const auto refuse = [&](std::string found, std::string expected, std::string hint) {
    return fail({.code = Error::Code::kBadFormat,
                 .file = file.string(),
                 .place = fmt::format("row {}", number),
                 .found = std::move(found),
                 .expected = std::move(expected),
                 .hint = std::move(hint)});
  };

  std::vector<std::string> cells(1);
  bool is_quoted = false, was_quoted = false;
  const auto endRow = [&] {
    for (std::string& cell : cells) cell = trimmed(cell);
    if (std::any_of(cells.begin(), cells.end(), [](const std::string& cell) { return !cell.empty(); }))
      out.rows.push_back({number, cells});
    cells.assign(1, "");
    was_quoted = false;
    ++number;
  };
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = utf8Length(text, at);
    const char c = text[at];
    if (length == 0 || c == '\0')
      return refuse(fmt::format("the byte 0x{:02x}", static_cast<unsigned char>(c)), "text in UTF-8",
                    "save the table as \"CSV UTF-8\"");
    if (is_quoted) {
      if (c == '"' && at + 1 < text.size() && text[at + 1] == '"') {
        cells.back() += c;
        ++at;
      } else if (c == '"') {
        is_quoted = false;
      } else {
        cells.back().append(text, at, length);
      }
    } else if (c == '"' && !was_quoted && cells.back().find_first_not_of(" \t\r\n") == std::string::npos) {
      is_quoted = was_quoted = true;
      cells.back().clear();
    } else if (c == out.separator) {
      cells.emplace_back();
      was_quoted = false;
    } else if (c == '\n') {
      endRow();
    } else {
      cells.back().append(text, at, length);
    }
    at += length;
  }
  if (is_quoted) return refuse("a quote that is not closed", "a \" at the end of the cell", "two quotes for one: \"\"");
  endRow();
  return out;
}

Expected<CsvTable> readCsv(const std::filesystem::path& file) {
  constexpr std::size_t kMostBytes = std::size_t{16} << 20;
  KERF_TRY(text, readSmallFile(file, kMostBytes));
  return parseCsv(text, file);
}

}  // namespace kerf
