#include "geometry/base/hash.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/support/temporary_folder.h"

namespace kerf::hash_test {
namespace {

std::string of(const std::string& text) { return sha256(std::as_bytes(std::span(text.data(), text.size()))); }

TEST(Hash, NistVectors) {
  EXPECT_EQ(of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(of("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(of(std::string(1'000'000, 'a')), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Hash, AFileOfSeveralReadsGivesTheSame) {
  const TemporaryFolder folder;
  std::string text;
  for (int i = 0; i < 600'000; ++i) text += static_cast<char>(i * 31);
  EXPECT_EQ(sha256OfFile(folder.write("x", text)).value(), of(text));
  EXPECT_EQ(sha256OfFile(folder.path() / "absent").error().code, Error::Code::kNotFound);
}

TEST(Hash, APipeADeviceOrAFolderIsRefusedAtOnce) {
  const TemporaryFolder folder;
  const auto pipe = folder.path() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  for (const std::filesystem::path& path : {pipe, std::filesystem::path("/dev/zero"), folder.path()}) {
    const auto found = sha256OfFile(path);
    ASSERT_FALSE(found) << path;
    EXPECT_EQ(found.error().code, Error::Code::kUnreadable) << path;
    EXPECT_NE(found.error().message().find("a regular file"), std::string::npos) << found.error().message();
  }
}

}  // namespace
}  // namespace kerf::hash_test
