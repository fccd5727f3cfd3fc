#include "geometry/catalogue/tool_catalogue.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "geometry/base/atomic_file.h"
#include "geometry/base/text.h"
#include "geometry/catalogue/csv.h"
#include "geometry/tool/head_shape.h"
#include "geometry/tool/tool_doubt.h"
#include "geometry/tool/tool_file.h"
#include "geometry/tool/tool_template.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using Refused = CatalogueImport::Refused;

enum class CellKind { kText, kNumber, kWords, kPoints };
struct Column {
  std::string key;
  CellKind kind = CellKind::kText;
  bool is_drive = false;
};

// The keys of a bur file in the order in which a file states them.
const std::vector<Column>& columns() {
  static const std::vector<Column> kColumns = [] {
    std::vector<Column> out;
    for (const char* key : {"id", "name", "description", "shape"}) out.push_back({key});
    for (const HeadKey& key : headKeys()) out.push_back({key.name, CellKind::kNumber});
    out.push_back({"profile", CellKind::kPoints});
    out.push_back({"cuts", CellKind::kWords});
    for (const char* key : {"end_length", "neck_diameter", "neck_length", "shank_diameter", "shank_length"})
      out.push_back({key, CellKind::kNumber});
    out.push_back({"iso6360"});
    out.push_back({"handpiece", CellKind::kText, true});
    for (const char* key : {"speed_rpm", "stall_torque_Nmm", "time_constant_s", "energy_factor", "drag_factor"})
      out.push_back({key, CellKind::kNumber, true});
    return out;
  }();
  return kColumns;
}

struct Alias {
  const char *word, *key;
};
constexpr Alias kAliases[] = {{"diameter", "head_diameter"},
                              {"length", "head_length"},
                              {"working_length", "head_length"},
                              {"form", "shape"},
                              {"iso", "iso6360"},
                              {"iso_6360", "iso6360"},
                              {"stall_torque_nmm", "stall_torque_Nmm"}};

// "Head diameter (mm)" as "head_diameter".
std::string keyOf(std::string title) {
  title = title.substr(0, title.find_first_of("([,"));
  std::string out;
  for (const char c : title) {
    const auto letter = static_cast<unsigned char>(c);
    if (letter >= 128 || std::isalnum(letter))
      out += static_cast<char>(std::tolower(letter));
    else if (!out.empty() && out.back() != '_')
      out += '_';
  }
  while (!out.empty() && out.back() == '_') out.pop_back();
  for (const Alias& alias : kAliases)
    if (out == alias.word) return alias.key;
  return out;
}

// The unit in a title, "mm" of "Length (mm)"; empty without one.
std::string unitOf(const std::string& title) {
  std::string out;
  for (std::size_t n = std::min(title.find_first_of("([,"), title.size()); n < title.size(); ++n)
    if (std::string_view("()[], ").find(title[n]) == std::string_view::npos)
      out += static_cast<char>(std::tolower(static_cast<unsigned char>(title[n])));
  return out;
}

bool isUnitOf(const Column& column, const std::string& unit) {
  if (unit.empty() || column.kind != CellKind::kNumber) return true;
  if (column.key == "speed_rpm") return unit == "rpm" || unit == "1/min";
  if (column.key == "stall_torque_Nmm") return unit == "nmm";
  if (column.key == "time_constant_s") return unit == "s";
  if (column.is_drive) return false;
  return unit == "mm" || (column.key.ends_with("angle") && (unit == "deg" || unit == "\u00b0"));
}

// The meaning of the columns of a file.
struct Header {
  std::vector<const Column*> columns;  // null: a remark
  std::vector<std::string> titles;
  bool has(const char* key) const {
    return std::any_of(columns.begin(), columns.end(), [&](const Column* c) { return c && c->key == key; });
  }
};

