// Source files of a case: hashing, copying into the case, reading, and conversion to mm.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/case/case_bundle.h"
#include "geometry/mesh/mesh.h"
#include "preprocess/bake/bake.h"

namespace kerf::internal {

/// SHA-256 of a file, or of the names and contents of the files in a folder (a series of slices) or of a header and the
/// file with its values (`.mhd`).
Expected<std::string> sha256OfSource(const std::filesystem::path& path);

/// Copies one source, a file or a folder of files, into the case under construction and adds it to the manifest:
/// name, format and hash; unit and counts are the caller's. Several files become a folder, under their own names.
Expected<CaseSource*> storeSource(const std::filesystem::path& path, const std::string& format,
                                  const std::string& sha256, const std::filesystem::path& case_folder,
                                  CaseManifest& manifest);

/// Reads meshes and brings them to mm; fills the report's sources, notes and unit doubts.
/// @param unit     the user's unit; empty: as each file declares, or by size.
/// @param as_one   the meshes are parts of one object: those that declare no unit share one, by their common box.
Expected<std::vector<Mesh>> readMeshSources(const std::vector<std::filesystem::path>& paths,
                                            const std::vector<std::string>& hashes, const std::string& unit,
                                            bool as_one, const std::filesystem::path& case_folder, BakeReport& report,
                                            const Progress& progress);

/// Rejects an object that is larger than kLargestObject, no larger than a voxel, or with too much surface for a field
/// in memory, before the minutes of closing. Most often the unit is wrong, and the error names it. As closing may drop
/// nested layers, only half of the sources' area counts, and at most that of their box.
/// @param meshes  in mm, from readMeshSources(); they belong to the first source of the report.
/// @param is_whole  the object has about their area; false for the parts of a recipe, which are nested.
/// Errors: kBadValue, with the file if there is only one.
Expected<void> checkObjectSize(const std::vector<std::filesystem::path>& paths, const std::vector<Mesh>& meshes,
                               bool is_whole, const BakeOptions& options, const BakeReport& report);

}  // namespace kerf::internal
