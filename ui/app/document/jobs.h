// Messages to the user, and the one long job that runs at a time. Window thread only.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "geometry/base/error.h"
#include "ui/app/base/job.h"
#include "ui/app/document/part.h"

namespace kerf {

/// A message for the user, shown until dismissed.
struct Notice {
  bool is_error = false;
  std::string text;
};

class Notices {
 public:
  const std::vector<Notice>& list() const { return list_; }
  void say(std::string text) { list_.push_back({false, std::move(text)}); }
  /// Adds an error. A cancel by the user is no error.
  void complain(const Error& error) { list_.push_back({error.code != Error::Code::kCancelled, error.message()}); }
  void add(Notice notice) { list_.push_back(std::move(notice)); }

 private:
  std::vector<Notice> list_;
};

class Jobs final : public Part {
 public:
  explicit Jobs(Notices& notices) : notices_(notices) {}

  /// The running job, or null. Meanwhile Kerf rejects open, export and close with a notice.
  const AnyJob* running() const { return job_.get(); }
  void cancel();
  /// The job writes a file for the user: the program waits for it before it ends.
  bool isWriting() const { return job_ && is_writing_; }
  /// As running(), and says so in a notice.
  bool isBusy();

  enum class Kind { kReads, kWrites };
  /// Starts a job. No other one may run.
  /// @param take  gets its result, in an update().
  template <class T>
  void start(Kind kind, std::string title, typename Job<T>::Work work, std::function<void(Expected<T>)> take,
             bool can_be_cancelled = true) {
    auto job = std::make_unique<Job<T>>(std::move(title), std::move(work), can_be_cancelled);
    when_over_ = [job = job.get(), take = std::move(take)] { take(job->take()); };
    is_writing_ = kind == Kind::kWrites;
    job_ = std::move(job);
  }
  /// Calls `next` after the running job's `take`. Without a job: never.
  void then(std::function<void()> next);
  /// Cancels the job, waits for it, and drops its result.
  void abandon();

  void update() override;

 private:
  Notices& notices_;
  std::unique_ptr<AnyJob> job_;
  std::function<void()> when_over_;  // takes the job's result
  bool is_writing_ = false;
};

}  // namespace kerf
