// Zip archives in memory, by libzip: the container of 3MF files and of saved sessions.
#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/formats/mesh_source.h"

struct zip;

namespace kerf::internal {

/// An archive being read. Its sizes are untrusted: they cause no allocation, and all entries together inflate to at
/// most 64 MiB + 100 times the size of the file, 8 GiB at most. Meshes as XML shrink to a tenth at best, a zip bomb to
/// a thousandth.
class ZipArchive {
 public:
  /// @pre `source` outlives the archive.
  static Expected<ZipArchive> open(const MeshSource& source);

  /// The entry of a part of the package ("/3D/3dmodel.model"): the first slash and the case of letters do not count
  /// (ECMA-376 part 2, 2.2). The first of several.
  std::optional<std::uint64_t> find(std::string_view part) const;
  std::uint64_t count() const;                ///< of entries
  std::string nameOf(std::uint64_t n) const;  ///< of entry n, as stored
  bool isLink(std::uint64_t n) const;         ///< entry n is a symbolic link, or a special file
  /// Hands over an entry piece by piece, in order; calls `progress` in between. Damage shows at the end, as a wrong
  /// checksum: pieces received before are then invalid.
  Expected<void> read(std::uint64_t entry, const std::function<Expected<void>(std::string_view)>& take,
                      const Progress& progress = {});

 private:
  struct Closer {
    void operator()(zip* archive) const;
  };
  explicit ZipArchive(const MeshSource& source) : source_(&source) {}
  tl::unexpected<Error> bad(std::string_view name, std::string found) const;

  const MeshSource* source_;
  std::unique_ptr<zip, Closer> archive_;
  std::uint64_t budget_ = 0;  // bytes that may still be inflated
};

struct ZipEntry {
  std::string name;
  std::string bytes;
  std::filesystem::path file{};  ///< its bytes, if not empty: read while writing
};
/// Writes an archive of deflated entries, in this order, all dated 1980-01-01: the same entries give the same bytes.
/// Builds the archive in memory.
Expected<void> writeZip(std::ostream& out, const std::vector<ZipEntry>& entries);

}  // namespace kerf::internal
