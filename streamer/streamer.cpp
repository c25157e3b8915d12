// SPDX-License-Identifier: Apache-2.0
#include "streamer/streamer.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <iterator>
#include <limits>
#include <string>
#include <utility>

#include "base/check.h"
#include "streamer/paging/ledger.h"
#include "streamer/paging/load_workers.h"
#include "streamer/paging/memory_plan.h"
#include "streamer/paging/page_loader.h"
#include "streamer/paging/page_pool.h"
#include "streamer/paging/pager_state.h"
#include "streamer/paging/shown_pages.h"
#include "streamer/paging/zeroed_array.h"
#include "streamer/source/index_file.h"
#include "streamer/source/retry.h"
#include "streamer/statistics/camera_cuts.h"
#include "streamer/statistics/event_log.h"
#include "streamer/statistics/latency_samples.h"
#include "streamer/statistics/prefetch_account.h"

namespace zc {
namespace {

// The least loss is at the front of a std::*_heap.
bool worse_eviction(const Eviction& a, const Eviction& b) {
  return a.loss != b.loss ? a.loss > b.loss : a.node < b.node;
}

// Causes of failures that are kept at once, so that a server's words take no memory without bound.
constexpr std::size_t kKeptCauses = 8;

}  // namespace

class Streamer::Impl {
 public:
  Impl(Source& source, PageSink& sink, const StreamerOptions& options, std::unique_ptr<Ledger> ledger,
       std::unique_ptr<HeldIndex> index, const MemoryPlan& plan)
      : source_(source),
        sink_(sink),
        options_(options),
        ledger_(std::move(ledger)),
        held_index_(std::move(index)),
        index_(held_index_->view()),
        plan_(plan),
        limits_(load_limits(plan, options.include_detail)),
        nodes_(index_.nodes.size()),
        marks_(index_.nodes.size()),
        pool_(index_, sink, plan.pool_bytes / 4, plan.pages),
        shown_(index_, pool_, options.tolerance, plan.pages),
        prefetch_(index_, plan.pages) {
    // Reserved to their largest, so that none ever grows beyond what the ledger counts.
    used_.reserve(plan.pages);
    evictions_.reserve(plan.pages);
    selection_.reserve(plan.pages);
    marked_.reserve(kSelectionNodesPerPage * plan.pages);
    loads_.reserve(options_.max_in_flight);
  }

  Status start() {
    reserve_fixed();
    ZC_TRY(sink_.create(plan_.pool_bytes / 4, plan_.pages));
    const NodeRecord root = index_.nodes[0];
    const std::optional<Reservation> compressed = ledger_->try_reserve(LedgerClass::kInFlight, compressed_bytes(root));
    const std::optional<Reservation> decoded = ledger_->try_reserve(LedgerClass::kDecoded, root.page_bytes);
    ZC_CHECK(compressed && decoded);
    ++stats_.requests.issued;
    events_.record(0, EventKind::kIssue, 0);
    ZC_ASSIGN(const std::vector<std::uint32_t> page, load_page(source_, index_, 0));
    ZC_TRY(make_resident(0, page));
    ++stats_.requests.completed;
    stats_.bytes_read += compressed_bytes(root);
    marks_[0] = kMarkSelected;
    marked_.assign(1, 0);
    ZC_TRY(show(ErrorMeter(index_, {})));
    blocks_read_by_opening_ = held_index_->blocks_read();
    workers_ = std::make_unique<LoadWorkers>(source_, index_.materials.size(),
                                             std::min(options_.threads, options_.max_in_flight), plan_.scratch_bytes);
    return {};
  }

  Status advance(std::span<const View> views, double time_s) try {
    return advance_frame(views, time_s);
  } catch (const IndexFault& fault) {
    return fault.error();
  }

  Status advance_frame(std::span<const View> views, double time_s) {
    ++frame_;
    time_s_ = time_s;
    error_of_.emplace(index_, views);
    error_now_.emplace(index_, views, true);
    stats_.frame = {};
    stats_.frame.time_s = time_s;
    evictions_valid_ = false;
    uploaded_bytes_ = 0;
    camera_cuts_.begin_frame(views, time_s);

    // With the previous selection still in force: what is in flight belongs to it, so there is room for it.
    bool any = false;
    ZC_TRY(complete(any));
    select(views);
    do {
      any = issue();
      ZC_TRY(complete(any));
    } while (any);
    ZC_TRY(show(*error_now_));
    report_frame();
    count_frame(views);
    return {};
  }