Expected<Header> readHeader(const CsvTable& table, const fs::path& csv) {
  std::vector<std::string> keys;
  for (const Column& column : columns()) keys.push_back(column.key);
  const auto refuse = [&](std::string found, std::string expected, std::string hint) {
    return fail({.code = Error::Code::kBadFormat,
                 .file = csv.string(),
                 .place = table.rows.empty() ? "" : fmt::format("row {}", table.rows[0].number),
                 .found = std::move(found),
                 .expected = std::move(expected),
                 .hint = std::move(hint)});
  };
  const std::string expected = fmt::format("a row that names the columns: {}", fmt::join(keys, ", "));
  if (table.rows.empty()) return refuse("an empty table", expected, "");

  Header out;
  out.titles = table.rows[0].cells;
  for (const std::string& title : out.titles) {
    const std::string key = keyOf(title);
    const auto known = std::find(keys.begin(), keys.end(), key);
    if (known == keys.end()) {
      out.columns.push_back(nullptr);
      continue;
    }
    const Column* column = &columns()[static_cast<std::size_t>(known - keys.begin())];
    if (std::find(out.columns.begin(), out.columns.end(), column) != out.columns.end())
      return refuse("two columns for " + key, "one", "another title for \"" + title + "\"");
    if (!isUnitOf(*column, unitOf(title)))
      return refuse("\"" + title + "\"", key + " in mm, drives in rpm, Nmm and s",
                    "convert the column; a title without brackets says that it has this unit");
    out.columns.push_back(column);
  }
  if (!out.has("shape") && !out.has("iso6360"))
    return refuse("no column shape or iso6360", expected, "a header in the first row");
  return out;
}

// The head shape of an ISO 6360 code; empty if unknown.
std::string headShapeOf(const Iso6360& code) {
  constexpr std::pair<const char*, const char*> kNames[] = {
      {"cylinder, flat", "cylinder"},  {"cylinder, round", "cylinder_round"}, {"taper, flat", "taper_flat"},
      {"taper, round", "taper_round"}, {"inverted cone", "inverted_cone"},    {"round wheel", "wheel"},
      {"torpedo, tapered", "torpedo"}};
  std::string name = code.shapeName();
  for (const auto& [meaning, shape] : kNames)
    if (name == meaning) name = shape;
  return findHeadShape(name) ? name : "";
}

// A basic string of TOML.
std::string tomlString(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < 32 || c == 127)
      out += fmt::format("\\u{:04x}", static_cast<unsigned char>(c));
    else
      out += c;
  }
  return out + '"';
}

// For a comment: on one line.
std::string oneLine(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 32 || c == 127) c = ' ';
  return text;
}

tl::unexpected<Refused> refused(const Column& column, const std::string& found, std::string expected,
                                std::string hint = "") {
  return tl::unexpected<Refused>({.column = column.key,
                                  .found = "\"" + found.substr(0, 60) + (found.size() > 60 ? "...\"" : "\""),
                                  .expected = std::move(expected),
                                  .hint = std::move(hint)});
}

// 300,000 or 380.000: three digits behind each mark.
bool hasThousands(std::string_view number) {
  std::size_t digits = 0, groups = 0;
  for (const char c : number) {
    if (c != '.' && c != ',') {
      ++digits;
      continue;
    }
    if (groups == 0 ? digits == 0 || digits > 3 : digits != 3) return false;
    ++groups;
    digits = 0;
  }
  return groups > 0 && digits == 3;
}

// A cell as a value of TOML. @param comma  the file writes 1,6 for 1.6.
tl::expected<std::string, Refused> valueOf(const Column& column, const std::string& cell, bool comma) {
  if (column.kind == CellKind::kText) return tomlString(cell);
  if (column.kind == CellKind::kPoints) {
    if (cell.find_first_not_of("[]+-.,eE0123456789 ") == cell.npos) return cell;
    return refused(column, cell, "[[height, diameter], ...]");
  }
  if (column.kind == CellKind::kWords) {
    std::string out;
    for (std::size_t at = 0; at < cell.size();) {
      const std::size_t end = std::min(cell.find_first_of(" +,&", at), cell.size());
      const std::string word = cell.substr(at, end - at);
      if (!word.empty() && word != "side" && word != "end") return refused(column, cell, "side, end, or both");
      if (!word.empty()) out += fmt::format("{}\"{}\"", out.empty() ? "" : ", ", word);
      at = end + 1;
    }
    return "[" + out + "]";
  }
  if (column.is_drive && hasThousands(cell))
    return refused(column, cell, "a number without marks for thousands", "300000 in place of 300,000 or 300.000");
  std::string number = cell;
  if (comma && number.find('.') != number.npos)
    return refused(column, cell, "a decimal comma, as in the other cells of this file", "no point, none for thousands");
  std::replace(number.begin(), number.end(), ',', comma ? '.' : ',');
  std::size_t at = number.find_first_of("0123456789");
  const bool is_plain = at != number.npos && number.find_first_not_of("0123456789.") == number.npos &&
                        std::count(number.begin(), number.end(), '.') <= 1;
  if (!is_plain) return refused(column, cell, "a number", "digits only, without a unit");
  if (number.front() == '.') number.insert(0, "0");
  if (number.back() == '.') number.pop_back();
  at = std::min(number.find_first_not_of('0'), number.size() - 1);  // 016 is no number of TOML
  if (number[at] == '.') --at;
  return number.substr(at);
}

