/// \file  How a revision of a map came about, and which former revisions are kept.
///
/// A change keeps the revision before it when somebody may want that one back:
/// - changes of settings, a trajectory, an occupancy map and a roll-back always keep it;
/// - scans keep it when they begin a mapping run: when the revision before came about otherwise, or
///   at least kMappingPauseS before. So a run of thousands of batches keeps one revision;
/// - a map without keyframes and grid is never kept.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <cornerfix/result.hpp>

namespace cornerfix::storage {

class MapTables;
struct MapRow;

enum class RevisionOrigin {
  kUnknown,  ///< Made by a program that did not store it.
  kSettings,
  kScans,
  kTrajectory,
  kOccupancyMap,
  kArchive,
  kRollBack,
};

/// As stored and sent: "scans". Empty for kUnknown.
[[nodiscard]] std::string_view to_string(RevisionOrigin origin);
/// kUnknown for a name that is not known.
[[nodiscard]] RevisionOrigin revision_origin_from(std::string_view name);

struct MapRevision {
  std::uint64_t revision = 0;
  std::string digest;
  std::string created;  ///< RFC 3339, UTC.
  RevisionOrigin origin = RevisionOrigin::kUnknown;
  std::size_t feature_count = 0;
  std::uint64_t archive_bytes = 0;  ///< Of the kept archive; 0 for the present revision.
};

inline constexpr std::size_t kDefaultKeptRevisions = 3;
inline constexpr std::int64_t kMappingPauseS = 600;
/// A larger archive is not kept: a column of either engine holds 1 GB, and memory is needed twice.
inline constexpr std::size_t kMaxKeptArchiveBytes = std::size_t{256} << 20U;

/// What makes a new revision, and when.
struct RevisionChange {
  RevisionOrigin origin = RevisionOrigin::kUnknown;
  std::string_view now;  ///< RFC 3339, UTC.
};

/// From `begin` to `end`; nothing when one is not "2000-01-01T00:00:00Z".
[[nodiscard]] std::optional<std::int64_t> seconds_between(std::string_view begin,
                                                          std::string_view end);

/// To be called before the rows of `map` change: keeps it if the rule above says so, and removes
/// the oldest kept revisions beyond `limit`. Throws as the tables do.
[[nodiscard]] Result<void> keep_revision(MapTables& maps, const MapRow& map,
                                         const RevisionChange& change, std::size_t limit);

}  // namespace cornerfix::storage