  [[nodiscard]] StreamerStatistics statistics() const {
    StreamerStatistics out = stats_;
    out.cap_bytes = options_.cap_bytes;
    out.pool_bytes = plan_.pool_bytes;
    out.buffer_limit_bytes = sink_.costs().buffer_limit_bytes;
    out.pool_limited_by_sink = plan_.pool_limited_by_sink;
    out.index_in_memory = held_index_->in_memory();
    out.index_blocks_read = held_index_->blocks_read() - blocks_read_by_opening_;
    out.ledger = ledger_->total();
    for (std::size_t c = 0; c < kLedgerClassCount; ++c)
      out.ledger_classes[c] = ledger_->use(static_cast<LedgerClass>(c));
    out.compactions = pool_.compactions();
    out.compacted_bytes = pool_.compacted_bytes();
    out.prefetch = prefetch_.bytes();
    out.camera_cuts = camera_cuts_.statistics();
    out.request_to_resident_ms = latencies_.summary();
    for (std::size_t s = 0; s < kLoadStateCount; ++s) out.state_ms[s] = states_[s].summary();
    out.event_log_xxh3 = events_.hash();
    out.failing = failing_nodes();
    return out;
  }

  void observe(PagingObserver& observer) { observers_.push_back(&observer); }

  [[nodiscard]] const IndexView& index() const { return index_; }
  [[nodiscard]] std::uint64_t pool_words() const { return plan_.pool_bytes / 4; }
  [[nodiscard]] const PagePool& pool() const { return pool_; }

 private:
  void reserve_fixed() {
    const std::array<std::pair<LedgerClass, std::uint64_t>, 5> parts = {{
        {LedgerClass::kIndex, plan_.index_bytes},
        {LedgerClass::kState, plan_.state_bytes},
        {LedgerClass::kTopLevel, plan_.top_level_bytes},
        {LedgerClass::kScratch, plan_.scratch_bytes},
        {LedgerClass::kPool, plan_.pool_bytes},
    }};
    for (const auto& [part, bytes] : parts) {
      std::optional<Reservation> reservation = ledger_->try_reserve(part, bytes);
      ZC_CHECK(reservation);  // the plan fits by construction
      fixed_.push_back(std::move(*reservation));
    }
  }

  void add_span(LoadState state, std::uint32_t node, unsigned worker, LoadWorkers::Time begin, LoadWorkers::Time end) {
    states_[static_cast<std::size_t>(state)].add(std::chrono::duration<double, std::milli>(end - begin).count());
    for (PagingObserver* observer : observers_) observer->on_span({state, node, worker, begin, end});
  }

  // What a worker did, and what came before it.
  void add_spans(const Load& load, const LoadWorkers::Loaded& loaded) {
    add_span(LoadState::kReserved, load.node, 0, load.issued_at, loaded.taken_at);
    add_span(LoadState::kReading, load.node, loaded.worker, loaded.taken_at, loaded.read_at);
    add_span(LoadState::kDecoding, load.node, loaded.worker, loaded.read_at, loaded.decoded_at);
  }

  // --- what should be resident ---

  [[nodiscard]] bool selected(std::uint32_t n) const { return (marks_[n] & kMarkSelected) != 0; }

  void select(std::span<const View> views) {
    const SelectionQuery query = {.views = views,
                                  .limits = limits_,
                                  .previous = marks_.view(),
                                  .cut = &pool_.nodes(),
                                  .budget_bytes = plan_.pool_bytes,
                                  .most_pages = plan_.pages,
                                  .tolerance = options_.tolerance};
    select_nodes(index_, query, selection_);
    mark_selection(selection_, marks_.view(), marked_);
    evictions_valid_ = false;
    cancel_unselected();
  }

