#include "ui/app/commands/command_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "ui/app/base/command_words.h"
#include "ui/app/commands/pointing.h"
#include "ui/app/document/document.h"
#include "ui/app/view/piece_colours.h"
#include "ui/app/workbench/results.h"
#include "ui/app/workbench/scene_pieces.h"

namespace kerf::piece_commands {
namespace {

constexpr double kFarMove = 1000;  // mm

Expected<const SceneObject*> chosen(const AppContext& c) {
  if (const SceneObject* const piece = c.bench.pieces->chosen()) return piece;
  return wrongWord("no piece is chosen", "one of the pieces", "piece.choose 2");
}

// By name, or by number in the list.
Expected<const SceneObject*> named(const AppContext& c, const std::string& word) {
  const auto shown = c.bench.document->scene().shown();
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
               .found = "a neighbour: Kerf keeps it at its scan position",
               .expected = "a piece of the object you cut",
               .hint = "neighbour.work-on " + std::to_string(object->loaded) + ", then move that"});
}

Rigid3 turned(const Rigid3& pose, const Vec3d& middle, const Vec3d& axis, double degrees) {
  const double radians = degrees * std::numbers::pi / 180;
  const Rigid3 turn{Eigen::Quaterniond(Eigen::AngleAxisd(radians, axis)), Vec3d::Zero()};
  const Rigid3 there{Eigen::Quaterniond::Identity(), -middle}, back{Eigen::Quaterniond::Identity(), middle};
  return back * turn * there * pose;
}

bool arePieces(const AppContext& c) {
  if (!c.bench.document->isOpen()) return false;
  const auto shown = c.bench.document->scene().shown();
  const auto is_moved = [](const SceneObject* piece) { return piece->isMoved(); };
  return c.bench.document->scene().pieceCount() > 1 || std::any_of(shown.begin(), shown.end(), is_moved);
}

bool isChosen(const AppContext& c) { return c.bench.document->isOpen() && c.bench.pieces->chosen(); }

Expected<void> choose(AppContext& c, AppWords words) {
  if (words.empty()) return wrongWord("no piece", "its name or number");
  KERF_TRY(object, named(c, words[0]));
  c.bench.pieces->choose(object->id);
  return {};
}

Expected<void> chooseNext(AppContext& c, AppWords) {
  const auto shown = c.bench.document->scene().shown();
  std::size_t next = 0;
  for (std::size_t n = 0; n < shown.size(); ++n)
    if (shown[n] == c.bench.pieces->chosen()) next = n + 1;
  c.bench.pieces->choose(next < shown.size() ? std::optional(shown[next]->id) : std::nullopt);
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
  c.bench.pieces->move(piece->id, pose);
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
  c.bench.pieces->move(piece->id, turned(piece->pose(), middle, Vec3d::Unit(axis), degrees));
  return {};
}

Expected<void> putBack(AppContext& c, AppWords words) {
  KERF_TRY(piece, toMove(c, words, 0));
  c.bench.pieces->move(piece->id, {});
  return {};
}

// Pixel of the picture: 120 80. With "add": beside the others, or out of them.
Expected<void> pick(AppContext& c, AppWords words) {
  KERF_TRY(x, numberOf(words, 0, "X", 0, c.width));
  KERF_TRY(y, numberOf(words, 1, "Y", 0, c.height));
  const bool is_added = words.size() > 2;
  if (is_added && words[2] != "add") return wrongWord("\"" + words[2] + "\"", "add, or nothing");
  const auto hit = c.bench.document->scene().hit(rayUnder(c.camera, x, y, c.width, c.height));
  const SceneObject* const piece = hit ? c.bench.document->scene().find(hit->id) : nullptr;
  if (!piece || piece->isBeside()) return {};
  is_added ? c.bench.pieces->toggle(piece->id) : c.bench.pieces->choose(piece->id);
  return {};
}

Expected<void> add(AppContext& c, AppWords words) {
  if (words.empty()) return wrongWord("no piece", "its name or number");
  KERF_TRY(object, named(c, words[0]));
  c.bench.pieces->toggle(object->id);
  return {};
}

Expected<void> remove(AppContext& c, AppWords words) {
  std::vector<std::uint32_t> ids;
  for (const std::string& word : words) {
    KERF_TRY(piece, named(c, word));
    ids.push_back(piece->id);
  }
  if (words.empty())
    for (const SceneObject* const piece : c.bench.pieces->selected()) ids.push_back(piece->id);
  return c.bench.pieces->remove(ids);
}

