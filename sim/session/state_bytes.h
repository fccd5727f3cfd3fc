// The state of a session as bytes: what a snapshot in its log holds, and from which a replay can start. Only what
// differs from the objects as loaded is in it. Byte by byte in docs/reference/file-formats.md.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "sim/step/step.h"

namespace kerf {

/// The same state gives the same bytes. Allocates; 3 KB a changed brick.
/// @param loaded  what the session's objects were made of; pieces are of one of them, too.
std::vector<std::byte> packState(const State& state, const LoadedObjects& loaded);

/// Whether the bytes are what packState() of this version gives: others can be neither read nor compared.
bool isStateOfThisVersion(std::span<const std::byte> bytes);

/// A state that goes on as the packed one did, bit for bit: tools, objects, pieces, forces. What could be undone is not
/// in it. Lengths are claims: no list is made longer than the bytes that follow. Each of the (at most kMostObjects)
/// objects is as large as the loaded one it is of, as in the session that was packed.
/// @param file  named in errors. Errors: bytes of another version, cut short, or that fit other objects.
Expected<State> unpackState(std::span<const std::byte> bytes, const LoadedObjects& loaded, const std::string& file);

}  // namespace kerf
