#include "ui/app/tool/tool_search.h"

#include <gtest/gtest.h>

#include "geometry/tool/tool_file.h"

namespace kerf::tool_search_test {
namespace {

Tool toolOf(const char* id) {
  const auto file = findToolFile(id, defaultToolFolders());
  EXPECT_TRUE(file) << file.error().message();
  return *readTool(*file);
}

TEST(ToolSearch, AToolIsFoundByWhatPeopleCallIt) {
  const Tool round = toolOf("round-014"), saw = toolOf("saw-reciprocating-25"), disc = toolOf("disc-22");
  for (const char* words : {"", "round", "ROUND", "014", "1.4", "1.40", "1.4mm", "round 1.4", "bur", "  carbide  "})
    EXPECT_TRUE(matchesSearch(round, words)) << words;
  for (const char* words : {"saw", "1.5", "round 1.0", "0.14", "xyz"})
    EXPECT_FALSE(matchesSearch(round, words)) << words;
  EXPECT_TRUE(matchesSearch(saw, "saw recip"));
  EXPECT_TRUE(matchesSearch(disc, "22"));
  EXPECT_FALSE(matchesSearch(disc, "round-014"));
}

TEST(ToolSearch, EveryToolOfTheRackIsFoundByItsIdItsNameAndItsIsoNumber) {
  std::size_t tools = 0;
  for (const ToolListing& listed : listTools(defaultToolFolders())) {
    ASSERT_TRUE(listed.tool);
    ++tools;
    EXPECT_TRUE(matchesSearch(*listed.tool, listed.tool->id));
    EXPECT_TRUE(matchesSearch(*listed.tool, listed.tool->name)) << listed.tool->name;
    EXPECT_TRUE(matchesSearch(*listed.tool, listed.tool->iso6360));
  }
  EXPECT_GE(tools, 98u);
}

}  // namespace
}  // namespace kerf::tool_search_test
