// Files and folders that appear complete or not at all: written beside the target, flushed to the disk, renamed.
#pragma once

#include <filesystem>
#include <memory>
#include <ostream>
#include <string_view>

#include "geometry/base/error.h"

namespace kerf {

/// A file being written. Until commit() the target keeps its old content; without commit() nothing is left behind.
class AtomicFile {
 public:
  /// Opens a temporary file in the folder of `path`, which must exist, and deletes there what killed processes were
  /// writing for the same target. A symbolic link is followed, so that it stays one; one that leads nowhere is refused.
  /// A target that is not a regular file (a device, a pipe) is opened itself: it cannot be replaced.
  static Expected<AtomicFile> create(const std::filesystem::path& path);

  AtomicFile(AtomicFile&&) noexcept;
  AtomicFile& operator=(AtomicFile&&) noexcept;
  ~AtomicFile();

  /// Buffered, classic locale. Failed writes set badbit; the reason comes with commit().
  std::ostream& stream();
  /// Flushes, syncs to the disk, renames over the target. Call once. Errors carry the system's reason ("No space left
  /// on device"); the old file is then untouched.
  Expected<void> commit();

 private:
  struct State;
  explicit AtomicFile(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// A folder being built, such as a case bundle: fill staging(), then commit().
class AtomicFolder {
 public:
  /// Makes an empty folder beside `path`, whose parent must exist; leftovers and links as with AtomicFile.
  /// @param overwrite  allow an existing folder to be replaced as a whole: everything in it goes. Only an empty folder,
  ///                   or one that holds the file `manifest` and is no bundle of another kind, is ever replaced, and
  ///                   only while all in it is what Kerf writes or one of its .toml files names: a wrong path, or a
  ///                   file laid beside, destroys no work.
  static Expected<AtomicFolder> create(const std::filesystem::path& path, bool overwrite,
                                       std::string_view manifest = "case.toml");

  AtomicFolder(AtomicFolder&&) noexcept;
  AtomicFolder& operator=(AtomicFolder&&) noexcept;
  ~AtomicFolder();

  const std::filesystem::path& staging() const;
  /// Syncs every file and folder in staging(), then puts it in place of the target in one step (Linux RENAME_EXCHANGE;
  /// where the file system lacks it, the old folder is renamed aside first) and deletes the old one.
  Expected<void> commit();

 private:
  struct State;
  explicit AtomicFolder(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Before a bundle is deleted: nothing of somebody else's may go with it.   @param manifest  the name of its manifest.
/// Error kWriteFailed, naming the first entry of the folder, by name, that Kerf did not write.
Expected<void> requireOnlyOurs(const std::filesystem::path& folder, std::string_view manifest);

}  // namespace kerf
