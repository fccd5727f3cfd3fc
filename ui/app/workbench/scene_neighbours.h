// Neighbours of the object in work: other teeth or the other jaw, at their scan positions.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "ui/app/document/part.h"
#include "ui/app/import/opening.h"
#include "ui/app/session/neighbours.h"

namespace kerf {

class Workbench;
struct SceneObject;

/// Window thread only.
class SceneNeighbours final : public Part {
 public:
  explicit SceneNeighbours(Workbench& bench) : bench_(bench) {}

  /// Adds a neighbour. The open document continues in a new session: undo reaches back to here. A job.
  void openBeside(const std::filesystem::path& path);
  /// The same for several, each with its own preparation. An import stays until they are placed, for another remedy.
  void place(std::vector<OpenBeside> asked, const std::string& title);
  /// Swaps roles: that neighbour is cut, the current object becomes a neighbour, both as in their cases. Writes the
  /// current session first.
  void workOn(std::size_t number);

  /// Takes a neighbour away. The open document is opened again without it.
  /// Error kUnsupported: the session has cuts, or continues another one, which keep all their neighbours.
  Expected<void> remove(std::size_t number);

  std::vector<Neighbour> list() const;
  /// Null: no such neighbour.   @param name  or, if none has that name, its number.
  const SceneObject* find(const std::string& name) const;
  /// Makes it translucent and not selectable.
  void makeGhost(std::uint32_t id, bool is_ghost);
  /// Whether that object is a neighbour; if so, says that it cannot be used like the object in work.
  /// @param use  "to be cut"
  bool isNeighbour(std::uint32_t id, const std::string& use);

  void opened(Opening how) override;
  void update() override;

 private:
  Workbench& bench_;
  struct CutOff {
    double told_mm3 = 0, now_mm3 = 0;
    std::uint64_t tick = 0;  // of the last change
  };
  std::vector<CutOff> cut_off_;
};

}  // namespace kerf