Expected<void> hide(AppContext& c, AppWords) {
  KERF_CHECK(chosen(c));
  for (const SceneObject* const piece : c.bench.pieces->selected()) c.bench.pieces->hide(piece->id, true);
  return {};
}

Expected<void> show(AppContext& c, AppWords) {
  for (const SceneObject* const piece : c.bench.document->scene().shown()) c.bench.pieces->hide(piece->id, false);
  return {};
}

Expected<void> rename(AppContext& c, AppWords words) {
  KERF_TRY(piece, chosen(c));
  if (words.empty() || words[0].empty()) return wrongWord("no name", "a name, in quotes if it holds blanks");
  c.bench.pieces->rename(piece->id, words[0]);
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
  c.bench.pieces->colour(piece->id, name);
  return {};
}

Expected<void> exportEach(AppContext& c, AppWords words) {
  KERF_TRY(path, pathOf(words));
  c.bench.results->exportTo(path, {.is_each = true});
  return {};
}

Expected<void> exportChosen(AppContext& c, AppWords words) {
  KERF_TRY(path, pathOf(words));
  KERF_CHECK(chosen(c));
  ExportChoice choice;
  for (const SceneObject* const piece : c.bench.pieces->selected()) choice.only.push_back(piece->id);
  c.bench.results->exportTo(path, choice);
  return {};
}

Expected<void> exportPutBack(AppContext& c, AppWords words) {
  KERF_TRY(path, pathOf(words));
  c.bench.results->exportTo(path, {.is_put_back = true});
  return {};
}

bool hasPiecesAndIdle(const AppContext& c) { return piece_commands::arePieces(c) && when::isIdle(c); }
bool isChosenAndIdle(const AppContext& c) { return piece_commands::isChosen(c) && when::isIdle(c); }

constexpr AppCommand kRows[] = {
    {"file.export-each", "", "", "", "PATH", "Writes one file per piece, NAME-PIECE.stl.", hasPiecesAndIdle,
     exportEach},
    {"file.export-piece", "", "", "", "PATH", "Writes only the chosen pieces, in one file.", isChosenAndIdle,
     exportChosen},
    {"file.export-put-back", "", "", "", "PATH", "Writes all pieces at their scan positions.", hasPiecesAndIdle,
     exportPutBack},
    {"piece.choose", "", "", "", "PIECE", "Chooses a piece by name or number. Moves apply to the chosen piece.",
     when::isOpen, choose},
    {"piece.add", "", "", "", "PIECE", "Adds a piece to the chosen ones, or takes it out.", when::isOpen, add},
    {"piece.pick", "", "", "", "X Y [add]",
     "Chooses the piece at a pixel of the picture; add: beside the others, or out of them.", when::isOpen, pick},
    {"piece.next", "Piece", "Choose next piece", "Tab", "", "Chooses the next piece; after the last piece, none.",
     arePieces, chooseNext},
    {"piece.move", "", "", "", "X Y Z [PIECE]", "Moves a piece, in mm: by name or number (default: the chosen piece).",
     when::isOpen, move},
    {"piece.turn", "", "", "", "X|Y|Z DEGREES [PIECE]",
     "Turns a piece about its centre: by name or number (default: the chosen piece).", when::isOpen, turn},
    {"piece.put-back", "Piece", "Put back", "", "[PIECE]",
     "Returns a piece to its scan position: by name or number (default: the chosen piece).", arePieces, putBack},
    {"piece.hide", "Piece", "Hide", "H", "", "Hides the chosen pieces.", isChosen, hide},
    {"piece.delete", "Piece", "Delete pieces", "Delete", "[PIECE ...]",
     "Removes pieces from the session and its exports, in one undo step: by name or number (default: the chosen "
     "pieces). The last piece stays.",
     when::isOpen, remove},
    {"piece.show-all", "Piece", "Show all", "Shift+H", "", "Shows all pieces.", when::isOpen, show},
    {"piece.rename", "", "", "", "NAME", "Names the chosen piece, for the list and for files.", when::isOpen, rename},
    {"piece.colour", "Piece", "Change colour", "", "[COLOUR|none]",
     "Colours the chosen piece: orange, sky, green, yellow, blue, vermilion or purple (default: the next colour). The "
     "session keeps the colour.",
     isChosen, colour},
};

}  // namespace

std::span<const AppCommand> table() { return kRows; }

}  // namespace kerf::piece_commands
