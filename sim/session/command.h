// Commands of a session between two ticks: one small value for each, and one table of them all.
//
// Values cross queues and reach the 1 kHz thread. Text exists only for people and files: in the session log, in scripts
// and in help. printCommand() and parseCommand() convert. Log, help, error texts and docs/reference/session-commands.md
// all follow from the table in command.cpp.
//
// A new command is a struct and its place in Command here, its row in the table, and Session::perform(). If one is
// missing, it does not compile.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>

#include "geometry/base/error.h"
#include "sim/object/plane_sides.h"

namespace kerf {

struct SelectTool {
  std::size_t tool = 0;  ///< index into Model::tools
  bool operator==(const SelectTool&) const = default;
};
struct Undo {
  bool operator==(const Undo&) const = default;
};
struct Redo {
  bool operator==(const Redo&) const = default;
};
struct ClearLatch {
  bool operator==(const ClearLatch&) const = default;
};
struct AddMaterial {
  std::uint8_t material = 0;  ///< number of a Material, 1 to 255
  std::size_t object = 0;     ///< index into State::objects, as in all that follow
  bool operator==(const AddMaterial&) const = default;
};
struct StopAdding {
  bool operator==(const StopAdding&) const = default;
};
struct MoveObject {
  std::size_t object = 0;
  std::array<double, 3> translation{};         ///< of T_world_object: x y z, mm, shorter than 1e5
  std::array<double, 4> rotation{1, 0, 0, 0};  ///< of T_world_object: unit quaternion w x y z
  bool operator==(const MoveObject&) const = default;
};
struct FreezeObject {
  std::size_t object = 0;
  bool operator==(const FreezeObject&) const = default;
};
struct UnfreezeObject {
  std::size_t object = 0;
  bool operator==(const UnfreezeObject&) const = default;
};
struct SplitObject {
  std::size_t object = 0;
  std::optional<double> crumb_mm3 = {};  ///< pieces below this volume are crumbs; none: PieceOptions::crumb_mm3
  bool operator==(const SplitObject&) const = default;
};
struct CutByPlanes {
  std::size_t object = 0;
  std::uint8_t keep = 0;  ///< PlaneKeep
  CutPlanes planes;       ///< in the frame of the object as loaded
  bool operator==(const CutByPlanes&) const = default;
};
/// Objects by number, at least one.
struct ObjectSet {
  static constexpr std::size_t kMost = 64;
  std::uint64_t bits = 0;  ///< objectBit() of each, or-ed
  bool has(std::size_t object) const noexcept { return object < kMost && (bits >> object & 1) != 0; }
  bool operator==(const ObjectSet&) const = default;
};
struct DeleteObjects {
  ObjectSet objects;  ///< pieces of one loaded object, not all of them
  bool operator==(const DeleteObjects&) const = default;
};
struct PlaceTool {
  std::array<double, 3> translation{};         ///< of T_world_tool: x y z, mm, shorter than 1e5
  std::array<double, 4> rotation{1, 0, 0, 0};  ///< of T_world_tool: unit quaternion w x y z
  bool operator==(const PlaceTool&) const = default;
};

using Command = std::variant<SelectTool, Undo, Redo, ClearLatch, AddMaterial, StopAdding, MoveObject, FreezeObject,
                             UnfreezeObject, SplitObject, PlaceTool, CutByPlanes, DeleteObjects>;
static_assert(std::is_trivially_copyable_v<Command>, "a command crosses queues without allocation");

/// Senders of a command while a HapticThread runs the session. Session::apply() itself takes every command, so a log or
/// a script may hold all of them.
enum class CommandSender : std::uint8_t {
  kUser = 1,       ///< from outside, by HapticThread::send()
  kSimulation = 2  ///< HapticThread and PieceMaker by themselves; in lockstep Session::tick()
};

struct CommandParameter {
  std::string_view name;         ///< as in the usage; several words for several numbers: "x y z"
  std::string_view unit;         ///< empty: a number without unit
  std::string_view description;  ///< meaning and range
  bool is_optional = false;      ///< may be left out at the end
};

/// Table row of one command.
struct CommandRow {
  std::string_view name;                         ///< in the log, in one or two words: "tool.select", "add off"
  std::string_view description;                  ///< one sentence
  std::uint8_t senders = 0;                      ///< CommandSender, or-ed
  std::span<const CommandParameter> parameters;  ///< in their order in the text

  constexpr bool maySend(CommandSender sender) const noexcept {
    return (senders & static_cast<std::uint8_t>(sender)) != 0;
  }
  /// "object.move N x y z qw qx qy qz"; optional ones in brackets.
  std::string usage() const;
};

/// All commands, in the order of Command.
std::span<const CommandRow> commandTable() noexcept;
/// The row of one. @rt safe.
const CommandRow& rowOf(const Command& command) noexcept;

/// The text of a command, as the log holds it. Numbers are the shortest that read back to the same bits. Allocates.
std::string printCommand(const Command& command);
/// Inverse: parseCommand(printCommand(c)) is c for finite numbers. Spaces separate words. kBadValue names the found
/// and the expected text: an unknown name, a parameter that is missing, no number or out of range of its type, or extra
/// words. Session::apply() checks whether tool and object exist.
Expected<Command> parseCommand(std::string_view text);

/// The table as Markdown: docs/reference/session-commands.md is this text.
std::string commandReference();

}  // namespace kerf
