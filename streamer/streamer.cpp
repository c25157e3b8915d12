// SPDX-License-Identifier: Apache-2.0
#include "streamer/streamer.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <iterator>
#include <string>
#include <utility>

#include "base/check.h"
#include "streamer/belady.h"
#include "streamer/cover.h"
#include "streamer/event_log.h"
#include "streamer/latency_samples.h"
#include "streamer/ledger.h"
#include "streamer/load_workers.h"
#include "streamer/memory_plan.h"
#include "streamer/page_loader.h"
#include "streamer/pager_state.h"
#include "streamer/pool_allocator.h"

namespace zc {
namespace {

constexpr std::uint64_t kIndexLimitBytes = 1ULL << 32U;

double retry_delay_s(std::uint32_t failures) {
  constexpr std::array<double, 3> kDelays = {0.1, 0.4, 1.6};
  return failures <= kDelays.size() ? kDelays[failures - 1] : 10.0;
}

// The least loss is at the front of a std::*_heap.
bool worse_eviction(const Eviction& a, const Eviction& b) {
  return a.loss != b.loss ? a.loss > b.loss : a.node < b.node;
}

}  // namespace

class Streamer::Impl {
 public:
  Impl(Source& source, PageSink& sink, const StreamerOptions& options, std::unique_ptr<Ledger> ledger, WorldIndex index,
       const MemoryPlan& plan)
      : source_(source),
        sink_(sink),
        options_(options),
        ledger_(std::move(ledger)),
        index_(std::move(index)),
        plan_(plan),
        pool_(plan.pool_bytes / 4),
        trace_(plan.trace_words) {
    const std::size_t count = index_.nodes.size();
    nodes_.resize(count);
    resident_.resize(count);
    selected_.resize(count);
    loadable_.resize(count);
    cover_scratch_.resize(count);
    // Reserved to their largest, so that none ever grows beyond what the ledger counts.
    for (std::vector<std::uint32_t>* list :
         {&residents_, &previous_nodes_, &cover_, &previous_cover_, &used_, &previous_used_, &selection_.by_priority,
          &selection_.nodes, &selection_.wanted})
      list->reserve(count);
    cover_offsets_.reserve(count);
    evictions_.reserve(count);
    selection_.heap.reserve(count);
    loads_.reserve(options_.max_in_flight);
    for (std::size_t n = 0; n < count; ++n) {
      const NodeRecord& node = index_.nodes[n];
      loadable_[n] = n == 0 || (pageable(node, options_.include_detail) && loadable(node, plan));
    }
  }

  Status start() {
    ZC_TRY(reserve_fixed());
    ZC_TRY(sink_.create(plan_.pool_bytes / 4));
    const NodeRecord& root = index_.nodes[0];
    const std::optional<Reservation> compressed = ledger_->try_reserve(LedgerClass::kInFlight, compressed_bytes(root));
    const std::optional<Reservation> decoded = ledger_->try_reserve(LedgerClass::kDecoded, root.page_bytes);
    ZC_CHECK(compressed && decoded);
    ++stats_.requests.issued;
    events_.record(0, EventKind::kIssue, 0);
    ZC_ASSIGN(const std::vector<std::uint32_t> page, load_page(source_, index_, 0));
    ZC_TRY(make_resident(0, page));
    ++stats_.requests.completed;
    stats_.bytes_read += compressed_bytes(root);
    selected_[0] = 1;
    previous_nodes_.assign(1, 0);
    update_cover();
    workers_ = std::make_unique<LoadWorkers>(source_, index_, options_.threads, plan_.scratch_bytes);
    return {};
  }

  Status advance(std::span<const View> views, double time_s) {
    ++frame_;
    time_s_ = time_s;
    views_ = views;
    stats_.frame = {};
    stats_.frame.time_s = time_s;
    evictions_valid_ = false;

    // With the previous selection still in force: what is in flight belongs to it, so there is room for it.
    bool any = false;
    ZC_TRY(complete(any));
    select();
    do {
      any = issue();
      ZC_TRY(complete(any));
    } while (any);
    update_cover();
    record_trace();
    views_ = {};
    count_frame();
    return {};
  }