  void cancel_unselected() {
    bool any = false;
    for (std::size_t i = 0; i < loads_.size();) {
      Load& load = loads_[i];
      NodeState& node = nodes_[load.node];
      if (selected(load.node) || node.phase != NodePhase::kLoading) {
        ++i;
        continue;
      }
      any = true;
      ++stats_.requests.cancelled;
      events_.record(frame_, EventKind::kCancel, load.node);
      load.cancelled_at = std::chrono::steady_clock::now();
      const bool removed = workers_->cancel(load.ticket);
      if (options_.clock == ClockKind::kVirtual) {
        stats_.bytes_read += received_bytes(load);
      } else if (!removed) {
        node.phase = NodePhase::kDraining;
        ++i;
        continue;
      }
      // Under the virtual clock what a worker happens to have begun must not show: wait for it, then drop it.
      if (!removed) retire(load, workers_->take(load.ticket));
      node.phase = NodePhase::kAbsent;
      loads_.erase(loads_.begin() + static_cast<std::ptrdiff_t>(i));
    }
    if (any && options_.clock == ClockKind::kVirtual) reschedule();
  }

  void retire(const Load& load, const LoadWorkers::Loaded& loaded) {
    add_spans(load, loaded);
    add_span(LoadState::kRetiring, load.node, 0, load.cancelled_at,
             std::max(load.cancelled_at, std::chrono::steady_clock::now()));
  }

  // --- requests ---

  // Issues what is selected and absent, the most needed first, as far as requests and bytes allow.
  bool issue() {
    bool any = false;
    for (const std::uint32_t n : selection_.by_priority) {
      if (loads_.size() >= std::max(options_.max_in_flight, 1U)) break;
      NodeState& node = nodes_[n];
      if (node.phase != NodePhase::kAbsent || node.retry_at_s > time_s_) continue;
      const NodeRecord record = index_.nodes[n];
      std::optional<Reservation> compressed = ledger_->try_reserve(LedgerClass::kInFlight, compressed_bytes(record));
      if (!compressed) break;  // in strict order, so that a large page is not passed over for ever
      std::optional<Reservation> decoded = ledger_->try_reserve(LedgerClass::kDecoded, record.page_bytes);
      if (!decoded) break;

      Load load;
      load.ticket = next_ticket_++;
      load.node = n;
      load.issued_s = time_s_;
      load.issued_at = std::chrono::steady_clock::now();
      load.compressed = std::move(*compressed);
      load.decoded = std::move(*decoded);
      schedule(load);
      workers_->submit(load.ticket, record);
      loads_.push_back(std::move(load));
      node.phase = NodePhase::kLoading;
      node.prefetched = prefetch_.asked_for(n, *error_now_, options_.tolerance) ? 0 : 1;
      any = true;
      ++stats_.requests.issued;
      if (node.failures > 0) ++stats_.requests.retried;
      events_.record(frame_, node.failures > 0 ? EventKind::kRetry : EventKind::kIssue, n);
      stats_.max_in_flight = std::max(stats_.max_in_flight, static_cast<std::uint32_t>(loads_.size()));
    }
    return any;
  }

  // One link that carries one request after the other.
  void schedule(Load& load) {
    const double bandwidth = options_.source_bandwidth_bytes_per_s;
    const auto bytes = static_cast<double>(compressed_bytes(index_.nodes[load.node]));
    load.start_s = std::max(time_s_, link_free_s_);
    load.end_s = load.start_s + (bandwidth > 0 ? bytes / bandwidth : 0.0);
    link_free_s_ = load.end_s;
  }

  // After some have left the link: those that were not on it yet move up.
  void reschedule() {
    link_free_s_ = time_s_;
    for (const Load& load : loads_)
      if (load.start_s < time_s_) link_free_s_ = std::max(link_free_s_, load.end_s);
    for (Load& load : loads_)
      if (load.start_s >= time_s_) schedule(load);
  }

  [[nodiscard]] double done_s(const Load& load) const { return load.end_s + options_.source_latency_s; }

  // By now, of the modelled link.
  [[nodiscard]] std::uint64_t received_bytes(const Load& load) const {
    const std::uint64_t bytes = compressed_bytes(index_.nodes[load.node]);
    const double since_s = time_s_ - options_.source_latency_s - load.start_s;
    if (!(since_s > 0)) return 0;
    const double takes_s = load.end_s - load.start_s;
    if (since_s >= takes_s) return bytes;
    return static_cast<std::uint64_t>(static_cast<double>(bytes) * since_s / takes_s);
  }

