// The serial arm: its lines, and an arm behind a pseudo-terminal.
#include "sim/device/serial_arm.h"

#include <fcntl.h>

#include <gtest/gtest.h>
#include <poll.h>
#include <stdlib.h>
#include <unistd.h>

#include <cmath>

#include "sim/device/woody_arm.h"
#include "tests/sim/device/force_scene.h"

namespace kerf {
namespace {

using namespace test;

TEST(SerialArm, LinesAreReadStrictly) {
  SerialLine line;
  ASSERT_TRUE(parseSerialLine("[3,1,-2,30000,0,0,0,0]", line));
  EXPECT_EQ(line.model, 3);
  EXPECT_EQ(line.counts, (std::array{1, -2, 30000, 0, 0, 0}));
  for (const char* bad :
       {"", "[", "[]", "3,1,2,3,0,0,0,0", "[3,1,2,3,0,0,0]", "[3,1,2,3,0,0,0,0,0]", "[3,1,2,3,0,0,0,0] ",
        "[3,1,,3,0,0,0,0]", "[3,1, 2,3,0,0,0,0]", "[3,1,2.5,3,0,0,0,0]", "[3,1,12345678901,3,0,0,0,0]"})
    EXPECT_FALSE(parseSerialLine(bad, line)) << bad;
  EXPECT_EQ(line.counts[2], 30000) << "as it was";

  std::array<char, 64> text{};
  EXPECT_EQ(std::string(text.data(), writeSerialLine({12.4, -3, 9999}, text)), "[12,-3,2000]\n");
  EXPECT_EQ(std::string(text.data(), writeSerialLine({std::nan(""), 0, 0}, text)), "[0,0,0]\n");
}

TEST(SerialArm, AnswersEachLineThroughAPort) {
  const int far = ::posix_openpt(O_RDWR | O_NOCTTY);
  ASSERT_GE(far, 0);
  ASSERT_EQ(::grantpt(far), 0);
  ASSERT_EQ(::unlockpt(far), 0);
  std::atomic<bool> is_off{false}, is_silent{false};
  std::mutex mutex;
  std::string heard, last;
  std::thread firmware([&] {
    std::array<char, 256> bytes{};
    while (!is_off) {
      pollfd waits{far, POLLIN, 0};
      if (::poll(&waits, 1, 5) <= 0 || !(waits.revents & POLLIN)) continue;
      const ssize_t size = ::read(far, bytes.data(), bytes.size());
      if (size <= 0) continue;
      const std::lock_guard lock(mutex);
      heard.append(bytes.data(), static_cast<std::size_t>(size));
      for (std::size_t end = heard.find('\n'); end != heard.npos; end = heard.find('\n')) {
        last = heard.substr(0, end);
        heard.erase(0, end + 1);
        constexpr std::string_view kAnswer = "[3,0,-3000,5000,0,0,0,0]\n";
        const bool is_told = is_silent || ::write(far, kAnswer.data(), kAnswer.size()) > 0;
        EXPECT_TRUE(is_told);
      }
    }
  });
  const auto said = [&] {
    const std::lock_guard lock(mutex);
    return last;
  };
  {
    auto opened =
        openArm(std::string("serial:") + ::ptsname(far), {.limits = {.force = 3, .rate = 500, .ramp_s = 0.1}});
    EXPECT_TRUE(opened) << opened.error().message();
    if (opened) {
      ForceArm& arm = *opened->arm;
      arm.enable(true);
      Pusher pusher(arm, {0, 0, 1});
      const Vec3d currents = woodyCurrents({}, woodyPose({}, {0, -3000, 5000, 0, 0, 0}).jacobian, {0, 0, 1});
      std::array<char, 64> text{};
      std::string expected(text.data(), writeSerialLine(currents, text));
      expected.pop_back();
      EXPECT_TRUE(until([&] { return said() == expected; })) << said() << " for " << expected;
      is_silent = true;
      EXPECT_LE(pusher.lastTakenAgeMs(), 1000 * ForceArm::kDeadMan);
      EXPECT_TRUE(until([&] { return said() == "[0,0,0]"; }));
      is_silent = false;
      EXPECT_TRUE(until([&] { return pusher.is_valid && said() == expected; })) << "it is asked again";
    }
  }
  EXPECT_TRUE(until([&] { return said() == "[0,0,0]"; })) << "no current at the end";
  is_off = true;
  firmware.join();
  ::close(far);
  const auto none = openArm("serial:/dev/null", {});
  EXPECT_FALSE(none);
}

}  // namespace
}  // namespace kerf
