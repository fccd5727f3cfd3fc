#include "preprocess/volume/slice_trial.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <thread>

#include "tests/preprocess/label_volume_samples.h"
#include "tests/support/places.h"
#include "tests/support/temporary_folder.h"

namespace kerf::internal {
namespace {

constexpr std::uint64_t kMost = 64 << 20;

std::string seedOf(const std::string& name) {
  std::ifstream in(std::filesystem::path(kSourceFolder) / "tests/data/fuzz/label_slices" / name, std::ios::binary);
  return std::string{std::istreambuf_iterator<char>(in), {}}.substr(1);
}

class SliceTrial : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const std::string& bytes) {
    folder_.write(name, bytes);
    return folder_.path() / name;
  }
  const TemporaryFolder folder_;
};

TEST_F(SliceTrial, ASoundSliceSurvivesAndOneThatKillsTheReaderDoesNot) {
  const auto good = write("a.dcm", dicomSlice(countingLabels().substr(0, 12), 0));
  const auto bad = write("b.dcm", seedOf("dcm-large-length"));
  EXPECT_TRUE(survivesReading({good}, VolumeFormat::kDicom, kMost).value());
  EXPECT_FALSE(survivesReading({good, bad}, VolumeFormat::kDicom, kMost).value());
}

// A host may have threads, ignore its children and block signals: the trial still ends and tells the two apart.
TEST_F(SliceTrial, WorksOnThreadsOfAHostThatIgnoresItsChildren) {
  const auto good = write("a.dcm", dicomSlice(countingLabels().substr(0, 12), 0));
  const auto bad = write("b.dcm", seedOf("dcm-slow"));
  const auto before = std::signal(SIGCHLD, SIG_IGN);
  std::array<bool, 4> survived{};
  std::vector<std::thread> threads;
  for (std::size_t n = 0; n < survived.size(); ++n)
    threads.emplace_back([&, n] {
      sigset_t all;
      sigfillset(&all);
      pthread_sigmask(SIG_BLOCK, &all, nullptr);
      survived[n] = survivesReading({n % 2 ? bad : good}, VolumeFormat::kDicom, kMost).value();
    });
  for (std::thread& t : threads) t.join();
  std::signal(SIGCHLD, before);
  EXPECT_EQ(survived, (std::array{true, false, true, false}));
}

// Nobody writes into the pipe: the trial would wait for its 20 s.
TEST_F(SliceTrial, CancellingEndsItSoon) {
  const auto pipe = folder_.path() / "a.png";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  int asked = 0;
  const auto begin = std::chrono::steady_clock::now();
  const auto result = survivesReading({pipe}, VolumeFormat::kPng, kMost, [&](double, auto) { return ++asked < 3; });
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, Error::Code::kCancelled);
  EXPECT_EQ(asked, 3);
  EXPECT_LT(took.count(), 10);
}

}  // namespace
}  // namespace kerf::internal
