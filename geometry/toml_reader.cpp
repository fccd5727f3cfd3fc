#include "geometry/toml_reader.h"

#include <fmt/format.h>

#include <fstream>
#include <sstream>

namespace kerf {

std::string TomlTable::place(const std::string& key, const toml::node* node) const {
  const std::string full = name_.empty() ? key : name_ + "." + key;
  return node && node->source().begin.line > 0 ? fmt::format("line {}, key {}", node->source().begin.line, full) : "key " + full;
}

std::vector<std::string> TomlTable::strings(const std::string& key) {
  used_.insert(key);
  std::vector<std::string> out;
  const toml::node* node = table_.get(key);
  const toml::array* array = node ? node->as_array() : nullptr;
  if (!array) {
    keep({Error::Code::kBadFormat, file_.string(), place(key, node ? node : &table_), "missing", "a list of strings", ""});
    return out;
  }
  for (const toml::node& item : *array) {
    if (const auto text = item.value<std::string>())
      out.push_back(*text);
    else
      keep({Error::Code::kBadFormat, file_.string(), place(key, &item), "not a string", "a list of strings", ""});
  }
  return out;
}

std::vector<double> TomlTable::numbers(const std::string& key, std::size_t count) {
  used_.insert(key);
  std::vector<double> out;
  const toml::node* node = table_.get(key);
  if (const toml::array* array = node ? node->as_array() : nullptr)
    for (const toml::node& item : *array)
      if (const auto value = item.value<double>()) out.push_back(*value);
  if (out.size() != count) {
    keep({Error::Code::kBadFormat, file_.string(), place(key, node ? node : &table_), "missing or of another form",
          fmt::format("a list of {} numbers", count), ""});
    out.assign(count, 0);
  }
  return out;
}

const toml::array* TomlTable::tables(const std::string& key) {
  used_.insert(key);
  const toml::node* node = table_.get(key);
  const toml::array* array = node ? node->as_array() : nullptr;
  if (!array || !array->is_array_of_tables())
    keep({Error::Code::kBadFormat, file_.string(), place(key, node ? node : &table_), "missing", "one or more [[" + key + "]]", ""});
  return array;
}

Expected<void> TomlTable::finish() {
  if (!error_)
    for (const auto& [key, node] : table_)
      if (!used_.contains(std::string(key.str()))) {
        std::string known;
        for (const std::string& name : used_) known += (known.empty() ? "" : ", ") + name;
        keep({Error::Code::kBadFormat, file_.string(), place(std::string(key.str()), &node), "unknown key", "one of " + known, ""});
        break;
      }
  if (error_) return fail(*error_);
  return {};
}

Expected<toml::table> parseToml(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in)
    return fail({std::filesystem::exists(file) ? Error::Code::kUnreadable : Error::Code::kNotFound, file.string(), "",
                 std::filesystem::exists(file) ? "can not be read" : "no such file", "a TOML file", ""});
  std::stringstream text;
  text << in.rdbuf();
  try {
    return toml::parse(text.str(), file.string());
  } catch (const toml::parse_error& e) {
    return fail({Error::Code::kBadFormat, file.string(), fmt::format("line {}, column {}", e.source().begin.line, e.source().begin.column),
                 std::string(e.description()), "TOML", ""});
  }
}

}  // namespace kerf