  // Takes every result that is due and within the frame's uploads; `any` becomes true when there was one.
  Status complete(bool& any) {
    if (options_.clock == ClockKind::kVirtual) {
      std::vector<std::pair<double, std::uint64_t>> due;  // at most max_in_flight
      for (const Load& load : loads_)
        if (options_.settle || done_s(load) <= time_s_) due.emplace_back(done_s(load), load.ticket);
      // Tickets rise with the modelled link's order, so they break ties.
      std::sort(due.begin(), due.end());
      for (const auto& [done_s, ticket] : due) {
        if (!may_upload(ticket)) break;
        ZC_TRY(finish(ticket));
        any = true;
      }
      return {};
    }
    do {
      for (const std::uint64_t ticket : workers_->done(options_.settle && !loads_.empty())) {
        if (!may_upload(ticket)) break;
        ZC_TRY(finish(ticket));
        any = true;
      }
    } while (options_.settle && !loads_.empty());
    return {};
  }

  [[nodiscard]] std::vector<Load>::iterator find_load(std::uint64_t ticket) {
    const auto found = std::find_if(loads_.begin(), loads_.end(), [&](const Load& l) { return l.ticket == ticket; });
    ZC_CHECK(found != loads_.end());
    return found;
  }

  // The first page of a frame always may, so that a page larger than the budget does not wait for ever.
  [[nodiscard]] bool may_upload(std::uint64_t ticket) {
    const std::uint64_t budget = options_.upload_bytes_per_frame;
    const Load& load = *find_load(ticket);
    return budget == 0 || options_.settle || uploaded_bytes_ == 0 || nodes_[load.node].phase == NodePhase::kDraining ||
           uploaded_bytes_ + index_.nodes[load.node].page_bytes <= budget;
  }

  Status finish(std::uint64_t ticket) {
    const LoadWorkers::Loaded loaded = workers_->take(ticket);
    const auto found = find_load(ticket);
    const Load load = std::move(*found);
    loads_.erase(found);
    NodeState& node = nodes_[load.node];
    stats_.bytes_read += compressed_bytes(index_.nodes[load.node]);
    if (node.phase == NodePhase::kDraining) {
      retire(load, loaded);
      node.phase = NodePhase::kAbsent;
      return {};
    }
    add_spans(load, loaded);
    if (!loaded.page.ok()) {
      fail(load.node, loaded.page.error());
      return {};
    }
    ++stats_.requests.completed;
    ++stats_.frame.loads;
    node.failures = 0;
    latencies_.add(latency_ms(load));
    return make_resident(load.node, *loaded.page);
  }

  [[nodiscard]] double latency_ms(const Load& load) const {
    if (options_.clock == ClockKind::kVirtual) return 1e3 * (std::max(time_s_, done_s(load)) - load.issued_s);
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - load.issued_at).count();
  }

  void fail(std::uint32_t n, const Error& error) {
    NodeState& node = nodes_[n];
    node.phase = NodePhase::kAbsent;
    if (node.failures < std::numeric_limits<std::uint16_t>::max()) ++node.failures;
    node.retry_at_s = time_s_ + std::max(retry_delay_s(node.failures), error.retry_after_s);
    ++stats_.requests.failed;
    events_.record(frame_, EventKind::kFail, n);
    keep_cause(n, error);
    if (node.failed_before != 0) return;
    node.failed_before = 1;
    ++stats_.failed_nodes;
    if (options_.on_failure) options_.on_failure(error);
  }

  [[nodiscard]] bool is_failing(std::uint32_t n) const {
    return nodes_[n].failures > 0 && selected(n) && !pool_.nodes().covered(n);
  }

  void keep_cause(std::uint32_t n, const Error& error) {
    std::erase_if(causes_, [&](const auto& kept) { return kept.first == n || !is_failing(kept.first); });
    if (causes_.size() < kKeptCauses) causes_.emplace_back(n, error);
  }

  [[nodiscard]] FailingNodes failing_nodes() const {
    FailingNodes out;
    for (const std::uint32_t n : selection_.nodes) out.count += is_failing(n) ? 1 : 0;
    const auto kept = std::ranges::find_if(causes_, [&](const auto& one) { return is_failing(one.first); });
    if (kept != causes_.end()) out.cause = kept->second;
    return out;
  }

  // --- the pool ---

