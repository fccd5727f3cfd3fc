#include "ui/cli/interruption.h"

#include <cstddef>

namespace kerf::cli {
namespace {

constexpr std::array kSignals = {SIGINT, SIGTERM, SIGHUP};
volatile std::sig_atomic_t is_interrupted = 0;
void interrupt(int) { is_interrupted = 1; }

}  // namespace

Interruption::Interruption() {
  is_interrupted = 0;
  struct sigaction action {};
  action.sa_handler = interrupt;
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  for (std::size_t n = 0; n < kSignals.size(); ++n) sigaction(kSignals[n], &action, &before_[n]);
}

Interruption::~Interruption() {
  for (std::size_t n = 0; n < kSignals.size(); ++n) sigaction(kSignals[n], &before_[n], nullptr);
}

bool isInterrupted() { return is_interrupted != 0; }

}  // namespace kerf::cli
