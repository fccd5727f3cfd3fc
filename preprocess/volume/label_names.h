// Label names in a file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

namespace kerf {

/// Names of labels as written by 3D Slicer into the header of a segmentation (`.seg.nrrd`, `.nrrd`): Segment0_Name
/// beside Segment0_LabelValue. Empty for every other file, and for an unreadable header: names are for display only,
/// and readLabelVolume() reports the error.   @cost  the header alone, at most 1 MB of it.
std::map<std::uint16_t, std::string> labelNames(const std::filesystem::path& path);

}  // namespace kerf
