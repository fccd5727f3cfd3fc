#include "ui/window/gl/key_names.h"

#include <gtest/gtest.h>

#include "ui/app/commands/app_commands.h"

namespace kerf::key_names_test {
namespace {

TEST(KeyNames, EveryKeyOfTheTableIsAKey) {
  for (const AppCommand& command : appCommands()) {
    const bool is_known = command.key.empty() || keyChord(command.key).key != 0;
    EXPECT_TRUE(is_known) << command.id << " " << command.key;
  }
}

}  // namespace
}  // namespace kerf::key_names_test
