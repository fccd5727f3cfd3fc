#include "ui/app/document/jobs.h"

namespace kerf {

void Jobs::cancel() {
  if (job_) job_->cancel();
}

bool Jobs::isBusy() {
  if (!job_) return false;
  notices_.complain({.code = Error::Code::kUnsupported,
                     .found = "a job is running: " + job_->status().title,
                     .hint = "wait for it, or cancel it"});
  return true;
}

void Jobs::then(std::function<void()> next) {
  if (!job_) return;
  when_over_ = [first = std::move(when_over_), next = std::move(next)] {
    first();
    next();
  };
}

void Jobs::abandon() {
  job_.reset();
  when_over_ = {};
}

void Jobs::update() {
  if (!job_ || !job_->isOver()) return;
  const auto over = std::move(job_);  // the next lines may start another job
  const auto done = std::exchange(when_over_, {});
  if (done) done();
}

}  // namespace kerf
