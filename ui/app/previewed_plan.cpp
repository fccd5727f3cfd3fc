#include "ui/app/previewed_plan.h"

#include <fstream>
#include <utility>

namespace kerf {
namespace {

using std::chrono::steady_clock;

constexpr auto kSettlesAfter = std::chrono::milliseconds(300);  // a dragged slider is not followed step by step

// MemAvailable of Linux, bytes: what can be had without swapping. 0: not known.
double freeMemory() {
  std::ifstream in("/proc/meminfo");
  std::string name;
  double kilobytes = 0;
  while (in >> name >> kilobytes) {
    if (name == "MemAvailable:") return 1024 * kilobytes;
    in.ignore(100, '\n');
  }
  return 0;
}

}  // namespace

PreviewedPlan::PreviewedPlan() : free_bytes_(freeMemory()) {}

void PreviewedPlan::changed() {
  changed_at_ = steady_clock::now();
  is_preview_due_ = true;
  preview_.reset();
  preview_error_.reset();
  if (job_) job_->cancel();
}

void PreviewedPlan::startPreview() {
  if (job_) return;
  job_ = makePreview();
  if (!job_) return;
  is_preview_due_ = false;
  preview_.reset();
  preview_error_.reset();
}

void PreviewedPlan::cancelPreview() {
  is_preview_due_ = false;
  if (job_) job_->cancel();
}

void PreviewedPlan::suspendPreview() {
  if (!job_) return;
  job_->cancel();
  is_preview_due_ = true;
}

bool PreviewedPlan::update() {
  if (job_ && job_->isOver()) {
    auto done = job_->take();
    job_.reset();
    if (is_preview_due_) return false;  // of choices that were changed since
    if (done) {
      preview_s_ = done->seconds;
      preview_ = std::move(*done);
    } else if (done.error().code != Error::Code::kCancelled) {
      preview_error_ = std::move(done.error());
    }
    return true;
  }
  if (!job_ && is_preview_due_ && startsByItself() && steady_clock::now() - changed_at_ > kSettlesAfter) startPreview();
  return false;
}

}  // namespace kerf
