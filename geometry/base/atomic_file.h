// Files and folders that appear complete or not at all: written beside the target, flushed to the disk, renamed.
#pragma once

#include <filesystem>
#include <memory>
#include <ostream>
#include <string_view>

#include "geometry/base/error.h"

namespace kerf {

/// A file being written. Until commit() the target keeps its old content; without commit() no file remains.
class AtomicFile {
 public:
  /// Opens a temporary file in the folder of `path`, which must exist, and deletes leftovers of killed processes there.
  /// Follows a symbolic link, so that it stays one; a dangling link is an error.
  /// A target that is not a regular file (a device, a pipe) can not be replaced, and is opened itself.
  static Expected<AtomicFile> create(const std::filesystem::path& path);

  AtomicFile(AtomicFile&&) noexcept;
  AtomicFile& operator=(AtomicFile&&) noexcept;
  ~AtomicFile();

  /// Buffered, seekable, classic locale. Failed writes set badbit; the reason comes with commit().
  std::ostream& stream();
  /// SHA-256 of the bytes so far. Empty for a target that cannot be replaced.   Error kWriteFailed: a write failed.
  Expected<std::string> sha256();
  /// The temporary file with all bytes so far. Empty for a target that cannot be replaced.   Error kWriteFailed.
  Expected<std::filesystem::path> flushed();
  /// Flushes, syncs to the disk, renames over the target. Call once. Errors carry the system's reason ("No space left
  /// on device"); the old file then stays unchanged.
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
  /// @param overwrite  allow replacing an existing folder with all its content. Only an empty folder,
  ///                   or one that holds the file `manifest` and is no bundle of another kind, is ever replaced, and
  ///                   only if Kerf wrote all of its files or its .toml files name them: a wrong path, or an
  ///                   added file, destroys no work.
  static Expected<AtomicFolder> create(const std::filesystem::path& path, bool overwrite,
                                       std::string_view manifest = "case.toml");

  AtomicFolder(AtomicFolder&&) noexcept;
  AtomicFolder& operator=(AtomicFolder&&) noexcept;
  ~AtomicFolder();

  const std::filesystem::path& staging() const;
  const std::filesystem::path& target() const;
  /// Syncs every file and folder in staging(), then puts it in place of the target in one step (Linux RENAME_EXCHANGE;
  /// without it, renames the old folder aside first) and deletes the old one.
  Expected<void> commit();

 private:
  struct State;
  explicit AtomicFolder(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Waits until the names in a folder are on the disk.   Error kWriteFailed.
Expected<void> syncFolder(const std::filesystem::path& folder);
/// The same for all files and folders in it, and for its own name in the folders above.
Expected<void> syncTree(const std::filesystem::path& folder);
/// Copies a file to a free name. Does not sync: syncTree() or AtomicFolder::commit() must follow.
/// Error kWriteFailed.
Expected<void> copyFile(const std::filesystem::path& from, const std::filesystem::path& to);

/// Call before deleting a bundle: protects files of others in it.   @param manifest  the name of its manifest. Error
/// kWriteFailed, naming the first entry of the folder, by name, that Kerf did not write.
Expected<void> requireOnlyOurs(const std::filesystem::path& folder, std::string_view manifest);

}  // namespace kerf
