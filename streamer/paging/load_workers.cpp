// SPDX-License-Identifier: Apache-2.0
#include "streamer/paging/load_workers.h"

#include <algorithm>
#include <system_error>

#include "streamer/paging/page_loader.h"

namespace zc {

LoadWorkers::LoadWorkers(Source& source, std::size_t materials, unsigned threads, std::uint64_t scratch_bytes)
    : source_(source), materials_(materials), scratch_free_bytes_(scratch_bytes) {
  for (unsigned i = 0; i < std::max(threads, 1U); ++i) {
    try {
      threads_.emplace_back([this, i] { work(i); });
    } catch (const std::system_error&) {  // the system has no more: go on with fewer
      if (threads_.empty()) throw;
      break;
    }
  }
}

LoadWorkers::~LoadWorkers() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
    for (const auto& [ticket, files] : at_work_) files->cancel();
  }
  queued_.notify_all();
  threads_.clear();
}

void LoadWorkers::submit(std::uint64_t ticket, const NodeRecord& node) {
  std::unique_ptr<AsyncRead> files = source_.begin(page_files(node));
  {
    const std::lock_guard lock(mutex_);
    queue_.push_back({ticket, node, std::move(files)});
  }
  queued_.notify_one();
}

bool LoadWorkers::cancel(std::uint64_t ticket) {
  std::unique_ptr<AsyncRead> given_up;
  const std::lock_guard lock(mutex_);
  const auto job = std::find_if(queue_.begin(), queue_.end(), [&](const Job& j) { return j.ticket == ticket; });
  if (job == queue_.end()) {
    if (const auto work = at_work_.find(ticket); work != at_work_.end()) work->second->cancel();
    return false;
  }
  given_up = std::move(job->files);  // destroyed after the lock
  queue_.erase(job);
  return true;
}

LoadWorkers::Loaded LoadWorkers::take(std::uint64_t ticket) {
  std::unique_lock lock(mutex_);
  finished_.wait(lock, [&] { return results_.contains(ticket); });
  return std::move(results_.extract(ticket).mapped());
}

std::vector<std::uint64_t> LoadWorkers::done(bool wait) {
  std::unique_lock lock(mutex_);
  if (wait) finished_.wait(lock, [&] { return !results_.empty(); });
  std::vector<std::uint64_t> tickets;
  for (const auto& [ticket, loaded] : results_) tickets.push_back(ticket);
  return tickets;
}

void LoadWorkers::work(unsigned worker) {
  std::unique_lock lock(mutex_);
  while (true) {
    queued_.wait(lock, [&] { return stop_ || !queue_.empty(); });
    if (stop_) return;
    Job job = std::move(queue_.front());
    queue_.pop_front();
    at_work_.emplace(job.ticket, job.files.get());
    const std::uint64_t scratch = scratch_bytes(job.node);
    scratch_freed_.wait(lock, [&] { return scratch <= scratch_free_bytes_; });
    scratch_free_bytes_ -= scratch;
    lock.unlock();
    const Time taken_at = std::chrono::steady_clock::now();
    Time read_at = taken_at;
    Page page = load_page(*job.files, job.node, materials_, &read_at);
    const Time decoded_at = std::chrono::steady_clock::now();
    lock.lock();
    at_work_.erase(job.ticket);
    lock.unlock();
    job.files.reset();  // before the result reports that its bytes are free
    lock.lock();
    scratch_free_bytes_ += scratch;
    scratch_freed_.notify_all();
    results_.emplace(job.ticket, Loaded{std::move(page), worker, taken_at, read_at, decoded_at});
    finished_.notify_all();
  }
}

}  // namespace zc
