#include "ui/app/commands/piece_commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "ui/app/base/command_words.h"
#include "ui/app/view/piece_colours.h"

namespace kerf::piece_commands {
namespace {

constexpr double kFarMove = 1000;  // mm

Expected<const SceneObject*> chosen(const AppContext& c) {
  if (const SceneObject* const piece = c.bench.chosenPiece()) return piece;
  return wrongWord("no piece is chosen", "one of the pieces", "piece.choose 2");
}

// By name, or by number in the list.
Expected<const SceneObject*> named(const AppContext& c, const std::string& word) {
  const auto shown = c.bench.scene().shown();
  std::string names;
  for (std::size_t n = 0; n < shown.size(); ++n) {
    if (word == shown[n]->name || word == std::to_string(n + 1)) return shown[n];
    names += (n ? ", " : "") + shown[n]->name;
  }
  return wrongWord("\"" + word + "\"", fmt::format("1 to {}, or one of {}", shown.size(), names));
}

// The piece to move: word n, if given, else the chosen piece. Neighbours stay at their scan positions.
Expected<const SceneObject*> toMove(const AppContext& c, AppWords words, std::size_t n) {
  KERF_TRY(object, n < words.size() ? named(c, words[n]) : chosen(c));
  if (!object->isBeside()) return object;
  return fail({.code = Error::Code::kUnsupported,
               .place = object->name,
               .found = "a neighbour, which stands where its scan is: distances to it are measured there",
               .expected = "a piece of what is worked on",
               .hint = "neighbour.work-on " + std::to_string(object->loaded) + ", then move that"});
}

Rigid3 turned(const Rigid3& pose, const Vec3d& middle, const Vec3d& axis, double degrees) {
  const double radians = degrees * std::numbers::pi / 180;
  const Rigid3 turn{Eigen::Quaterniond(Eigen::AngleAxisd(radians, axis)), Vec3d::Zero()};
  const Rigid3 there{Eigen::Quaterniond::Identity(), -middle}, back{Eigen::Quaterniond::Identity(), middle};
  return back * turn * there * pose;
}

}  // namespace

bool arePieces(const AppContext& c) {
  const auto shown = c.bench.scene().shown();
  const auto is_moved = [](const SceneObject* piece) { return piece->isMoved(); };
  return c.bench.scene().pieceCount() > 1 || std::any_of(shown.begin(), shown.end(), is_moved);
}

bool isChosen(const AppContext& c) { return c.bench.chosenPiece() != nullptr; }

Expected<void> choose(AppContext& c, AppWords words) {
  if (words.empty()) return wrongWord("no piece", "its name or number");
  KERF_TRY(object, named(c, words[0]));
  c.bench.choosePiece(object->id);
  return {};
}

Expected<void> chooseNext(AppContext& c, AppWords) {
  const auto shown = c.bench.scene().shown();
  std::size_t next = 0;
  for (std::size_t n = 0; n < shown.size(); ++n)
    if (shown[n] == c.bench.chosenPiece()) next = n + 1;
  c.bench.choosePiece(next < shown.size() ? std::optional(shown[next]->id) : std::nullopt);
  return {};
}

Expected<void> move(AppContext& c, AppWords words) {
  KERF_TRY(piece, toMove(c, words, 3));
  Rigid3 pose = piece->pose();
  for (int axis = 0; axis < 3; ++axis) {
    static constexpr const char* kNames[] = {"X", "Y", "Z"};
    KERF_TRY(mm, numberOf(words, static_cast<std::size_t>(axis), kNames[axis], -kFarMove, kFarMove));
    pose.translation[axis] += mm;
  }
  c.bench.movePiece(piece->id, pose);
  return {};
}

Expected<void> turn(AppContext& c, AppWords words) {
  KERF_TRY(piece, toMove(c, words, 2));
  const std::string name = words.empty() ? "" : words[0];
  const int axis = name == "X" || name == "x"   ? 0
                   : name == "Y" || name == "y" ? 1
                   : name == "Z" || name == "z" ? 2
                                                : -1;
  if (axis < 0) return wrongWord("\"" + name + "\"", "X, Y or Z");
  KERF_TRY(degrees, numberOf(words, 1, "DEGREES", -360, 360));
  const Vec3d middle = piece->pose() * piece->surface.bounds().center();
  c.bench.movePiece(piece->id, turned(piece->pose(), middle, Vec3d::Unit(axis), degrees));
  return {};
}

Expected<void> putBack(AppContext& c, AppWords words) {
  KERF_TRY(piece, toMove(c, words, 0));
  c.bench.movePiece(piece->id, {});
  return {};
}

Expected<void> hide(AppContext& c, AppWords) {
  KERF_TRY(piece, chosen(c));
  c.bench.hidePiece(piece->id, true);
  return {};
}

Expected<void> show(AppContext& c, AppWords) {
  for (const SceneObject* const piece : c.bench.scene().shown()) c.bench.hidePiece(piece->id, false);
  return {};
}

Expected<void> rename(AppContext& c, AppWords words) {
  KERF_TRY(piece, chosen(c));
  if (words.empty() || words[0].empty()) return wrongWord("no name", "a name, in quotes if it holds blanks");
  c.bench.namePiece(piece->id, words[0]);
  return {};
}

Expected<void> colour(AppContext& c, AppWords words) {
  KERF_TRY(piece, chosen(c));
  std::string name;
  if (words.empty()) {
    // The next colour of the palette; none after the last.
    const auto all = pieceColours();
    const auto* const now = findPieceColour(piece->colour);
    const std::size_t next = now ? static_cast<std::size_t>(now - all.data()) + 1 : 0;
    if (next < all.size()) name = all[next].name;
  } else if (words[0] != "none") {
    if (!findPieceColour(words[0])) {
      std::string names;
      for (const PieceColour& known : pieceColours()) names += std::string(known.name) + ", ";
      return wrongWord("\"" + words[0] + "\"", "one of " + names + "none");
    }
    name = words[0];
  }
  c.bench.colourPiece(piece->id, name);
  return {};
}

Expected<void> exportEach(AppContext& c, AppWords words) {
  KERF_TRY(path, pathOf(words));
  c.bench.exportTo(path, {.is_each = true});
  return {};
}

Expected<void> exportChosen(AppContext& c, AppWords words) {
  KERF_TRY(path, pathOf(words));
  KERF_TRY(piece, chosen(c));
  c.bench.exportTo(path, {.only = piece->id});
  return {};
}

Expected<void> exportPutBack(AppContext& c, AppWords words) {
  KERF_TRY(path, pathOf(words));
  c.bench.exportTo(path, {.is_put_back = true});
  return {};
}

}  // namespace kerf::piece_commands
