// Writes OpenVDB files atomically; the same fields give the same bytes.
#pragma once

#include <openvdb/io/Archive.h>
#include <openvdb/openvdb.h>

#include <filesystem>
#include <string>

#include "geometry/base/atomic_file.h"

namespace kerf::internal {

/// Writes grids as openvdb::io::File does, with the index that lets a reader fetch one grid alone, through an
/// AtomicFile: on a full disk File silently leaves half a file. OpenVDB's identifier of the file is random; here it is
/// part of the SHA-256 of the other bytes.
/// @param compression  flags of openvdb::io, e.g. COMPRESS_BLOSC | COMPRESS_ACTIVE_MASK.
inline Expected<void> writeGrids(const std::filesystem::path& path, const openvdb::GridCPtrVec& grids,
                                 const openvdb::MetaMap& metadata, std::uint32_t compression) {
  struct Archive : openvdb::io::Archive {
    using openvdb::io::Archive::write;
  };
  KERF_TRY(file, AtomicFile::create(path));
  try {
    Archive archive;
    archive.setCompression(compression);
    archive.write(file.stream(), grids, true, metadata);

    constexpr std::streamoff kIdentifier = 21;  // behind magic, three versions and a flag: vdb_header.cpp
    std::string identifier = "00000000-0000-0000-0000-000000000000";
    file.stream().seekp(kIdentifier) << identifier;
    KERF_TRY(hash, file.sha256());
    auto digit = hash.begin();
    for (char& c : identifier)
      if (c == '0' && digit != hash.end()) c = *digit++;
    file.stream().seekp(kIdentifier) << identifier;
  } catch (const std::exception& e) {
    if (const auto written = file.sha256(); !written) return fail(written.error());
    return fail({.code = Error::Code::kWriteFailed,
                 .file = path.string(),
                 .found = e.what(),
                 .expected = "a writable place with room",
                 .hint = "free some space"});
  }
  return file.commit();
}

}  // namespace kerf::internal
