// Checkpoints: states of a running session in files beside its log. After a crash, recovery starts from the newest and
// replays only the rest of the log.
//
//   RUN/checkpoint-SAMPLES.kerfstate   after so many samples of the log
#pragma once

#include <cstddef>
#include <filesystem>
#include <string_view>
#include <vector>

#include "geometry/base/error.h"
#include "sim/session/session.h"

namespace kerf {

inline constexpr std::string_view kCheckpointName = "checkpoint-";  ///< begins the name of each file

struct Checkpoint {
  std::size_t samples = 0, events = 0;  ///< of the log, before it: SessionLog
  SessionRest rest;
  State state;
};

/// Writes the present state beside the log: whole or not at all, synced. The same state goes on, bit for bit, from a
/// file as from memory: within a stroke, too.
/// @param samples, events  of the log, so far.   @return bytes of the file.
/// Errors: kWriteFailed, also if less than kCheckpointSpares would stay free; kBadValue for a state above
/// kMaxSnapshotBytes.   @cost  about 40 µs a changed brick, for the packing.
Expected<std::uintmax_t> writeCheckpoint(const std::filesystem::path& run_folder, Session& session, std::size_t samples,
                                         std::size_t events);
inline constexpr std::uintmax_t kCheckpointSpares = std::uintmax_t{256} << 20;  ///< bytes of disk, for the log

/// Checkpoints of a run, newest first.
std::vector<std::filesystem::path> findCheckpoints(const std::filesystem::path& run_folder);
void removeCheckpoints(const std::filesystem::path& run_folder);

/// @param loaded  the objects of the session.
/// Errors: kUnreadable; kBadFormat for damaged bytes; kUnsupported for another version; those of unpackState().
Expected<Checkpoint> readCheckpoint(const std::filesystem::path& file, const LoadedObjects& loaded);

}  // namespace kerf
