// The state of a session as bytes: the content of a snapshot, from which a replay can start. Holds only the differences
// from the objects as loaded. Byte by byte in docs/reference/file-formats.md.
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
/// @param loaded  the loaded objects; pieces belong to one of them, too.
std::vector<std::byte> packState(const State& state, const LoadedObjects& loaded);

/// Whether packState() of this version made the bytes: others can be neither read nor compared.
bool isStateOfThisVersion(std::span<const std::byte> bytes);

/// A state that continues the packed one, bit for bit: tools, objects, pieces, forces. Undo steps are not in it.
/// Lengths are claims: no list is made longer than the bytes that follow. Each of the (at most kMostObjects) objects is
/// as large as its loaded object, as in the packed session.
/// @param file  named in errors. Errors: bytes of another version, cut short, or that fit other objects.
Expected<State> unpackState(std::span<const std::byte> bytes, const LoadedObjects& loaded, const std::string& file);

}  // namespace kerf
