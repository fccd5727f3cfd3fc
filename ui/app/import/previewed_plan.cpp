#include "ui/app/import/previewed_plan.h"

#include <utility>

#include "geometry/base/available_memory.h"

namespace kerf {
namespace {

using std::chrono::steady_clock;

constexpr auto kSettlesAfter = std::chrono::milliseconds(300);  // a dragged slider does not start a job at each step

}  // namespace

PreviewedPlan::PreviewedPlan() : free_bytes_(static_cast<double>(internal::availableMemory())) {}

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
    if (is_preview_due_) return false;  // the choices have changed since
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
