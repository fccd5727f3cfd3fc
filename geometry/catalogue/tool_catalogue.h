// Burs of a catalogue: a table with a row a bur becomes one tool file each.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"

namespace kerf {

struct CatalogueImport {
  struct Written {
    std::size_t row = 0;
    std::string id;
    std::filesystem::path file;
    std::string doubt;  ///< doubtAbout() the tool
  };
  struct Refused {
    std::size_t row = 0;
    std::string name{};    ///< as in the row, or its id
    std::string column{};  ///< empty: the whole row
    std::string found{}, expected{}, hint{};
  };
  std::vector<Written> written;
  std::vector<Refused> refused;
  std::vector<std::string> remarks;  ///< columns that are no keys of a bur: they become comments in the files
};

/// Writes one TOML file for each row of a CSV file (csv.h). The first row names the columns: keys of a bur file
/// (assets/tools/README.md), without regard to case, spaces for underscores. Lengths are mm. A decimal comma is read if
/// the separator is none. Missing cells:
///   id     made from the name;  name  from the id, else from the ISO 6360 code
///   shape, head_diameter, shank_diameter, shank_length  from the ISO 6360 code, as far as it says them
/// Every file is read as a tool before and after it is written; a row that fails leaves no file. Cancelling keeps the
/// files of the rows before.
/// @param folder  made if missing.   @param overwrite  replace files of the same name.
/// Errors: those of readCsv(); kBadFormat: no header, a column twice; kEmpty: no row; kWriteFailed; kCancelled.
/// @cost  about a millisecond a row.
Expected<CatalogueImport> importCatalogue(const std::filesystem::path& csv, const std::filesystem::path& folder,
                                          bool overwrite, const Progress& progress = {});

}  // namespace kerf