// A row on its way to a file: values of TOML by key.
struct Draft {
  std::size_t row = 0;
  std::string id, name;
  std::map<std::string, std::string> values;
  std::string comments;

  void fill(const char* key, const std::string& value) { values.try_emplace(key, value); }
  std::string toml() const {
    std::string out = comments + "format = \"kerf-tool\"\nversion = 1\n", drive;
    for (const Column& column : columns()) {
      if (const auto value = values.find(column.key); value != values.end())
        (column.is_drive ? drive : out) += fmt::format("{} = {}\n", column.key, value->second);
      if (column.key == "description") out += "kind = \"bur\"\n";
    }
    return drive.empty() ? out : out + "\n[drive]\n" + drive;
  }
};

tl::expected<Draft, Refused> draftOf(const Header& header, const CsvRow& row, const fs::path& csv, bool comma) {
  Draft out{.row = row.number, .id = "", .name = "", .values = {}, .comments = {}};
  out.comments =
      oneLine(fmt::format("# From {}, row {}; lengths in mm.", printable(csv.filename().string()), row.number)) + "\n";
  std::string iso;
  for (std::size_t n = 0; n < row.cells.size(); ++n) {
    const std::string& cell = row.cells[n];
    if (cell.empty()) continue;
    if (n >= header.columns.size())
      return tl::unexpected<Refused>({.found = fmt::format("{} cells", row.cells.size()),
                                      .expected = fmt::format("{}, as in the first row", header.columns.size()),
                                      .hint = "quotes around a cell that holds a separator"});
    const Column* column = header.columns[n];
    if (!column) {
      out.comments += oneLine(fmt::format("# {}: {}", header.titles[n], cell)) + "\n";
      continue;
    }
    if (column->key == "iso6360") {
      std::copy_if(cell.begin(), cell.end(), std::back_inserter(iso), [](char c) { return c != ' ' && c != '.'; });
      if (iso.find_first_of("eE+") != iso.npos)
        return refused(*column, cell, "15 digits", "the format \"text\" for this column of the spreadsheet");
      out.values["iso6360"] = tomlString(iso);
      continue;
    }
    if (column->key == "id") out.id = cell;
    if (column->key == "name") out.name = cell;
    const auto value = valueOf(*column, cell, comma);
    if (!value) return tl::unexpected<Refused>(value.error());
    out.values[column->key] = *value;
  }

  if (const auto code = parseIso6360(iso)) {
    if (const std::string shape = headShapeOf(*code); !shape.empty()) out.fill("shape", tomlString(shape));
    out.fill("head_diameter", fmt::format("{:.1f}", code->diameterMm()));
    if (out.name.empty() && out.id.empty())
      out.name =
          fmt::format("{} {:03}", code->shapeName().empty() ? "Shape " + code->shape : code->shapeName(), code->tenths);
  }
  if (out.name.empty()) out.name = out.id;
  if (out.id.empty()) out.id = toolIdOf(out.name);
  if (out.id.empty())
    return tl::unexpected<Refused>(
        {.column = "id", .found = "missing", .expected = "an id, a name or an ISO 6360 code"});
  out.values["id"] = tomlString(out.id);
  out.values["name"] = tomlString(out.name);
  return out;
}

// The shank by the ISO 6360 code, if the row has none: its diameter, and the rest of the whole length.
void fillShank(Draft& draft, const Tool& tool) {
  const auto shank = tool.iso ? tool.iso->shankKnown() : std::nullopt;
  if (!shank || tool.shank_diameter_mm > 0) return;
  const auto neck = draft.values.find("neck_length");
  const double left =
      shank->length_mm - tool.head_length_mm - (neck == draft.values.end() ? 0 : std::stod(neck->second));
  constexpr double kShortest = 0.05;
  if (left < kShortest) return;
  draft.fill("shank_diameter", fmt::format("{}", shank->diameter_mm));
  draft.fill("shank_length", fmt::format("{:.4g}", left));
}

