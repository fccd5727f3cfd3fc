#include "sim/session/command.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <set>

#include "tests/support/places.h"
#include "tests/support/temporary_folder.h"

namespace kerf::command_test {
namespace {

using Limits = std::numeric_limits<double>;

// Doubles that text conversion often loses.
const std::array<double, 12> kAwkward = {0.0,
                                         -0.0,
                                         1.0 / 3,
                                         0.1,
                                         1e22,
                                         Limits::max(),
                                         Limits::min(),
                                         Limits::denorm_min(),
                                         -1e5,
                                         123456789.125,
                                         1 + Limits::epsilon(),
                                         -Limits::max()};

// One or more of every alternative, with distinct numbers, so that swapped parameters show.
std::vector<Command> someCommands() {
  constexpr std::size_t kMost = std::numeric_limits<std::size_t>::max();
  std::vector<Command> out = {SelectTool{0},
                              SelectTool{kMost},
                              Undo{},
                              Redo{},
                              ClearLatch{},
                              AddMaterial{11, 3},
                              AddMaterial{255, kMost},
                              StopAdding{},
                              FreezeObject{3},
                              UnfreezeObject{4},
                              SplitObject{5},
                              SplitObject{6, 0.1},
                              DeleteObjects{{1}},
                              DeleteObjects{{0x8000000000000005}}};
  for (std::size_t n = 0; n < kAwkward.size(); ++n) {
    const auto a = [&](std::size_t k) { return kAwkward[(n + k) % kAwkward.size()]; };
    out.push_back(MoveObject{n, {a(0), a(1), a(2)}, {a(3), a(4), a(5), a(6)}});
    out.push_back(PlaceTool{{a(0), a(1), a(2)}, {a(3), a(4), a(5), a(6)}});
    out.push_back(SplitObject{n, a(0)});
    CutByPlanes cut{n, static_cast<std::uint8_t>(n % 3), {}};
    cut.planes.kerf_mm = a(0);
    for (std::size_t k = 0; k <= n % CutPlanes::kMost; ++k)
      cut.planes.numbers[cut.planes.count++] = {a(k), a(k + 1), a(k + 2), a(k + 3), a(k + 4), a(k + 5)};
    out.push_back(cut);
  }
  return out;
}

// Equal, and -0 differs from 0.
void expectSameBack(const Command& command) {
  const std::string text = printCommand(command);
  const auto back = parseCommand(text);
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(*back, command) << text;
  EXPECT_EQ(printCommand(*back), text);
}

TEST(Command, WhatIsPrintedIsParsedToTheSameBits) {
  std::set<std::size_t> alternatives;
  for (const Command& command : someCommands()) {
    expectSameBack(command);
    alternatives.insert(command.index());
  }
  EXPECT_EQ(alternatives.size(), std::variant_size_v<Command>) << "a command is missing in this test";
  // Any finite double: sign, exponent and mantissa at random.
  std::mt19937_64 random(20261122);
  const auto number = [&] {
    double value = Limits::infinity();
    while (!std::isfinite(value)) value = std::bit_cast<double>(random());
    return value;
  };
  for (int n = 0; n < 2000; ++n)
    expectSameBack(MoveObject{random(), {number(), number(), number()}, {number(), number(), number(), number()}});
}

// The bytes of existing logs.
TEST(Command, TextsAreThoseOfTheLogFormat) {
  const std::pair<Command, const char*> texts[] = {
      {SelectTool{1}, "tool.select 1"},
      {Undo{}, "undo"},
      {Redo{}, "redo"},
      {ClearLatch{}, "latch.clear"},
      {AddMaterial{11, 0}, "add 11 0"},
      {StopAdding{}, "add off"},
      {MoveObject{1, {0, 0.05, -0.0}, {1, 0, 0, 1e-12}}, "object.move 1 0 0.05 -0 1 0 0 1e-12"},
      {FreezeObject{3}, "object.hold 3"},
      {UnfreezeObject{3}, "object.release 3"},
      {SplitObject{0}, "pieces.split 0"},
      {SplitObject{0, 0.1}, "pieces.split 0 0.1"},
      {SplitObject{0, 1}, "pieces.split 0 1"},
      {PlaceTool{{0, 0.05, -0.0}, {1, 0, 0, 1e-12}}, "tool.place 0 0.05 -0 1 0 0 1e-12"},
      {CutByPlanes{2, 1, {0.3, 1, {{{0, 0, 1, 5, 6, 7.5}}}}}, "object.cut 2 1 0.3 0 0 1 5 6 7.5"},
      {CutByPlanes{0, 1, {0, 0, {}, {2, 5, 0, 0, 1, 7, 8, 9}}}, "object.cut 0 1 0 hole 2 5 0 0 1 7 8 9"},
      {CutByPlanes{0, 0, {0.1, 1, {{{0, 0, 1, 5, 6, 7.5}}}, {2, 5, 0, 0, 1, 7, 8, 9}}},
       "object.cut 0 0 0.1 0 0 1 5 6 7.5 hole 2 5 0 0 1 7 8 9"},
      {DeleteObjects{{0b10110}}, "object.delete 1 2 4"}};
  EXPECT_EQ(std::size(texts), std::variant_size_v<Command> + 4);
  for (const auto& [command, text] : texts) {
    EXPECT_EQ(printCommand(command), text);
    EXPECT_EQ(*parseCommand(text), command);
  }
  // Possibly hand-written.
  EXPECT_EQ(*parseCommand("object.move 1 0  0.050 -0.0 1.0 0 0   1E-12"), std::get<0>(texts[6]));
}

TEST(Command, OtherTextIsRefusedWithWhatWasFoundAndWhatIsExpected) {
  struct Case {
    const char *text, *found, *expected;
  };
  const Case cases[] = {{"", "\"\"", "one of tool.select, undo, "},
                        {"fly", "\"fly\"", "one of tool.select, undo, "},
                        {"Undo", "\"Undo\"", "one of "},
                        {"undone", "\"undone\"", "one of "},
                        {"tool.select", "ends too early", "tool.select N, with N: number of the tool"},
                        {"tool.select -1", "\"-1\" in it", "tool.select N"},
                        {"tool.select 1x", "\"1x\" in it", "tool.select N"},
                        {"tool.select 1.5", "\"1.5\" in it", "tool.select N"},
                        {"tool.select 99999999999999999999", "\"99999999999999999999\" in it", "tool.select N"},
                        {"undo 1", "\"1\" behind its end", "undo"},
                        {"add 256 0", "\"256\" in it", "add M N, with M: number of the material"},
                        {"add 200", "ends too early", "add M N, with N: number of the object"},
                        {"add offal", "\"offal\" in it", "add M N"},
                        {"add off 1", "\"1\" behind its end", "add off"},
                        {"object.move 0 0 0 0 1 0 0", "ends too early", "with qw qx qy qz: "},
                        {"object.move 0 0 0 0 1 0 0 0 0", "\"0\" behind its end", "object.move N x y z qw qx qy qz"},
                        {"object.move 0 nan 0 0 1 0 0 0", "\"nan\" in it", "with x y z: "},
                        {"object.move 0 0 0 0 inf 0 0 0", "\"inf\" in it", "with qw qx qy qz: "},
                        {"object.move 0 1e999 0 0 1 0 0 0", "\"1e999\" in it", "with x y z: "},
                        {"object.hold 1,2", "\"1,2\" in it", "object.hold N"},
                        {"pieces.split", "ends too early", "pieces.split N [V]"},
                        {"object.cut 0 0 0", "ends too early", "object.cut N KEEP kerf nx ny nz x y z ..."},
                        {"object.cut 0 0 0 0 0 1 0 0", "ends too early", "object.cut N KEEP"},
                        {"object.cut 0 1 0 hole 2 5 0 0 1", "ends too early", "object.cut N KEEP"},
                        {"pieces.split 0 much", "\"much\" in it", "with V: smaller pieces are crumbs"},
                        {"pieces.split 0 1 2", "\"2\" behind its end", "pieces.split N [V]"}};
  for (const Case& c : cases) {
    const auto command = parseCommand(c.text);
    ASSERT_FALSE(command) << c.text;
    const Error& error = command.error();
    EXPECT_EQ(error.code, Error::Code::kBadValue);
    EXPECT_NE(error.found.find(c.text), std::string::npos) << error.found;
    EXPECT_NE(error.found.find(c.found), std::string::npos) << error.found;
    EXPECT_NE(error.expected.find(c.expected), std::string::npos) << error.expected;
  }
}

TEST(Command, ARowSaysWhoMaySendIt) {
  const auto may_send = [](const Command& command, CommandSender sender) { return rowOf(command).maySend(sender); };
  for (const Command& command : {Command(SelectTool{}), Command(Undo{}), Command(Redo{}), Command(ClearLatch{}),
                                 Command(AddMaterial{}), Command(StopAdding{}), Command(MoveObject{})})
    EXPECT_TRUE(may_send(command, CommandSender::kUser)) << printCommand(command);
  for (const Command& command : {Command(FreezeObject{}), Command(UnfreezeObject{}), Command(SplitObject{})}) {
    EXPECT_FALSE(may_send(command, CommandSender::kUser)) << printCommand(command);
    EXPECT_TRUE(may_send(command, CommandSender::kSimulation)) << printCommand(command);
  }
}

TEST(Command, EveryRowIsAWholeSentenceWithAllItsParameters) {
  ASSERT_EQ(commandTable().size(), std::variant_size_v<Command>);
  for (const CommandRow& row : commandTable()) {
    EXPECT_TRUE(row.description.ends_with('.')) << row.name;
    EXPECT_NE(row.senders, 0) << row.name;
    bool was_optional = false;
    for (const CommandParameter& p : row.parameters) {
      EXPECT_FALSE(p.name.empty() || p.description.empty()) << row.name;
      EXPECT_TRUE(p.is_optional || !was_optional) << row.name << ": only the last ones may be left out";
      was_optional = p.is_optional;
    }
  }
}

TEST(Command, TheReferenceInDocsIsThatOfTheTable) {
  EXPECT_TRUE(contentOf(std::string(kSourceFolder) + "/docs/reference/session-commands.md") == commandReference())
      << "docs/reference/session-commands.md is another one. Write it again, from the root:\n"
      << "  build/release/bin/kerf replay --commands > docs/reference/session-commands.md";
}

}  // namespace
}  // namespace kerf::command_test
