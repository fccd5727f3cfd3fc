// Writing OpenVDB files so that a full disk is noticed.
#pragma once

#include <openvdb/io/Archive.h>
#include <openvdb/openvdb.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "geometry/base/error.h"

namespace kerf::internal {

/// Writes grids as openvdb::io::File does, with the index that lets a reader fetch one grid alone. File itself never
/// looks at its stream again: on a full disk it leaves half a file and says nothing.
/// @param compression  flags of openvdb::io, e.g. COMPRESS_BLOSC | COMPRESS_ACTIVE_MASK.
inline Expected<void> writeGrids(const std::filesystem::path& path, const openvdb::GridCPtrVec& grids,
                                 const openvdb::MetaMap& metadata, std::uint32_t compression) {
  struct Archive : openvdb::io::Archive {
    using openvdb::io::Archive::write;
  };
  const auto error = [&](const std::string& found) {
    return fail({.code = Error::Code::kWriteFailed,
                 .file = path.string(),
                 .found = found,
                 .expected = "a writable place with room",
                 .hint = "free some space"});
  };
  try {
    Archive archive;
    archive.setCompression(compression);
    std::ofstream out(path, std::ios::binary);
    errno = 0;
    archive.write(out, grids, true, metadata);
    out.close();
    if (!out) return error(errno ? std::strerror(errno) : "could not be written");
    return {};
  } catch (const std::exception& e) {
    return error(e.what());
  }
}

}  // namespace kerf::internal
