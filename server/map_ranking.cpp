#include "server/map_ranking.hpp"

#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <algorithm>
#include <exception>
#include <iterator>
#include <utility>

namespace cornerfix::server {

using storage::MapStore;
using storage::SketchPage;
using storage::SketchState;
using storage::StoredSketch;

namespace {

constexpr std::size_t kSketchesPerPage = 500;
constexpr std::size_t kFewSketches = 50;  // are read one by one
constexpr std::chrono::milliseconds kPollInterval{500};
constexpr int kSketchingNiceness = 5;

}  // namespace

MapRanking::MapRanking(std::shared_ptr<StoreAccess> stores, std::shared_ptr<MapLibrary> library,
                       MapRankingSettings settings)
    : stores_(std::move(stores)), library_(std::move(library)), settings_(std::move(settings)) {
  if (settings_.has_thread) worker_ = std::thread([this] { work(); });
}

MapRanking::~MapRanking() {
  {
    const std::lock_guard lock(worker_mutex_);
    is_closing_ = true;
  }
  closing_changed_.notify_all();
  if (worker_.joinable()) worker_.join();
}

storage::MapInfo MapRanking::info_of(MapKey key, const Entry& entry) {
  storage::MapInfo info;
  info.id = key;
  info.name = entry.name;
  info.revision = entry.revision;
  return info;
}

Result<void> MapRanking::refresh() {
  const std::lock_guard lock(refresh_mutex_);
  const auto epoch = stores_->epoch();
  if (!epoch) return epoch.error();
  if (epoch_ == *epoch) return {};
  if (auto read = read_changes(); !read) return read;
  epoch_ = *epoch;
  return {};
}

std::shared_lock<std::shared_mutex> MapRanking::reading() const {
  const std::lock_guard gate(gate_);
  return std::shared_lock(mutex_);
}

std::unique_lock<std::shared_mutex> MapRanking::writing() {
  const std::lock_guard gate(gate_);
  return std::unique_lock(mutex_);
}

/// With refresh_mutex_ held.
Result<void> MapRanking::read_changes() {
  auto states = stores_->with_map_entries([](MapStore& maps) { return maps.sketch_states(); });
  if (!states) return states.error();
  std::erase_if(*states, [](const SketchState& state) { return !state.has_content; });
  std::vector<MapKey> wanted;
  {
    const auto lock = reading();
    for (const SketchState& state : *states) {
      const auto known = sketched_.find(state.id);
      const bool is_known = known != sketched_.end() && known->second == state.revision;
      if (!is_known && state.sketch_revision == state.revision) wanted.push_back(state.id);
    }
  }
  auto sketches = read_sketches(wanted);
  if (!sketches) return sketches.error();
  take(std::move(*states), std::move(*sketches));
  return {};
}

Result<std::vector<StoredSketch>> MapRanking::read_sketches(const std::vector<MapKey>& wanted) {
  std::vector<StoredSketch> sketches;
  const auto read = [&](MapKey after, std::size_t limit) {
    auto page = stores_->with_map_entries(
        [&](MapStore& maps) -> Result<SketchPage> { return maps.sketches(after, limit); });
    if (page) std::ranges::move(page->sketches, std::back_inserter(sketches));
    return page;
  };
  if (wanted.size() <= kFewSketches) {
    for (const MapKey key : wanted) {
      if (auto page = read(key - 1, 1); !page) return page.error();
    }
    return sketches;
  }
  for (std::optional<MapKey> after = wanted.front() - 1; after;) {
    auto page = read(*after, kSketchesPerPage);
    if (!page) return page.error();
    after = page->next;
  }
  return sketches;
}

/// `states` are those of all maps with content.
void MapRanking::take(std::vector<SketchState> states, std::vector<StoredSketch> sketches) {
  const bool is_first = !epoch_;
  const Time now = is_first ? Time::min() : settings_.now();
  const auto lock = writing();
  std::map<MapKey, Entry> entries;
  for (SketchState& state : states)
    entries.emplace_hint(entries.end(), state.id, Entry{std::move(state.name), state.revision});
  if (entries != entries_) ++version_;
  for (const auto& [key, before] : entries_) {
    const auto entry = entries.find(key);
    if (entry != entries.end() && entry->second.revision == before.revision) continue;
    catalog_.erase(key);
    sketched_.erase(key);
    missing_.erase(key);
  }
  entries_ = std::move(entries);
  std::vector<std::pair<MapKey, MapSketch>> fresh;
  for (StoredSketch& stored : sketches) {
    const auto entry = entries_.find(stored.map_id);
    if (entry == entries_.end() || entry->second.revision != stored.revision) continue;
    if (!sketched_.try_emplace(stored.map_id, stored.revision).second) continue;
    fresh.emplace_back(stored.map_id, std::move(stored.sketch));
    missing_.erase(stored.map_id);
  }
  catalog_.put_all(std::move(fresh));
  for (const auto& [key, entry] : entries_) {
    if (!sketched_.contains(key)) missing_.try_emplace(key, Missing{.changed_at = now});
  }
}

bool MapRanking::make_next_sketch() {
  const Time latest = settings_.now() - settings_.quiet_time;
  std::optional<MapKey> key;
  Entry entry;
  {
    const auto lock = reading();
    const auto found = std::ranges::find_if(missing_, [&](const auto& one) {
      return !one.second.has_failed && one.second.changed_at <= latest;
    });
    if (found == missing_.end()) return false;
    key = found->first;
    entry = entries_.at(*key);
  }
  auto sketch = library_->make_sketch(info_of(*key, entry));
  const auto lock = writing();
  const auto missing = missing_.find(*key);
  if (missing == missing_.end() || entries_.at(*key) != entry) return true;  // It has changed.
  if (!sketch) {
    spdlog::warn("map {} has no sketch: {}", entry.name, sketch.error().message);
    missing->second.has_failed = true;
    return true;
  }
  catalog_.put(*key, std::move(*sketch));
  sketched_[*key] = entry.revision;
  missing_.erase(missing);
  return true;
}

std::uint64_t MapRanking::version() const {
  const auto lock = reading();
  return version_;
}

std::size_t MapRanking::size() const {
  const auto lock = reading();
  return entries_.size();
}

double MapRanking::free_area_m2() const {
  const auto lock = reading();
  return catalog_.free_area_m2();
}

MapRankingUse MapRanking::use() const {
  const auto lock = reading();
  return {.maps = entries_.size(), .sketches = catalog_.size(), .bytes = catalog_.bytes()};
}

std::vector<RankedMap> MapRanking::rank(const MapQuery& query) const {
  const auto lock = reading();
  const std::vector<RankedMap> by_sketch = catalog_.rank(query);
  const double best = by_sketch.empty() ? 0.0 : by_sketch.front().mean_weight;
  std::vector<RankedMap> ranked;
  ranked.reserve(missing_.size() + by_sketch.size());
  for (const auto& [key, missing] : missing_)
    ranked.push_back({.key = key, .mean_weight = best, .T_map_base_link = {}});
  std::ranges::copy(by_sketch, std::back_inserter(ranked));
  return ranked;
}

std::vector<MapKey> MapRanking::keys() const {
  const auto lock = reading();
  std::vector<MapKey> keys;
  keys.reserve(entries_.size());
  for (const auto& [key, entry] : entries_) keys.push_back(key);
  return keys;
}

std::optional<MapKey> MapRanking::find(std::string_view name) const {
  const auto lock = reading();
  for (const auto& [key, entry] : entries_) {
    if (entry.name == name) return key;
  }
  return std::nullopt;
}

std::optional<MapRanking::Entry> MapRanking::entry(MapKey key) const {
  const auto lock = reading();
  const auto found = entries_.find(key);
  return found == entries_.end() ? std::nullopt : std::optional(found->second);
}

void MapRanking::work() {
  setpriority(PRIO_PROCESS, 0, kSketchingNiceness);  // On Linux: of this thread.
  // The first look is due at once: robots that may be in any map wait for it.
  for (bool has_more = true;;) {
    std::unique_lock lock(worker_mutex_);
    const std::chrono::milliseconds pause = has_more ? std::chrono::milliseconds(0) : kPollInterval;
    if (closing_changed_.wait_for(lock, pause, [&] { return is_closing_; })) return;
    lock.unlock();
    has_more = false;
    try {
      // What keeps the store from being read is reported to those who ask for it.
      if (refresh()) has_more = make_next_sketch();
    } catch (const std::exception& exception) {
      spdlog::warn("the ranking of maps: {}", exception.what());
    }
  }
}

}  // namespace cornerfix::server
