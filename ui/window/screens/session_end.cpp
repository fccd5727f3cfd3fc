#include "ui/window/screens/session_end.h"

#include <chrono>
#include <csignal>
#include <thread>

#include "ui/app/document/jobs.h"
#include "ui/app/workbench/sessions.h"
#include "ui/app/workbench/strokes.h"

namespace kerf {
namespace {

volatile std::sig_atomic_t told_to_end = 0;

}  // namespace

void endWhenTold() {
  for (const int number : {SIGTERM, SIGINT, SIGHUP})
    if (std::signal(number, [](int signal) { told_to_end = signal; }) == SIG_IGN)
      std::signal(number, SIG_IGN);  // nohup, or in the background
}

int toldToEnd() { return told_to_end; }

Expected<void> endAll(Workbench& bench, LiveView& view) {
  const std::size_t seen = bench.notices->list().size();
  const auto wait = [&] {
    while (bench.jobs->running()) {
      if (!bench.jobs->isWriting()) bench.jobs->cancel();
      view.update(bench);
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  };
  bench.strokes->release();  // the hand lets the tool go
  wait();
  bench.sessions->close();
  wait();
  for (std::size_t n = seen; n < bench.notices->list().size(); ++n)
    if (bench.notices->list()[n].is_error)
      return fail(
          {.code = Error::Code::kWriteFailed, .place = "ending the session", .found = bench.notices->list()[n].text});
  return {};
}

}  // namespace kerf