// "key head_diameter" of "line 7, key head_diameter".
std::string columnOf(const std::string& place) {
  const std::size_t at = place.rfind("key ");
  return at == place.npos ? "" : place.substr(at + 4);
}

Refused refusedBy(const Error& error) {
  return {.column = columnOf(error.place), .found = error.found, .expected = error.expected, .hint = error.hint};
}

tl::expected<CatalogueImport::Written, Refused> write(Draft draft, const fs::path& folder, bool overwrite) {
  const fs::path file = folder / (draft.id + ".toml");
  auto tool = readToolText(draft.toml(), file);
  if (!tool) return tl::unexpected<Refused>(refusedBy(tool.error()));
  fillShank(draft, *tool);

  std::error_code ignored;
  if (fs::exists(file, ignored) && !overwrite)
    return tl::unexpected<Refused>({.found = file.string() + " exists already",
                                    .expected = "a new file",
                                    .hint = "another id or folder, or --overwrite to replace it"});
  const auto written = [&]() -> Expected<Tool> {
    const std::string text = draft.toml();
    KERF_CHECK(readToolText(text, file));
    KERF_TRY(toml, AtomicFile::create(file));
    toml.stream() << text;
    KERF_CHECK(toml.commit());
    return readTool(file);
  }();
  if (!written) return tl::unexpected<Refused>(refusedBy(written.error()));
  return CatalogueImport::Written{.row = draft.row, .id = draft.id, .file = file, .doubt = doubtAbout(*written)};
}

}  // namespace

Expected<CatalogueImport> importCatalogue(const fs::path& csv, const fs::path& folder, bool overwrite,
                                          const Progress& progress) {
  KERF_TRY(table, readCsv(csv));
  KERF_TRY(header, readHeader(table, csv));
  CatalogueImport out;
  for (std::size_t n = 0; n < header.columns.size(); ++n)
    if (!header.columns[n] && !header.titles[n].empty()) out.remarks.push_back(header.titles[n]);

  const std::span rows = std::span(table.rows).subspan(1);
  if (rows.empty())
    return fail({.code = Error::Code::kEmpty,
                 .file = csv.string(),
                 .found = "no row below the header",
                 .expected = "one row a bur"});
  const bool comma = table.separator != ',' && std::any_of(rows.begin(), rows.end(), [&](const CsvRow& row) {
                       for (std::size_t n = 0; n < std::min(row.cells.size(), header.columns.size()); ++n)
                         if (const Column* c = header.columns[n];
                             c && c->kind == CellKind::kNumber && row.cells[n].find(',') != std::string::npos)
                           return true;
                       return false;
                     });

  std::error_code failed;
  fs::create_directories(folder, failed);
  if (!fs::is_directory(folder, failed))
    return fail({.code = Error::Code::kWriteFailed,
                 .file = folder.string(),
                 .found = "no folder",
                 .expected = "a folder that can be made or written"});

  std::map<std::string, std::size_t> rows_by_id;
  for (std::size_t n = 0; n < rows.size(); ++n) {
    if (!report(progress, static_cast<double>(n) / static_cast<double>(rows.size()), "importing")) return cancelled();
    auto draft = draftOf(header, rows[n], csv, comma);
    const auto refuse = [&](Refused refusal) {
      refusal.row = rows[n].number;
      refusal.name = draft ? draft->name : "";
      for (std::size_t k = 0; !draft && k < std::min(rows[n].cells.size(), header.columns.size()); ++k)
        if (const Column* c = header.columns[k]; c && (c->key == "name" || (c->key == "id" && refusal.name.empty())))
          if (!rows[n].cells[k].empty()) refusal.name = rows[n].cells[k];
      out.refused.push_back(std::move(refusal));
    };
    if (!draft) {
      refuse(draft.error());
    } else if (const auto other = rows_by_id.find(draft->id); other != rows_by_id.end()) {
      refuse({.column = "id",
              .found = "\"" + draft->id + "\"",
              .expected = fmt::format("an id of its own: row {} has this one", other->second)});
    } else if (auto written = write(*draft, folder, overwrite)) {
      rows_by_id[draft->id] = draft->row;
      out.written.push_back(std::move(*written));
    } else {
      refuse(written.error());
    }
  }
  return out;
}

}  // namespace kerf
