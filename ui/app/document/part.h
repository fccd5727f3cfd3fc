// A part of the window's core: it owns one concern and follows the open document.
#pragma once

namespace kerf {

/// How a document came to be shown.
enum class Opening {
  kNew,      ///< by the user: choices about the earlier document are void
  kReopened  ///< the same document in another session, for a tool, a neighbour, a device or a branch
};

/// Window thread only.
class Part {
 public:
  Part() = default;
  virtual ~Part() = default;
  Part(const Part&) = delete;
  Part& operator=(const Part&) = delete;

  /// A document was opened, for cutting or for replay.
  virtual void opened(Opening /*how*/) {}
  /// The open document is about to end: its run still exists.
  virtual void closing() {}
  /// Once a frame, in the order of Workbench::update().
  virtual void update() {}
};

}  // namespace kerf