  Status make_resident(std::uint32_t n, const std::vector<std::uint32_t>& page) {
    const LoadWorkers::Time began = std::chrono::steady_clock::now();
    while (!pool_.has_room_for(n) || pool_.residents().size() == plan_.pages) evict_one();
    const std::uint64_t compactions = pool_.compactions();
    ZC_TRY(pool_.add(n, page));
    if (pool_.compactions() != compactions) events_.record(frame_, EventKind::kCompact, 0);
    add_span(LoadState::kUploading, n, 0, began, std::chrono::steady_clock::now());
    uploaded_bytes_ += index_.nodes[n].page_bytes;
    NodeState& node = nodes_[n];
    node.phase = NodePhase::kResident;
    if (node.prefetched != 0) prefetch_.loaded(n);
    ++stats_.zones_loaded;
    if (node.loaded_before != 0) {
      ++stats_.reloads;
      if (frame_ - node.evicted_frame <= kThrashFrames) ++stats_.thrash;
    }
    node.loaded_before = 1;
    events_.record(frame_, EventKind::kResident, n);
    return {};
  }

  // What is lost with a page: nothing where finer pages cover its ground, of which the one that the camera is the
  // furthest from asking for goes first; else the ground shows the nearest resident ancestor.
  [[nodiscard]] double loss_of(std::uint32_t n) const {
    const RenderedCut& pages = pool_.nodes();
    if (pages.refinable(n)) return -(*error_of_)(index_.nodes[n]).weighted;
    std::uint32_t shown = n;
    do shown = static_cast<std::uint32_t>(index_.nodes[shown].parent);
    while (!pages.resident(shown));
    return (*error_of_)(index_.nodes[shown]).weighted;
  }

  void push_eviction(std::uint32_t n) {
    evictions_.push_back({loss_of(n), n});
    std::push_heap(evictions_.begin(), evictions_.end(), worse_eviction);
  }

  // The selection fits the pool, so as long as a selected page lacks room, something unselected is resident.
  void evict_one() {
    if (!evictions_valid_) {
      evictions_.clear();
      for (const std::uint32_t n : pool_.residents())
        if (n != 0 && !selected(n)) push_eviction(n);
      evictions_valid_ = true;
    }
    std::uint32_t n = 0;
    while (n == 0) {
      ZC_CHECK(!evictions_.empty());
      std::pop_heap(evictions_.begin(), evictions_.end(), worse_eviction);
      const Eviction least = evictions_.back();
      evictions_.pop_back();
      // What went before may have made it a greater loss.
      if (loss_of(least.node) > least.loss)
        push_eviction(least.node);
      else
        n = least.node;
    }
    NodeState& node = nodes_[n];
    node.phase = NodePhase::kAbsent;
    node.evicted_frame = frame_;
    pool_.remove(n);
    if (node.prefetched != 0) prefetch_.evicted(n);
    ++stats_.zones_evicted;
    ++stats_.frame.evictions;
    events_.record(frame_, EventKind::kEvict, n);
  }

  Status show(const ErrorMeter& error_now) {
    pool_.update_rendered_cut();
    return shown_.update(error_now) ? sink_.show(shown_.pages()) : Status{};
  }

  // --- what is counted ---

  void report_frame() {
    if (observers_.empty()) return;
    used_.clear();
    std::copy_if(selection_.nodes.begin(), selection_.nodes.end(), std::back_inserter(used_),
                 [&](std::uint32_t n) { return pool_.nodes().resident(n); });
    for (PagingObserver* observer : observers_) observer->on_frame(used_);
  }

  void count_frame(std::span<const View> views) {
    const WantedCount wanted = count_wanted(index_, views, options_.tolerance, options_.include_detail, pool_.nodes());
    FrameStatistics& frame = stats_.frame;
    frame.resident_nodes = static_cast<std::uint32_t>(pool_.residents().size());
    frame.cover_nodes = static_cast<std::uint32_t>(pool_.rendered_cut().size());
    frame.selected_nodes = static_cast<std::uint32_t>(selection_.nodes.size());
    frame.wanted_nodes = wanted.nodes;
    frame.missing_nodes = wanted.missing;
    frame.in_flight = static_cast<std::uint32_t>(loads_.size());
    frame.ledger_bytes = ledger_->total().current_bytes;
    frame.resident_page_bytes = pool_.page_bytes();
    ++stats_.frames;
    if (frame.ledger_bytes > options_.cap_bytes) ++stats_.frames_over_cap;
    if (frame.missing_nodes == 0) ++stats_.wanted_level_frames;
    camera_cuts_.end_frame(frame.missing_nodes == 0);
    prefetch_.settle(*error_now_, options_.tolerance);
  }

