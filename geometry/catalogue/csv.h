// Tables of spreadsheet programs: RFC 4180, with other separators.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "geometry/base/error.h"

namespace kerf {

struct CsvRow {
  std::size_t number = 0;  ///< as spreadsheets count: the first row of the file is 1
  std::vector<std::string> cells;
};
struct CsvTable {
  char separator = ',';      ///< of the first row: the most frequent of , ; and tab
  std::vector<CsvRow> rows;  ///< without blank rows
};

/// UTF-8 with or without BOM, LF or CRLF; a cell in quotes may hold separators, line feeds and doubled quotes. Cells
/// lose spaces at both ends.
/// Errors kBadFormat with the row: an unclosed quote, bytes that are no UTF-8; kUnreadable, kNotFound.
Expected<CsvTable> readCsv(const std::filesystem::path& file);
/// @param file  for errors.
Expected<CsvTable> parseCsv(std::string_view text, const std::filesystem::path& file);

}  // namespace kerf
