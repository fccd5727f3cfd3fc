// Reads a grid of an OpenVDB file leaf by leaf, so that memory holds its values only once. openvdb::io::File builds a
// whole tree of them first.
#pragma once

#include <fmt/format.h>
#include <openvdb/io/Archive.h>
#include <openvdb/io/Compression.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/openvdb.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "geometry/base/error.h"

namespace kerf::internal {

/// One grid of a .vdb file. Functions throw OpenVDB's exceptions, and std::ios_base::failure for a truncated file: see
/// vdbReadError(). One thread.
class VdbGridFile : openvdb::io::Archive {
 public:
  /// @pre a regular file.
  explicit VdbGridFile(const std::filesystem::path& path) : buffer_(kBuffer) {
    openvdb::initialize();
    in_.rdbuf()->pubsetbuf(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
    in_.open(path, std::ios::binary);
    in_.exceptions(std::ios::failbit | std::ios::badbit);
    openvdb::io::setStreamMetadataPtr(in_, metadata_, false);
    readHeader(in_);
    setFormatVersion(in_);
    setLibraryVersion(in_);
    setDataCompression(in_);
    if (!inputHasGridOffsets() || fileVersion() < openvdb::OPENVDB_FILE_VERSION_NODE_MASK_COMPRESSION)
      throw openvdb::IoError("no index of its grids, or an older version of the format");
  }

  /// The grid of that name: its transform, and its tree without the values of the leaves, which must not be read. Null
  /// if none.
  openvdb::GridBase::Ptr open(const std::string& name) {
    openvdb::io::GridDescriptor found;
    const openvdb::GridBase::Ptr grid = find(name, found);
    if (!grid) return nullptr;
    if (found.isInstance()) throw openvdb::IoError("it shares the values of another grid");

    metadata_->setHalfFloat(found.saveFloatAsHalf());
    grid->setSaveFloatAsHalf(found.saveFloatAsHalf());
    found.seekToGrid(in_);
    readGridCompression(in_);
    grid->readMeta(in_);
    metadata_->gridMetadata() = *grid;
    openvdb::io::setGridClass(in_, grid->getGridClass());
    grid->readTransform(in_);
    grid->readTopology(in_);
    return grid;
  }

  /// The values of the next leaf; call it for each of the grid's leaves, in their order.   @param out  512 of them.
  template <class Value>
  void readLeaf(Value* out) {
    openvdb::util::NodeMask<3> active;
    active.load(in_);
    openvdb::io::readCompressedValues(in_, out, active.SIZE, active, metadata_->halfFloat());
  }

 private:
  static constexpr std::size_t kBuffer = 1 << 18;

  openvdb::GridBase::Ptr find(const std::string& name, openvdb::io::GridDescriptor& found) {
    openvdb::MetaMap().readMeta(in_);
    const std::int32_t count = readGridCount(in_);
    for (std::int32_t n = 0; n < count; ++n) {
      openvdb::io::GridDescriptor here;
      const openvdb::GridBase::Ptr grid = here.read(in_);
      if (here.gridName() == name) {
        found = here;
        return grid;
      }
      here.seekToEnd(in_);
    }
    return nullptr;
  }

  openvdb::io::StreamMetadata::Ptr metadata_ = std::make_shared<openvdb::io::StreamMetadata>();  // in_ points to it
  std::vector<char> buffer_;
  std::ifstream in_;
};

/// Error about a file of Kerf's.
inline Error vdbReadError(const std::filesystem::path& path, const std::string& place, const std::string& found) {
  return {.code = Error::Code::kUnreadable,
          .file = path.string(),
          .place = place,
          .found = found,
          .expected = "an OpenVDB file written by Kerf",
          .hint = "bake the case again"};
}

/// Error from an exception of the reader.
inline Error vdbReadError(const std::filesystem::path& path, const std::string& place, const std::exception& thrown) {
  const bool is_short = dynamic_cast<const std::ios_base::failure*>(&thrown) != nullptr;
  return vdbReadError(path, place, is_short ? "cut short, or not to be read" : thrown.what());
}

/// "at voxel 4, 5, 6, which is 2.000, 2.500, 3.000 mm".
inline std::string vdbPlace(const openvdb::GridBase& grid, const openvdb::Coord& at) {
  const openvdb::Vec3d p = grid.constTransform().indexToWorld(at);
  return fmt::format("at voxel {}, {}, {}, which is {:.3f}, {:.3f}, {:.3f} mm", at.x(), at.y(), at.z(), p.x(), p.y(),
                     p.z());
}

/// Error unless `path` is a regular file.
inline Expected<void> requireVdbFile(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::is_regular_file(path, ignored)) return {};
  return fail(vdbReadError(path, "file", std::filesystem::exists(path, ignored) ? "no regular file" : "no such file"));
}

/// Error unless a node's place is a scale times its indices.
inline Expected<void> requireUniformScale(const openvdb::GridBase& grid, const std::filesystem::path& path,
                                          const std::string& place) {
  const openvdb::math::Transform& transform = grid.constTransform();
  if (!transform.isLinear() || !transform.hasUniformScale() || transform.indexToWorld(openvdb::Vec3d(0)).length() != 0)
    return fail(vdbReadError(path, place, "a transform that is more than a uniform scale"));
  const double voxel = transform.voxelSize()[0];
  if (!(voxel >= 1e-3 && voxel <= 100))
    return fail(vdbReadError(path, place, fmt::format("a voxel size of {} mm", voxel)));
  return {};
}

}  // namespace kerf::internal
