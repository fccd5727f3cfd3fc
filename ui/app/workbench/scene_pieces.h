// Pieces of the object in work, by SceneObject::id: moves, names, colours, deletion, and the chosen ones.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/types.h"
#include "ui/app/document/part.h"

namespace kerf {

class Workbench;
struct SceneObject;

/// Window thread only.
class ScenePieces final : public Part {
 public:
  explicit ScenePieces(Workbench& bench) : bench_(bench) {}

  /// One undo step. Rejected with a notice during a stroke, and for an unusable pose.
  void move(std::uint32_t id, const Rigid3& T_world_object);
  /// Shows the piece at this pose until move(), or until a call with none.
  void drag(std::uint32_t id, const std::optional<Rigid3>& T_world_object);
  void hide(std::uint32_t id, bool is_hidden);
  void rename(std::uint32_t id, const std::string& name);
  /// Display colour, kept with the session like the name.   @param colour  of pieceColours(); empty: none.
  void colour(std::uint32_t id, const std::string& colour);
  /// Removes pieces from the session: one undo step. A notice tells their volume once it is done.
  /// Errors: kEmpty for none; kUnsupported for all pieces, for neighbours, and while the tool is in use.
  Expected<void> remove(std::span<const std::uint32_t> ids);
  /// A deletion is sent and not answered: the numbers of the objects may change.
  bool isRemoving() const { return removing_.has_value(); }

  // ---- The chosen ones

  /// The piece that moves act on: the last of selected() by choice. Null: none chosen, or not in the scene.
  const SceneObject* chosen() const;
  /// All chosen pieces, in the order of the scene.
  std::vector<const SceneObject*> selected() const;
  bool isSelected(std::uint32_t id) const;
  /// This piece alone.
  void choose(std::optional<std::uint32_t> id);
  /// Adds a piece, or takes it out.
  void toggle(std::uint32_t id);
  /// All pieces of the list from the chosen one to this one.
  void chooseTo(std::uint32_t id);
  /// Gives the names of the window to the run, for the files that it writes.
  void passNames();

  void opened(Opening how) override;
  void closing() override { passNames(); }
  void update() override;

 private:
  void reportRemoved();

  Workbench& bench_;
  std::vector<std::uint32_t> selected_;  // the last is chosen()
  struct Removing {
    std::uint64_t sent = 0, refused_before = 0;
  };
  std::optional<Removing> removing_;
  struct Moving {
    std::uint32_t id = 0;
    std::uint64_t sent = 0;  // done when so many commands are answered
  };
  std::vector<Moving> moving_;
};

}  // namespace kerf
