#include "geometry/base/text.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/support/temporary_folder.h"

namespace kerf::text_test {
namespace {

namespace fs = std::filesystem;

TEST(SmallFile, IsReadWholeUpToItsLimit) {
  const TemporaryFolder folder;
  const std::string bytes("a\0b\n", 4);
  EXPECT_EQ(readSmallFile(folder.write("a", bytes), 4).value_or(""), bytes);
  EXPECT_EQ(readSmallFile(folder.write("empty", ""), 4).value_or("x"), "");
  const auto larger = readSmallFile(folder.write("b", bytes), 3);
  ASSERT_FALSE(larger);
  EXPECT_EQ(larger.error().code, Error::Code::kBadFormat);
  EXPECT_EQ(readSmallFile(folder.path() / "none", 4).error().code, Error::Code::kNotFound);
}

// A pipe waits for a writer, a device has no end, a sparse file of 16 GB occupies no disk space.
TEST(SmallFile, WhatWouldTakeForEverOrAllMemoryIsRefusedAtOnce) {
  const TemporaryFolder folder;
  ASSERT_EQ(::mkfifo((folder.path() / "pipe").c_str(), 0600), 0);
  fs::create_symlink("/dev/zero", folder.path() / "zero");
  fs::resize_file(folder.write("sparse", ""), std::uintmax_t{16} << 30);
  for (const char* name : {"pipe", "zero", "sparse", "."}) {
    const auto read = readSmallFile(folder.path() / name, 1 << 20);
    ASSERT_FALSE(read) << name;
    EXPECT_NE(read.error().expected.find("1 MB"), std::string::npos) << read.error().message();
  }
}

TEST(PrintableText, HoldsNoCommandToATerminal) {
  EXPECT_EQ(printable("a\x1b]0;x\x07\x7f\nb\r"), "a\\x1b]0;x\\x07\\x7f\\x0ab\\x0d");
  EXPECT_EQ(printable("a\n\tb\x1b", true), "a\n\tb\\x1b");
  EXPECT_EQ(printable("\xc2\x9b"
                      "2J"),
            "\\xc2\\x9b2J")
      << "C1: what ESC [ is in one character";
  EXPECT_EQ(printable("\x9b"
                      "2J \xc3"),
            "\\x9b2J \\xc3")
      << "bytes that are no UTF-8";
  EXPECT_EQ(printable("Zähne \u2013 µm 歯"), "Zähne \u2013 µm 歯");
  EXPECT_EQ(printable("\xed\xa0\x80\xc0\x80"), "\\xed\\xa0\\x80\\xc0\\x80") << "a surrogate, an overlong zero";
}

}  // namespace
}  // namespace kerf::text_test
