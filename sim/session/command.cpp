#include "sim/session/command.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <tuple>
#include <utility>
#include <vector>

#include "sim/pieces/split_field.h"

namespace kerf {
namespace {

// ---- The table ------------------------------------------------------------------------------------------------------

template <class C, class T>
struct Field {
  T C::*member;
  CommandParameter parameter;
};
template <class C, class T>
Field(T C::*, CommandParameter) -> Field<C, T>;  // clang 14 deduces none for an aggregate

template <class C, class... T>
struct Row {
  using Type = C;
  std::string_view name, description;
  std::uint8_t senders = 0;
  std::tuple<Field<C, T>...> fields;
  std::array<CommandParameter, sizeof...(T)> parameters;
};

template <class C, class... T>
constexpr Row<C, T...> row(std::string_view name, std::string_view description, std::uint8_t senders,
                           Field<C, T>... fields) {
  return {name, description, senders, {fields...}, {fields.parameter...}};
}

constexpr auto kUser = static_cast<std::uint8_t>(CommandSender::kUser);
constexpr auto kSimulation = static_cast<std::uint8_t>(CommandSender::kSimulation);
constexpr CommandParameter kObject{"N", "", "number of the object, from 0"};
static_assert(PieceOptions{}.crumb_mm3 == 0.1, "the row of pieces.split names the default");

// One row for each alternative of Command, in its order.
constexpr std::tuple kRows{
    row("tool.select", "Changes to another tool of the model.", kUser,
        Field{&SelectTool::tool, {"N", "", "number of the tool, from 0"}}),
    row<Undo>("undo", "Undoes the last stroke, with the cuts made while the tool ran down.", kUser),
    row<Redo>("redo", "Redoes the last undone stroke; not during a stroke.", kUser),
    row<ClearLatch>("latch.clear", "Fades the force in again after a fault of the device.", kUser | kSimulation),
    row("add", "Makes the pedal add material to an object instead of cutting.", kUser,
        Field{&AddMaterial::material, {"M", "", "number of the material, 1 to 255"}},
        Field{&AddMaterial::object, kObject}),
    row<StopAdding>("add off", "Makes the pedal cut again.", kUser),
    row("object.move", "Sets the pose of an object in the world; undone with the stroke before it.", kUser,
        Field{&MoveObject::object, kObject},
        Field{&MoveObject::translation, {"x y z", "mm", "translation of T_world_object, shorter than 1e5"}},
        Field{&MoveObject::rotation, {"qw qx qy qz", "", "rotation of T_world_object, a unit quaternion"}}),
    row("object.hold",
        "Freezes an object: the tool feels it, but cannot cut or fill it. Until the freeze ends, no move and no undo.",
        kSimulation, Field{&FreezeObject::object, kObject}),
    row("object.release", "Ends the freeze of an object.", kSimulation, Field{&UnfreezeObject::object, kObject}),
    row("pieces.split",
        "Makes every piece of an object a separate object: the largest keeps the number, the others follow by size; "
        "ends a freeze.",
        kSimulation, Field{&SplitObject::object, kObject},
        Field{&SplitObject::crumb_mm3,
              {"V", "mm^3",
               "smaller pieces are crumbs: dropped and counted, or removed if there is only one piece; default 0.1",
               true}}),
    row("tool.place",
        "Sets the pose of the tool in the world at once, at rest, with unchanged drive speed; ends a stroke.", kUser,
        Field{&PlaceTool::translation, {"x y z", "mm", "translation of T_world_tool, shorter than 1e5"}},
        Field{&PlaceTool::rotation, {"qw qx qy qz", "", "rotation of T_world_tool, a unit quaternion"}}),
    row("object.cut",
        "Cuts an object by planes: the part above all of them and the rest become objects; one undo step. A round hole "
        "is lost from both; without planes KEEP is 1.",
        kUser, Field{&CutByPlanes::object, kObject},
        Field{&CutByPlanes::keep, {"KEEP", "", "parts that stay: 0 both, 1 above, 2 the rest"}},
        Field{
            &CutByPlanes::planes,
            {"kerf nx ny nz x y z ... [hole d l ax ay az x y z]", "mm",
             "width lost along the planes; unit normal and point of up to 5 planes; diameter, depth, axis (unit, into "
             "the material) and mouth of a round hole; in the frame of the object as loaded"}}),
    row("object.delete", "Removes pieces of an object from the scene; one undo step. The last piece stays.", kUser,
        Field{&DeleteObjects::objects, {"N ...", "", "numbers of the objects, from 0 to 63"}}),
};

constexpr std::size_t kCount = std::variant_size_v<Command>;
constexpr auto kEach = std::make_index_sequence<kCount>{};

template <std::size_t... N>
constexpr bool hasEveryCommandItsRow(std::index_sequence<N...>) {
  return (
      std::is_same_v<std::variant_alternative_t<N, Command>, typename std::tuple_element_t<N, decltype(kRows)>::Type> &&
      ...);
}
static_assert(std::tuple_size_v<decltype(kRows)> == kCount, "a row for each alternative of Command");
static_assert(hasEveryCommandItsRow(kEach), "rows in the order of Command");

template <std::size_t... N>
constexpr std::array<CommandRow, kCount> tableOf(std::index_sequence<N...>) {
  return {CommandRow{std::get<N>(kRows).name, std::get<N>(kRows).description, std::get<N>(kRows).senders,
                     std::get<N>(kRows).parameters}...};
}
constexpr std::array<CommandRow, kCount> kTable = tableOf(kEach);

constexpr bool areNamesDifferent() {
  for (std::size_t a = 0; a < kCount; ++a)
    for (std::size_t b = 0; b < a; ++b)
      if (kTable[a].name == kTable[b].name) return false;
  return true;
}
static_assert(areNamesDifferent(), "a name stands for one command");

// ---- Text -----------------------------------------------------------------------------------------------------------

using Words = std::span<const std::string_view>;

std::vector<std::string_view> wordsOf(std::string_view text) {
  std::vector<std::string_view> out;
  while (true) {
    const std::size_t begin = text.find_first_not_of(' ');
    if (begin == text.npos) return out;
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    out.push_back(text.substr(begin, end - begin));
    text.remove_prefix(end);
  }
}

// Prints and reads a parameter. take() uses up the words it read; false: the first of them is no such number.
template <class T>
requires std::is_arithmetic_v<T>
struct Text {
  static void print(std::string& to, T value) { fmt::format_to(std::back_inserter(to), " {}", value); }
  static bool take(Words& from, T& value) {
    if (from.empty()) return false;
    const std::string_view word = from.front();
    const auto [end, failed] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (failed != std::errc{} || end != word.data() + word.size()) return false;
    if constexpr (std::is_floating_point_v<T>)
      if (!std::isfinite(value)) return false;
    from = from.subspan(1);
    return true;
  }
};

template <class T>
struct OptionalText {
  static void print(std::string& to, const std::optional<T>& value) {
    if (value) Text<T>::print(to, *value);
  }
  static bool take(Words& from, std::optional<T>& value) {
    return from.empty() || Text<T>::take(from, value.emplace());
  }
};

template <class T, std::size_t N>
struct ArrayText {
  static void print(std::string& to, const std::array<T, N>& values) {
    for (const T value : values) Text<T>::print(to, value);
  }
  static bool take(Words& from, std::array<T, N>& values) {
    return std::all_of(values.begin(), values.end(), [&](T& value) { return Text<T>::take(from, value); });
  }
};

// Takes all words that are left.
struct PlanesText {
  static constexpr std::string_view kHole = " hole";
  static void print(std::string& to, const CutPlanes& planes) {
    Text<double>::print(to, planes.kerf_mm);
    for (std::size_t n = 0; n < planes.count; ++n) ArrayText<double, 6>::print(to, planes.numbers[n]);
    if (!planes.hasHole()) return;
    to += kHole;
    ArrayText<double, 8>::print(to, planes.hole_numbers);
  }
  static bool take(Words& from, CutPlanes& planes) {
    planes = {};
    if (!Text<double>::take(from, planes.kerf_mm)) return false;
    const auto isHole = [&] { return !from.empty() && from.front() == kHole.substr(1); };
    while (!isHole() && planes.count < CutPlanes::kMost && (!from.empty() || planes.count == 0))
      if (!ArrayText<double, 6>::take(from, planes.numbers[planes.count++])) return false;
    if (!isHole()) return true;
    from = from.subspan(1);
    return ArrayText<double, 8>::take(from, planes.hole_numbers);
  }
};

// Takes all words that are left.
struct ObjectsText {
  static void print(std::string& to, const ObjectSet& objects) {
    for (std::size_t n = 0; n < ObjectSet::kMost; ++n)
      if (objects.has(n)) Text<std::size_t>::print(to, n);
  }
  static bool take(Words& from, ObjectSet& objects) {
    objects = {};
    while (!from.empty()) {
      std::size_t n = 0;
      Words rest = from;
      if (!Text<std::size_t>::take(rest, n) || n >= ObjectSet::kMost) return false;
      objects.bits |= std::uint64_t{1} << n;
      from = rest;
    }
    return objects.bits != 0;
  }
};

inline PlanesText textOf(const CutPlanes&) { return {}; }
inline ObjectsText textOf(const ObjectSet&) { return {}; }
template <class T>
Text<T> textOf(const T&);
template <class T>
OptionalText<T> textOf(const std::optional<T>&);
template <class T, std::size_t N>
ArrayText<T, N> textOf(const std::array<T, N>&);

template <class C, class T>
void printField(std::string& to, const C& command, const Field<C, T>& field) {
  decltype(textOf(command.*field.member))::print(to, command.*field.member);
}
template <class C, class T>
bool takeField(Words& from, C& command, const Field<C, T>& field) {
  return decltype(textOf(command.*field.member))::take(from, command.*field.member);
}

tl::unexpected<Error> refuse(std::string_view text, const std::string& what, std::string expected) {
  return fail({.code = Error::Code::kBadValue,
               .file = "",
               .place = "command",
               .found = fmt::format("\"{}\"{}", text, what),
               .expected = std::move(expected),
               .hint = "\"kerf replay --commands\" lists all commands"});
}

// The parameters of the command in row N.
template <std::size_t N>
Expected<Command> parseRow(std::string_view text, Words rest) {
  constexpr const auto& kRow = std::get<N>(kRows);
  typename std::tuple_element_t<N, decltype(kRows)>::Type command;
  std::size_t read = 0;  // parameters
  const auto take = [&](const auto& field) {
    const bool is_good = takeField(rest, command, field);
    read += is_good;
    return is_good;
  };
  const bool is_good = std::apply([&](const auto&... field) { return (take(field) && ...); }, kRow.fields);
  if (is_good && rest.empty()) return command;

  std::string expected = kTable[N].usage();
  if (is_good) return refuse(text, fmt::format(", with \"{}\" behind its end", rest.front()), expected);
  const CommandParameter& wrong = kTable[N].parameters[read];
  expected +=
      fmt::format(", with {}: {}{}{}", wrong.name, wrong.description, wrong.unit.empty() ? "" : ", ", wrong.unit);
  return refuse(text, rest.empty() ? ", which ends too early" : fmt::format(", with \"{}\" in it", rest.front()),
                expected);
}

template <std::size_t... N>
Expected<Command> parseRow(std::size_t index, std::string_view text, Words rest, std::index_sequence<N...>) {
  constexpr std::array<Expected<Command> (*)(std::string_view, Words), kCount> kParsers = {&parseRow<N>...};
  return kParsers[index](text, rest);
}

// ---- The reference --------------------------------------------------------------------------------------------------

std::string senderNames(const CommandRow& row) {
  std::string out = row.maySend(CommandSender::kUser) ? "user" : "";
  if (row.maySend(CommandSender::kSimulation)) out += out.empty() ? "simulation" : ", simulation";
  return out;
}

std::string parameterList(const CommandRow& row) {
  std::string out;
  for (const CommandParameter& p : row.parameters)
    out += fmt::format("{}`{}`{}{}: {}", out.empty() ? "" : "<br>", p.name, p.unit.empty() ? "" : ", ", p.unit,
                       p.description);
  return out;
}

}  // namespace

std::string CommandRow::usage() const {
  std::string out(name);
  for (const CommandParameter& p : parameters)
    out += p.is_optional ? fmt::format(" [{}]", p.name) : fmt::format(" {}", p.name);
  return out;
}

std::span<const CommandRow> commandTable() noexcept { return kTable; }

const CommandRow& rowOf(const Command& command) noexcept { return kTable[command.index()]; }

std::string printCommand(const Command& command) {
  std::string out(rowOf(command).name);
  const auto print = [&]<std::size_t N>(std::integral_constant<std::size_t, N>) {
    if (const auto* const c = std::get_if<N>(&command))
      std::apply([&](const auto&... field) { (printField(out, *c, field), ...); }, std::get<N>(kRows).fields);
  };
  [&]<std::size_t... N>(std::index_sequence<N...>) { (print(std::integral_constant<std::size_t, N>{}), ...); }
  (kEach);
  return out;
}

Expected<Command> parseCommand(std::string_view text) {
  const std::vector<std::string_view> words = wordsOf(text);
  std::size_t row = kCount, length = 0;
  for (std::size_t n = 0; n < kCount; ++n) {
    const std::vector<std::string_view> name = wordsOf(kTable[n].name);
    // The longest name counts: "add off" is not "add" with a parameter "off".
    if (name.size() <= length || words.size() < name.size() || !std::equal(name.begin(), name.end(), words.begin()))
      continue;
    row = n;
    length = name.size();
  }
  if (row < kCount) return parseRow(row, text, Words(words).subspan(length), kEach);

  std::string names;
  for (const CommandRow& r : kTable) names += fmt::format("{}{}", names.empty() ? "one of " : ", ", r.name);
  return refuse(text, "", names);
}

std::string commandReference() {
  std::string out =
      "# Session commands\n\n"
      "Commands that a session accepts between two ticks. The session log stores them, and scripts use the same\n"
      "words ([file formats](file-formats.md)). Spaces separate words; decimal numbers have a point; brackets mark\n"
      "optional parameters.\n\n"
      "A command takes effect before the sample of its tick. The session rejects it, and does not record it, without\n"
      "a target: no such tool or object, no stroke to undo, a frozen object.\n\n"
      "| command | effect | parameters | sent by |\n"
      "|---|---|---|---|\n";
  for (const CommandRow& row : kTable)
    out += fmt::format("| `{}` | {} | {} | {} |\n", row.usage(), row.description, parameterList(row), senderNames(row));
  out +=
      "\n"
      "Sent by: the user through `HapticThread::send()`, or the simulation by itself while it runs. "
      "`Session::apply()`,\n"
      "and so a replay, takes every command from anyone.\n\n"
      "This page is written by `kerf replay --commands`, from the table in `sim/session/command.cpp`.\n";
  return out;
}

}  // namespace kerf
