// A session as one file, NAME.kerf: a zip archive of a run, its cases, and session.toml with the hashes of all files.
//
//   session.toml   format = "kerf-session", version, kerf_version; [[file]] name, size, sha256
//   run/...        the run folder: cut, log, tools
//   cases/0/...    its case; cases/1, cases/2, ...: those of its neighbours
#pragma once

#include <filesystem>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"

namespace kerf {

/// A file named .kerf that begins like a zip archive. Other files with this name are scripts.
bool isSessionFile(const std::filesystem::path& path);

/// Writes an ended run with its cases to one file. Builds the archive in memory.
/// Errors: those of finding the cases; kUnsupported for a session that has not ended; kWriteFailed; kCancelled.
Expected<void> packSession(const std::filesystem::path& run_folder, const std::filesystem::path& file,
                           const Progress& progress = {});

/// Unpacks a file to a new folder in DATA/sessions, with the name of the file, and its cases to DATA/unpacked-cases.
/// Replaces nothing; a case that was unpacked before is used again.   @param data  userDataFolder().   @return the run
/// folder. Errors: kBadFormat for a damaged archive, for a name that leads out of the folder, a link, a file that is
/// not listed or has another hash; kUnsupported for a newer version, a zip bomb and a session that has not ended;
/// kWriteFailed, also for too little space; kCancelled.
Expected<std::filesystem::path> unpackSession(const std::filesystem::path& file, const std::filesystem::path& data,
                                              const Progress& progress = {});

/// Writes the present state of an open session to one file. The session goes on: its log is replayed into a run of its
/// own, below DATA, which is packed.
/// @param live  folder of the open session.   @param from  the run that it continues; empty: none.
/// Errors: kEmpty: nothing is cut; those of branchRun() and packSession().   @cost  that of branchRun().
Expected<void> saveSession(const std::filesystem::path& live, const std::filesystem::path& from,
                           const std::filesystem::path& data, const std::filesystem::path& file,
                           const Progress& progress = {});

}  // namespace kerf
