// Changes and costs of closing as numbers, stored in a case.
#pragma once

#include <map>
#include <string>

#include "preprocess/close/close.h"

namespace kerf {

/// By the keys of "closing" in kerf bake --json: CaseManifest::closing.
std::map<std::string, double> closingNumbers(const CloseReport& report);

}  // namespace kerf
