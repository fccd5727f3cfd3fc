// What a person sees of a surface: chunks with the colours of their tissues, and darker where light hardly comes.
#pragma once

#include <memory>

#include "geometry/base/error.h"
#include "sim/live/remesher.h"
#include "sim/object/baked_object.h"

namespace kerf::internal {

/// For RemesherOptions::finish, of an object and of its pieces. Keeps the object.
/// @param is_beside  greyer: it is not what is worked on.   Error: the table of materials cannot be read.
Expected<decltype(RemesherOptions::finish)> chunkLook(std::shared_ptr<const BakedObject> object,
                                                      bool is_beside = false);

}  // namespace kerf::internal
