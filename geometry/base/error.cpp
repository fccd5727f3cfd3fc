#include "geometry/base/error.h"

namespace kerf {

std::string Error::message() const {
  std::string text;
  for (const std::string* part : {&file, &place})
    if (!part->empty()) text += *part + ": ";
  text += found;
  if (!expected.empty()) text += "; expected " + expected;
  if (!hint.empty()) text += ". Try: " + hint;
  return text;
}

}  // namespace kerf
