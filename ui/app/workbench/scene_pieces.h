// Pieces of the object in work, by SceneObject::id: moves, names, colours, and the chosen one.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

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
  /// The piece that moves act on. Null: none chosen, or not in the scene.
  const SceneObject* chosen() const;
  void choose(std::optional<std::uint32_t> id) { chosen_ = id; }
  /// Gives the names of the window to the run, for the files that it writes.
  void passNames();

  void opened(Opening how) override;
  void closing() override { passNames(); }
  void update() override;

 private:
  Workbench& bench_;
  std::optional<std::uint32_t> chosen_;
  struct Moving {
    std::uint32_t id = 0;
    std::uint64_t sent = 0;  // done when so many commands are answered
  };
  std::vector<Moving> moving_;
};

}  // namespace kerf
