// What a file calls its labels.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

namespace kerf {

/// Names of labels, as 3D Slicer writes them into the header of a segmentation (`.seg.nrrd`, `.nrrd`): Segment0_Name
/// beside Segment0_LabelValue. Empty for every other file, and for one whose header can not be read: names are for
/// people, and readLabelVolume() says what is wrong with a file.   @cost  the header alone, at most 1 MB of it.
std::map<std::uint16_t, std::string> labelNames(const std::filesystem::path& path);

}  // namespace kerf