  [[nodiscard]] StreamerStatistics statistics() const {
    StreamerStatistics out = stats_;
    out.cap_bytes = options_.cap_bytes;
    out.pool_bytes = plan_.pool_bytes;
    out.ledger = ledger_->total();
    for (std::size_t c = 0; c < kLedgerClassCount; ++c)
      out.ledger_classes[c] = ledger_->use(static_cast<LedgerClass>(c));
    out.request_to_resident_ms = latencies_.summary();
    out.event_log_xxh3 = events_.hash();
    return out;
  }

  [[nodiscard]] std::optional<std::uint64_t> reloads_optimal() const {
    if (!trace_.complete()) return std::nullopt;
    std::vector<std::uint64_t> bytes;
    bytes.reserve(index_.nodes.size());
    for (const NodeRecord& node : index_.nodes) bytes.push_back(pool_bytes(node));
    return belady_reloads(trace_.words(), bytes, plan_.pool_bytes);
  }

  [[nodiscard]] const WorldIndex& index() const { return index_; }
  [[nodiscard]] std::uint64_t pool_words() const { return plan_.pool_bytes / 4; }
  [[nodiscard]] std::span<const std::uint32_t> cover() const { return cover_; }
  [[nodiscard]] std::uint64_t cover_generation() const { return cover_generation_; }
  [[nodiscard]] bool resident(std::uint32_t node) const { return node < resident_.size() && resident_[node] != 0; }
  [[nodiscard]] std::uint64_t page_offset_words(std::uint32_t node) const {
    ZC_CHECK(resident(node));
    return nodes_[node].offset_words;
  }

 private:
  Status reserve_fixed() {
    const std::array<std::pair<LedgerClass, std::uint64_t>, 6> parts = {{
        {LedgerClass::kIndex, plan_.index_bytes},
        {LedgerClass::kState, plan_.state_bytes},
        {LedgerClass::kTopLevel, plan_.top_level_bytes},
        {LedgerClass::kTrace, plan_.trace_bytes},
        {LedgerClass::kScratch, plan_.scratch_bytes},
        {LedgerClass::kPool, plan_.pool_bytes},
    }};
    for (const auto& [part, bytes] : parts) {
      std::optional<Reservation> reservation = ledger_->try_reserve(part, bytes);
      ZC_CHECK(reservation);  // the plan fits by construction
      fixed_.push_back(std::move(*reservation));
    }
    return {};
  }

  [[nodiscard]] std::uint64_t page_words(std::uint32_t node) const { return index_.nodes[node].page_bytes / 4; }

  // --- what should be resident ---

  void select() {
    const SelectionQuery query = {.views = views_,
                                  .loadable = loadable_,
                                  .previous = selected_,
                                  .budget_bytes = plan_.pool_bytes,
                                  .tolerance = options_.tolerance,
                                  .include_detail = options_.include_detail};
    select_nodes(index_, query, selection_);
    for (const std::uint32_t node : previous_nodes_) selected_[node] = 0;
    for (const std::uint32_t node : selection_.nodes) selected_[node] = 1;
    previous_nodes_ = selection_.nodes;
    evictions_valid_ = false;
    cancel_unselected();
  }