  Source& source_;
  PageSink& sink_;
  const StreamerOptions options_;
  std::unique_ptr<Ledger> ledger_;  // before everything that keeps a reservation
  std::vector<Reservation> fixed_;
  const std::unique_ptr<HeldIndex> held_index_;
  const IndexView index_;
  std::uint64_t blocks_read_by_opening_ = 0;
  const MemoryPlan plan_;
  const LoadLimits limits_;

  ZeroedArray<NodeState> nodes_;
  ZeroedArray<std::uint8_t> marks_;  // the selection's, and which nodes have any
  std::vector<std::uint32_t> marked_;
  Selection selection_;
  PagePool pool_;
  ShownPages shown_;
  std::vector<Eviction> evictions_;
  bool evictions_valid_ = false;

  std::vector<std::uint32_t> used_;

  std::uint32_t frame_ = 0;
  double time_s_ = 0;
  double link_free_s_ = 0;
  std::uint64_t uploaded_bytes_ = 0;  // in this frame
  std::optional<ErrorMeter> error_of_;
  std::optional<ErrorMeter> error_now_;
  std::vector<Load> loads_;
  std::vector<std::pair<std::uint32_t, Error>> causes_;  // of nodes that are failing, the first first
  std::uint64_t next_ticket_ = 1;

  std::vector<PagingObserver*> observers_;
  StreamerStatistics stats_;
  LatencySamples latencies_;
  std::array<LatencySamples, kLoadStateCount> states_;
  CameraCuts camera_cuts_;
  PrefetchAccount prefetch_;
  EventLog events_;
  std::unique_ptr<LoadWorkers> workers_;  // last: its threads stop first
};

Result<std::unique_ptr<Streamer>> Streamer::open(Source& source, const StreamerOptions& options, PageSink& sink) try {
  ZC_ASSIGN(std::unique_ptr<HeldIndex> held,
            HeldIndex::open(source, index_room_bytes(options.cap_bytes), index_limit_bytes(options.cap_bytes)));
  const IndexView index = held->view();
  ZC_ASSIGN(const MemoryPlan plan, plan_memory(index, options, source.costs(), sink.costs()));
  auto ledger = std::make_unique<Ledger>(options.cap_bytes);
  {
    // Both were there a moment ago: the plan has made sure that this is under the cap, and it shows in the peak.
    const std::optional<Reservation> opening =
        ledger->try_reserve(LedgerClass::kInFlight, opening_bytes(index, source.costs()));
    const std::optional<Reservation> kept = ledger->try_reserve(LedgerClass::kIndex, plan.index_bytes);
    ZC_CHECK(opening && kept);
  }
  auto impl = std::make_unique<Impl>(source, sink, options, std::move(ledger), std::move(held), plan);
  ZC_TRY(impl->start());
  return std::unique_ptr<Streamer>(new Streamer(std::move(impl)));
} catch (const IndexFault& fault) {
  return fault.error();
}

Streamer::Streamer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Streamer::~Streamer() = default;

Status Streamer::advance(std::span<const View> views, double time_s) { return impl_->advance(views, time_s); }
void Streamer::observe(PagingObserver& observer) { impl_->observe(observer); }
IndexView Streamer::index() const { return impl_->index(); }
std::uint64_t Streamer::pool_words() const { return impl_->pool_words(); }
std::span<const std::uint32_t> Streamer::rendered_cut() const { return impl_->pool().rendered_cut(); }
std::uint64_t Streamer::rendered_cut_generation() const { return impl_->pool().rendered_cut_generation(); }
bool Streamer::resident(std::uint32_t node) const {
  return node < impl_->index().nodes.size() && impl_->pool().nodes().resident(node);
}
std::uint64_t Streamer::page_offset_words(std::uint32_t node) const { return impl_->pool().offset_words(node); }
StreamerStatistics Streamer::statistics() const { return impl_->statistics(); }

}  // namespace zc
