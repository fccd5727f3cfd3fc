#include "bench/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

namespace kerf::cli {
namespace {

std::string keyOf(Sense sense) {
  std::string key(wordsOf(sense));
  std::replace(key.begin(), key.end(), ' ', '_');
  return key;
}

// A number, and the missed goal, if any.
struct Cell {
  std::string column, row;
  double value;
  bool is_missed;
};

std::vector<Cell> cellsOf(const Result& r, const Verdict* verdict) {
  std::vector<Cell> cells;
  for (std::size_t n = 0; n < r.measured.size(); ++n) {
    const Measured& m = r.measured[n];
    const Goal* const goal = verdict ? verdict->goal_of[n] : nullptr;
    const std::size_t at = m.name.find(": ");
    cells.push_back({m.name.substr(0, at), m.name.substr(at + 2) + (m.unit.empty() ? "" : ", " + m.unit), m.value,
                     goal && !goal->isMetBy(m.value)});
  }
  return cells;
}

// Columns and rows in order of first appearance. Missed goals are marked.
void printTable(const Result& r, const Verdict* verdict) {
  const std::vector<Cell> cells = cellsOf(r, verdict);
  std::vector<std::string> columns, rows;
  const auto place = [](std::vector<std::string>& in, const std::string& what) {
    if (std::find(in.begin(), in.end(), what) == in.end()) in.push_back(what);
  };
  for (const Cell& cell : cells) {
    place(columns, cell.column);
    place(rows, cell.row);
  }

  fmt::print("{:<44}", "");
  for (const std::string& column : columns) fmt::print(" {:>18}", column);
  fmt::print("\n");
  bool is_missed = false;
  for (const std::string& row : rows) {
    fmt::print("{:<44}", row);
    for (const std::string& column : columns)
      for (const Cell& cell : cells) {
        if (cell.column != column || cell.row != row) continue;
        fmt::print(" {:>17.4g}{}", cell.value, cell.is_missed ? "!" : " ");
        is_missed |= cell.is_missed;
      }
    fmt::print("\n");
  }
  if (is_missed) fmt::print("!: more than the goal\n");
}

void printNumbers(const Result& r, const Verdict* verdict) {
  for (std::size_t n = 0; n < r.measured.size(); ++n) {
    const Measured& m = r.measured[n];
    fmt::print("           {:<44} {:10.4g} {}", m.name, m.value, m.unit);
    if (const Goal* const goal = verdict ? verdict->goal_of[n] : nullptr)
      fmt::print("{}({}: {})", m.unit.empty() ? "" : " ", goal->requirement(), goal->verdictOn(m.value));
    fmt::print("\n");
  }
}

}  // namespace

void printResult(const Result& r, const Verdict* verdict) {
  const std::string_view scene = sceneOf(r.id).name;
  if (r.ms.empty())
    fmt::print("{:<10} {}\n", scene, r.what);
  else
    fmt::print("{:<10} p50 {:9.3f}  p99 {:9.3f}  max {:9.3f} ms  x{:<4} {}  {}\n", scene, percentile(r.ms, 0.5),
               percentile(r.ms, 0.99), percentile(r.ms, 1), r.ms.size(), r.state_hash, r.what);
  for (const std::string& note : r.notes) fmt::print("           {}\n", note);

  if (r.is_table)
    printTable(r, verdict);
  else
    printNumbers(r, verdict);
  if (verdict)
    for (const Goal* goal : verdict->not_measured)
      fmt::print("           {:<44} not measured ({}: MISSED)\n", goal->name, goal->requirement());

  if (r.ratio > 0) fmt::print("           {:.2f} x {}", r.ratio, r.ratio_to);
  if (!r.part.empty()) fmt::print("; {} {:.2f} x", r.part, r.part_ratio);
  if (r.peak_gb > 0) fmt::print("; {:.2f} GB at most", r.peak_gb);
  if (r.ratio > 0) fmt::print("\n");
  std::fflush(stdout);
}

nlohmann::json jsonOf(const Result& r, const Verdict* verdict) {
  nlohmann::json j{{"scene", sceneOf(r.id).name},
                   {"what", r.what},
                   {"count", r.ms.size()},
                   {"p50_ms", percentile(r.ms, 0.5)},
                   {"p99_ms", percentile(r.ms, 0.99)},
                   {"p99.9_ms", percentile(r.ms, 0.999)},
                   {"max_ms", percentile(r.ms, 1)},
                   {"state_hash", r.state_hash}};
  if (r.ratio > 0) {
    j["ratio"] = r.ratio;
    j["ratio_to"] = r.ratio_to;
  }
  if (!r.part.empty()) {
    j["part"] = r.part;
    j["part_ratio"] = r.part_ratio;
  }
  if (r.peak_gb > 0) j["peak_gb"] = r.peak_gb;
  if (!r.notes.empty()) j["notes"] = r.notes;

  for (std::size_t n = 0; n < r.measured.size(); ++n) {
    const Measured& m = r.measured[n];
    nlohmann::json number{{"value", m.value}, {"unit", m.unit}};
    if (const Goal* const goal = verdict ? verdict->goal_of[n] : nullptr) {
      number[keyOf(goal->sense)] = goal->limit;
      number["passed"] = goal->isMetBy(m.value);
    }
    j["measured"][m.name] = number;
  }
  if (verdict)
    for (const Goal* goal : verdict->not_measured) j["not_measured"].push_back(goal->name);
  return j;
}

void printScenes() {
  for (const Scene& scene : scenes()) {
    fmt::print("{:<15} {}\n", scene.name, scene.what);
    for (const Goal& goal : scene.goals)
      fmt::print("    {:<70} {}{}{}{}\n", goal.name, goal.requirement(), goal.unit.empty() ? "" : " ", goal.unit,
                 goal.weight == Weight::kAim ? " (aim)" : "");
  }
}

nlohmann::json jsonOfScenes() {
  nlohmann::json all = nlohmann::json::array();
  for (const Scene& scene : scenes()) {
    nlohmann::json goals = nlohmann::json::array();
    for (const Goal& goal : scene.goals)
      goals.push_back({{"name", goal.name},
                       {"unit", goal.unit},
                       {keyOf(goal.sense), goal.limit},
                       {"is_aim", goal.weight == Weight::kAim}});
    all.push_back({{"scene", scene.name},
                   {"what", scene.what},
                   {"goals", goals},
                   {"only_by_name", scene.when == Scene::When::kOnlyByName}});
  }
  return all;
}

}  // namespace kerf::cli