  void cancel_unselected() {
    for (std::size_t i = 0; i < loads_.size();) {
      Load& load = loads_[i];
      NodeState& node = nodes_[load.node];
      if (selected_[load.node] != 0 || node.phase != NodePhase::kLoading) {
        ++i;
        continue;
      }
      ++stats_.requests.cancelled;
      events_.record(frame_, EventKind::kCancel, load.node);
      const bool removed = workers_->cancel(load.ticket);
      if (!removed && options_.clock == ClockKind::kWall) {
        node.phase = NodePhase::kDraining;
        ++i;
        continue;
      }
      // Under the virtual clock what a worker happens to have begun must not show: wait for it, then drop it.
      if (!removed) (void)workers_->take(load.ticket);
      node.phase = NodePhase::kAbsent;
      loads_.erase(loads_.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }

  // --- requests ---

  // Issues what is selected and absent, the most needed first, as far as requests and bytes allow.
  bool issue() {
    bool any = false;
    for (const std::uint32_t n : selection_.by_priority) {
      if (loads_.size() >= std::max(options_.max_in_flight, 1U)) break;
      NodeState& node = nodes_[n];
      if (node.phase != NodePhase::kAbsent || node.retry_at_s > time_s_) continue;
      const NodeRecord& record = index_.nodes[n];
      std::optional<Reservation> compressed = ledger_->try_reserve(LedgerClass::kInFlight, compressed_bytes(record));
      if (!compressed) break;  // in strict order, so that a large page is not passed over for ever
      std::optional<Reservation> decoded = ledger_->try_reserve(LedgerClass::kDecoded, record.page_bytes);
      if (!decoded) break;

      Load load;
      load.ticket = next_ticket_++;
      load.node = n;
      load.issued_s = time_s_;
      load.done_s = model_done_s(compressed_bytes(record));
      load.issued_at = std::chrono::steady_clock::now();
      load.compressed = std::move(*compressed);
      load.decoded = std::move(*decoded);
      workers_->submit(load.ticket, n);
      loads_.push_back(std::move(load));
      node.phase = NodePhase::kLoading;
      any = true;
      ++stats_.requests.issued;
      if (node.failures > 0) ++stats_.requests.retried;
      events_.record(frame_, node.failures > 0 ? EventKind::kRetry : EventKind::kIssue, n);
      stats_.max_in_flight = std::max(stats_.max_in_flight, static_cast<std::uint32_t>(loads_.size()));
    }
    return any;
  }

  // One link that carries one request after the other.
  double model_done_s(std::uint64_t bytes) {
    const double start_s = std::max(time_s_, link_free_s_);
    const double bandwidth = options_.source_bandwidth_bytes_per_s;
    link_free_s_ = start_s + (bandwidth > 0 ? static_cast<double>(bytes) / bandwidth : 0.0);
    return link_free_s_ + options_.source_latency_s;
  }

  // Takes every result that is due; `any` becomes true when there was one.
  Status complete(bool& any) {
    if (options_.clock == ClockKind::kVirtual) {
      std::vector<std::pair<double, std::uint64_t>> due;  // at most max_in_flight
      for (const Load& load : loads_)
        if (options_.settle || load.done_s <= time_s_) due.emplace_back(load.done_s, load.ticket);
      // Tickets rise with the modelled link's order, so they break ties.
      std::sort(due.begin(), due.end());
      for (const auto& [done_s, ticket] : due) ZC_TRY(finish(ticket));
      any = any || !due.empty();
      return {};
    }
    do {
      for (const std::uint64_t ticket : workers_->done(options_.settle && !loads_.empty())) {
        ZC_TRY(finish(ticket));
        any = true;
      }
    } while (options_.settle && !loads_.empty());
    return {};
  }

  Status finish(std::uint64_t ticket) {
    LoadWorkers::Page page = workers_->take(ticket);
    const auto found = std::find_if(loads_.begin(), loads_.end(), [&](const Load& l) { return l.ticket == ticket; });
    ZC_CHECK(found != loads_.end());
    const Load load = std::move(*found);
    loads_.erase(found);
    NodeState& node = nodes_[load.node];
    if (node.phase == NodePhase::kDraining) {
      node.phase = NodePhase::kAbsent;
      return {};
    }
    stats_.bytes_read += compressed_bytes(index_.nodes[load.node]);
    if (!page.ok()) {
      fail(load.node, page.error());
      return {};
    }
    ++stats_.requests.completed;
    ++stats_.frame.loads;
    node.failures = 0;
    latencies_.add(latency_ms(load));
    return make_resident(load.node, *page);
  }

  [[nodiscard]] double latency_ms(const Load& load) const {
    if (options_.clock == ClockKind::kVirtual) return 1e3 * (std::max(time_s_, load.done_s) - load.issued_s);
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - load.issued_at).count();
  }

  void fail(std::uint32_t n, const Error& error) {
    NodeState& node = nodes_[n];
    node.phase = NodePhase::kAbsent;
    ++node.failures;
    node.retry_at_s = time_s_ + retry_delay_s(node.failures);
    ++stats_.requests.failed;
    events_.record(frame_, EventKind::kFail, n);
    if (node.failed_before) return;
    node.failed_before = true;
    ++stats_.failed_nodes;
    if (options_.on_failure) options_.on_failure(error);
  }

  // --- the pool ---

  Status make_resident(std::uint32_t n, const std::vector<std::uint32_t>& page) {
    const std::uint64_t words = page_words(n);
    ZC_CHECK(page.size() == words);
    while (pool_.free_words() < aligned_words(words)) evict_one();
    std::optional<std::uint64_t> offset = pool_.allocate(words);
    if (!offset) {
      ZC_TRY(compact());
      offset = pool_.allocate(words);
    }
    ZC_CHECK(offset);
    ZC_TRY(sink_.upload(*offset, page));
    NodeState& node = nodes_[n];
    node.offset_words = *offset;
    node.phase = NodePhase::kResident;
    resident_[n] = 1;
    residents_.push_back(n);
    resident_bytes_ += index_.nodes[n].page_bytes;
    if (n > 0) ++nodes_[static_cast<std::size_t>(index_.nodes[n].parent)].resident_children;
    ++stats_.zones_loaded;
    if (node.loaded_before) ++stats_.reloads;
    node.loaded_before = true;
    pages_changed_ = true;
    events_.record(frame_, EventKind::kResident, n);
    return {};
  }

  void push_eviction(std::uint32_t n) {
    if (n == 0 || resident_[n] == 0 || selected_[n] != 0 || nodes_[n].resident_children > 0) return;
    evictions_.push_back({weighted_error(index_, static_cast<std::uint32_t>(index_.nodes[n].parent), views_), n});
    std::push_heap(evictions_.begin(), evictions_.end(), worse_eviction);
  }

  // The selection fits the pool, so as long as a selected page lacks room, something unselected is resident; and the
  // selection is closed under ancestors, so that something without resident children is, too.
  void evict_one() {
    if (!evictions_valid_) {
      evictions_.clear();
      for (const std::uint32_t n : residents_) push_eviction(n);
      evictions_valid_ = true;
    }
    ZC_CHECK(!evictions_.empty());
    std::pop_heap(evictions_.begin(), evictions_.end(), worse_eviction);
    const std::uint32_t n = evictions_.back().node;
    evictions_.pop_back();
    NodeState& node = nodes_[n];
    node.phase = NodePhase::kAbsent;
    resident_[n] = 0;
    residents_.erase(std::find(residents_.begin(), residents_.end(), n));
    resident_bytes_ -= index_.nodes[n].page_bytes;
    pool_.free(node.offset_words, page_words(n));
    const auto parent = static_cast<std::uint32_t>(index_.nodes[n].parent);
    if (--nodes_[parent].resident_children == 0) push_eviction(parent);
    ++stats_.zones_evicted;
    ++stats_.frame.evictions;
    pages_changed_ = true;
    events_.record(frame_, EventKind::kEvict, n);
  }

  // Slides every page down, lowest first, so that the free words are one hole.
  Status compact() {
    std::sort(residents_.begin(), residents_.end(),
              [&](std::uint32_t a, std::uint32_t b) { return nodes_[a].offset_words < nodes_[b].offset_words; });
    std::uint64_t end = 0;
    for (const std::uint32_t n : residents_) {
      NodeState& node = nodes_[n];
      if (node.offset_words != end) ZC_TRY(sink_.move(node.offset_words, end, page_words(n)));
      node.offset_words = end;
      end += aligned_words(page_words(n));
    }
    pool_.reset(end);
    ++stats_.compactions;
    pages_changed_ = true;
    events_.record(frame_, EventKind::kCompact, 0);
    return {};
  }

  // --- what is shown and counted ---

  void update_cover() {
    if (!std::exchange(pages_changed_, false)) return;
    std::swap(cover_, previous_cover_);
    compute_cover(index_, resident_, cover_scratch_, cover_);
    bool changed = cover_ != previous_cover_;
    cover_offsets_.resize(cover_.size());
    for (std::size_t i = 0; i < cover_.size(); ++i)
      if (const std::uint64_t offset = nodes_[cover_[i]].offset_words;
          std::exchange(cover_offsets_[i], offset) != offset)
        changed = true;
    if (changed) ++cover_generation_;
  }

  // What was selected and there: an optimal eviction would have had to serve the same, in the same pool.
  void record_trace() {
    std::swap(used_, previous_used_);
    used_.clear();
    std::copy_if(selection_.nodes.begin(), selection_.nodes.end(), std::back_inserter(used_),
                 [&](std::uint32_t n) { return resident_[n] != 0; });
    trace_.record(previous_used_, used_);
  }

  void count_frame() {
    FrameStatistics& frame = stats_.frame;
    frame.resident_nodes = static_cast<std::uint32_t>(residents_.size());
    frame.cover_nodes = static_cast<std::uint32_t>(cover_.size());
    frame.selected_nodes = static_cast<std::uint32_t>(selection_.nodes.size());
    frame.wanted_nodes = static_cast<std::uint32_t>(selection_.wanted.size());
    frame.missing_nodes = static_cast<std::uint32_t>(std::count_if(selection_.wanted.begin(), selection_.wanted.end(),
                                                                   [&](std::uint32_t n) { return resident_[n] == 0; }));
    frame.in_flight = static_cast<std::uint32_t>(loads_.size());
    frame.ledger_bytes = ledger_->total().current_bytes;
    frame.resident_page_bytes = resident_bytes_;
    ++stats_.frames;
    if (frame.ledger_bytes > options_.cap_bytes) ++stats_.frames_over_cap;
    if (frame.missing_nodes == 0) ++stats_.wanted_level_frames;
  }

  Source& source_;
  PageSink& sink_;
  const StreamerOptions options_;
  std::unique_ptr<Ledger> ledger_;  // before everything that holds a reservation
  std::vector<Reservation> fixed_;
  const WorldIndex index_;
  const MemoryPlan plan_;

  std::vector<NodeState> nodes_;
  std::vector<std::uint8_t> resident_;
  std::vector<std::uint8_t> selected_;
  std::vector<std::uint8_t> loadable_;
  std::vector<std::uint8_t> cover_scratch_;
  std::vector<std::uint32_t> residents_;
  std::vector<std::uint32_t> previous_nodes_;
  std::uint64_t resident_bytes_ = 0;
  Selection selection_;
  PoolAllocator pool_;
  std::vector<Eviction> evictions_;
  bool evictions_valid_ = false;
  bool pages_changed_ = false;

  std::vector<std::uint32_t> cover_;
  std::vector<std::uint32_t> previous_cover_;
  std::vector<std::uint64_t> cover_offsets_;
  std::uint64_t cover_generation_ = 0;
  std::vector<std::uint32_t> used_;
  std::vector<std::uint32_t> previous_used_;

  std::uint32_t frame_ = 0;
  double time_s_ = 0;
  double link_free_s_ = 0;
  std::span<const View> views_;
  std::vector<Load> loads_;
  std::uint64_t next_ticket_ = 1;

  StreamerStatistics stats_;
  LatencySamples latencies_;
  EventLog events_;
  SelectionTrace trace_;
  std::unique_ptr<LoadWorkers> workers_;  // last: its threads stop first
};

Result<std::unique_ptr<Streamer>> Streamer::open(Source& source, const StreamerOptions& options, PageSink& sink) {
  ZC_ASSIGN(std::vector<std::byte> file, source.read_all(kWorldIndexName, kIndexLimitBytes));
  ZC_ASSIGN(WorldIndex index, decode_world_index(file, kWorldIndexName));
  ZC_ASSIGN(const MemoryPlan plan, plan_memory(index, options));
  auto ledger = std::make_unique<Ledger>(options.cap_bytes);
  {
    // Both were held a moment ago: the plan has made sure that this is under the cap, and it shows in the peak.
    const std::optional<Reservation> raw = ledger->try_reserve(LedgerClass::kInFlight, file.size());
    const std::optional<Reservation> decoded = ledger->try_reserve(LedgerClass::kIndex, index.resident_bytes());
    ZC_CHECK(raw && decoded);
    file = std::vector<std::byte>();  // `= {}` would keep its memory
  }
  auto impl = std::make_unique<Impl>(source, sink, options, std::move(ledger), std::move(index), plan);
  ZC_TRY(impl->start());
  return std::unique_ptr<Streamer>(new Streamer(std::move(impl)));
}

Streamer::Streamer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Streamer::~Streamer() = default;

Status Streamer::advance(std::span<const View> views, double time_s) { return impl_->advance(views, time_s); }
const WorldIndex& Streamer::index() const { return impl_->index(); }
std::uint64_t Streamer::pool_words() const { return impl_->pool_words(); }
std::span<const std::uint32_t> Streamer::cover() const { return impl_->cover(); }
std::uint64_t Streamer::cover_generation() const { return impl_->cover_generation(); }
bool Streamer::resident(std::uint32_t node) const { return impl_->resident(node); }
std::uint64_t Streamer::page_offset_words(std::uint32_t node) const { return impl_->page_offset_words(node); }
StreamerStatistics Streamer::statistics() const { return impl_->statistics(); }
std::optional<std::uint64_t> Streamer::reloads_optimal() const { return impl_->reloads_optimal(); }

}  // namespace zc
