#include "storage/database_copy.hpp"

#include <bit>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "storage/blob_codec.hpp"
#include "storage/digest.hpp"
#include "storage/job_store.hpp"
#include "storage/map_store.hpp"
#include "storage/session_store.hpp"
#include "storage/token_store.hpp"

namespace cornerfix::storage {
namespace {

constexpr std::size_t kPerPage = 200;

/// SHA-256 over all fields of a row, one after the other.
class Fingerprint {
 public:
  void add(BlobView bytes) { chain_ = extend(chain_, bytes); }
  void add(std::string_view text) {
    add(BlobView(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
  }
  void add(std::uint64_t number) { add(std::string_view(std::to_string(number))); }
  /// A zero without its sign, which SQLite does not keep.
  void add(double number) { add(std::bit_cast<std::uint64_t>(number + 0.0)); }
  [[nodiscard]] const KeyFrameChain& value() const { return chain_; }

 private:
  KeyFrameChain chain_{};
};

KeyFrameChain fingerprint_of(const MapInfo& info, const MapArchive& source) {
  Fingerprint fingerprint;
  for (const std::string_view text : {std::string_view(info.name), std::string_view(info.created),
                                      std::string_view(info.updated)})
    fingerprint.add(text);
  fingerprint.add(std::string_view(info.revision_created));
  fingerprint.add(to_string(info.revision_origin));
  fingerprint.add(static_cast<std::uint64_t>(info.id));
  fingerprint.add(std::uint64_t{info.feature_count});
  const Bounds bounds = info.bounds.value_or(Bounds{});
  fingerprint.add(std::uint64_t{info.bounds ? 1U : 0U});
  for (const double bound : {bounds.min.x(), bounds.min.y(), bounds.max.x(), bounds.max.y()})
    fingerprint.add(bound);
  for (const std::string* text : {&source.description, &source.lidar_json, &source.parameters_json})
    fingerprint.add(std::string_view(*text));
  fingerprint.add(source.revision);
  fingerprint.add(std::uint64_t{source.drifts ? 1U : 0U});
  for (const double stamp : source.stamps) fingerprint.add(stamp);
  for (const PosedScan& key_frame : source.key_frames) fingerprint.add(encode_key_frame(key_frame));
  if (source.floor_map) fingerprint.add(hash_of(*source.floor_map));
  return fingerprint.value();
}

KeyFrameChain fingerprint_of(const SessionRecord& record) {
  Fingerprint fingerprint;
  for (const std::string* text : {&record.id, &record.robot, &record.created, &record.lidar_json,
                                  &record.options_json, &record.last_answer, &record.last_used})
    fingerprint.add(std::string_view(*text));
  fingerprint.add(static_cast<std::uint64_t>(record.number));
  fingerprint.add(record.expected_sequence);
  fingerprint.add(record.last_batch);
  for (std::size_t i = 0; i < record.maps.size(); ++i) {
    fingerprint.add(std::string_view(record.maps[i]));
    fingerprint.add(static_cast<std::uint64_t>(record.map_ids[i]));
  }
  for (const SubmapScanPtr& scan : record.state.submap) fingerprint.add(encode_submap_scan(*scan));
  fingerprint.add(encode_localizer_state(record.state, {}));
  return fingerprint.value();
}

KeyFrameChain fingerprint_of(const std::vector<TokenRecord>& tokens) {
  Fingerprint fingerprint;
  for (const TokenRecord& token : tokens) {
    fingerprint.add(static_cast<std::uint64_t>(token.id));
    for (const std::string* text : {&token.name, &token.role, &token.created, &token.expires})
      fingerprint.add(std::string_view(*text));
    for (const std::string& map : token.maps) fingerprint.add(std::string_view(map));
    fingerprint.add(token.hash);
  }
  return fingerprint.value();
}

Error differs(const std::string& what) {
  return Error{ErrorCode::kCorruptData, what + ": the copy differs from its source", ""};
}

Error has_changed(const std::string& what) {
  return Error{ErrorCode::kConflict,
               what +
                   " was changed during the copy: stop the servers, delete the target and copy "
                   "again",
               ""};
}

/// A copy in progress.
class Copy {
 public:
  Copy(const std::shared_ptr<Database>& from, const std::shared_ptr<Database>& to)
      : from_(*from),
        to_(*to),
        from_maps_(from),
        to_maps_(to),
        from_sessions_(from),
        to_sessions_(to),
        from_tokens_(from),
        to_tokens_(to),
        from_jobs_(from) {}

  Result<CopiedRows> run() {
    for (const auto step :
         {&Copy::check_jobs, &Copy::check_target, &Copy::copy_maps, &Copy::copy_sketches,
          &Copy::copy_sessions, &Copy::copy_tokens, &Copy::copy_ids}) {
      if (Result<void> done = (this->*step)(); !done) return done.error();
    }
    return copied_;
  }

 private:
  Result<void> check_jobs() {
    const auto jobs = from_jobs_.open_jobs();
    if (!jobs) return jobs.error();
    const std::size_t unfinished = jobs->queued + jobs->running.size();
    if (unfinished == 0) return {};
    return Error{ErrorCode::kConflict,
                 "the source has " + std::to_string(unfinished) +
                     " jobs that are not finished: let a server finish them, or cancel them",
                 from_.location()};
  }

  Result<void> check_target() {
    const auto maps = to_maps_.list("", 1);
    if (!maps) return maps.error();
    const auto sessions = to_sessions_.list({.limit = 1});
    if (!sessions) return sessions.error();
    const auto tokens = to_tokens_.list();
    if (!tokens) return tokens.error();
    if (maps->empty() && sessions->empty() && tokens->empty()) return {};
    return Error{ErrorCode::kConflict, "the target holds maps, sessions or tokens already",
                 to_.location()};
  }

  Result<void> copy_maps() {
    for (std::string after;;) {
      const auto page = from_maps_.list(after, kPerPage);
      if (!page) return page.error();
      for (const MapInfo& info : *page) {
        if (Result<void> done = copy_map(info); !done) return done;
      }
      if (page->size() < kPerPage) return {};
      after = page->back().name;
    }
  }

  Result<void> copy_map(const MapInfo& info) {
    const std::string what = "map " + info.name;
    const auto source = from_maps_.archive(info.name);
    if (!source) return source.error();
    if (source->revision != info.revision) return has_changed(what);
    const auto inserted = to_maps_.insert(info, *source);
    if (!inserted) return inserted.error();
    const auto stored = to_maps_.find(info.name);
    if (!stored) return stored.error();
    const auto copy = to_maps_.archive(info.name);
    if (!copy) return copy.error();
    const bool is_same = stored->digest == info.digest &&
                         fingerprint_of(*stored, *copy) == fingerprint_of(info, *source);
    if (!is_same) return differs(what);
    ++copied_.maps;
    if (Result<void> done = copy_revisions(info); !done) return done;
    return copy_content(info);
  }

  Result<void> copy_revisions(const MapInfo& info) {
    const std::string what = "map " + info.name;
    const auto revisions = from_maps_.revisions(info.name);
    if (!revisions) return revisions.error();
    if (revisions->front().revision != info.revision) return has_changed(what);
    for (const MapRevision& revision : std::span(*revisions).subspan(1)) {
      const auto archive = from_maps_.revision_archive(info.name, revision.revision);
      if (!archive) return archive.error();
      if (auto kept = to_maps_.insert_revision(info.id, revision, *archive); !kept) return kept;
      const auto copy = to_maps_.revision_archive(info.name, revision.revision);
      if (!copy) return copy.error();
      if (*copy != *archive) return differs(what);
    }
    return {};
  }

  /// What is derived from the map, so that the first robot does not wait for it.
  Result<void> copy_content(const MapInfo& info) {
    const auto content = from_maps_.content(info.id);
    if (!content) return content.error();
    if (!content->has_value() || (*content)->revision != info.revision) return {};
    return to_maps_.store_content(info.id, info.revision, (*content)->content);
  }

  Result<void> copy_sketches() {
    for (std::optional<std::int64_t> after = 0; after;) {
      const auto page = from_maps_.sketches(*after, kPerPage);
      if (!page) return page.error();
      for (const StoredSketch& one : page->sketches) {
        if (auto done = to_maps_.store_sketch(one.map_id, one.revision, one.sketch); !done)
          return done;
      }
      after = page->next;
    }
    return {};
  }

  Result<void> copy_sessions() {
    for (SessionPage page{.limit = kPerPage};;) {
      const auto listed = from_sessions_.list(page);
      if (!listed) return listed.error();
      for (const SessionRecord& record : *listed) {
        if (Result<void> done = copy_session(record.id); !done) return done;
      }
      if (listed->size() < kPerPage) return {};
      page.after = listed->back().number;
    }
  }

  Result<void> copy_session(const std::string& id) {
    const std::string what = "session " + id;
    const auto source = from_sessions_.find(id);
    if (!source) return source.error();
    if (!source->has_value()) return has_changed(what);
    if (Result<void> inserted = to_sessions_.insert(**source); !inserted) return inserted;
    const auto copy = to_sessions_.find(id);
    if (!copy) return copy.error();
    if (!copy->has_value() || fingerprint_of(**copy) != fingerprint_of(**source))
      return differs(what);
    ++copied_.sessions;
    return {};
  }

  Result<void> copy_tokens() {
    const auto source = from_tokens_.list();
    if (!source) return source.error();
    for (const TokenRecord& token : *source) {
      if (const auto inserted = to_tokens_.insert(token); !inserted) return inserted.error();
    }
    const auto copy = to_tokens_.list();
    if (!copy) return copy.error();
    if (fingerprint_of(*copy) != fingerprint_of(*source)) return differs("the tokens");
    copied_.tokens = source->size();
    return {};
  }

  /// So that the id of a map that was deleted before the copy never names another one.
  Result<void> copy_ids() {
    return guarded([&]() -> Result<void> {
      const LastIds ids = from_.last_ids();
      const auto transaction = to_.begin(Access::kWrite);
      to_.set_last_ids(ids);
      transaction->commit();
      return {};
    });
  }

  Database& from_;
  Database& to_;
  MapStore from_maps_;
  MapStore to_maps_;
  SessionStore from_sessions_;
  SessionStore to_sessions_;
  TokenStore from_tokens_;
  TokenStore to_tokens_;
  JobStore from_jobs_;
  CopiedRows copied_;
};

}  // namespace

Result<CopiedRows> copy_database(const std::shared_ptr<Database>& from,
                                 const std::shared_ptr<Database>& to) {
  return Copy(from, to).run();
}

}  // namespace cornerfix::storage
