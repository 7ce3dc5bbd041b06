#include "storage/sqlite/schema.hpp"

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Transaction.h>

#include <array>
#include <string>

namespace cornerfix::storage {
namespace {

constexpr const char* kCreateTables = R"sql(
-- AUTOINCREMENT: the id of a deleted map never names another one.
CREATE TABLE maps (
  id              INTEGER PRIMARY KEY AUTOINCREMENT,
  name            TEXT    NOT NULL UNIQUE,
  description     TEXT    NOT NULL,
  revision        INTEGER NOT NULL,
  digest          TEXT    NOT NULL,
  key_frame_chain BLOB    NOT NULL,
  key_frame_count INTEGER NOT NULL,
  feature_count   INTEGER NOT NULL,
  min_x           REAL,
  min_y           REAL,
  max_x           REAL,
  max_y           REAL,
  created         TEXT    NOT NULL,
  updated         TEXT    NOT NULL,
  lidar_json      TEXT    NOT NULL,
  parameters_json TEXT    NOT NULL
) STRICT;

CREATE TABLE key_frames (
  id      INTEGER PRIMARY KEY,
  map_id  INTEGER NOT NULL REFERENCES maps (id) ON DELETE CASCADE,
  ordinal INTEGER NOT NULL,
  scan    BLOB    NOT NULL,
  UNIQUE (map_id, ordinal)
) STRICT;

CREATE TABLE map_stamps (
  map_id INTEGER NOT NULL REFERENCES maps (id) ON DELETE CASCADE,
  stamp  REAL    NOT NULL,
  PRIMARY KEY (map_id, stamp)
) STRICT, WITHOUT ROWID;

CREATE TABLE map_contents (
  map_id      INTEGER PRIMARY KEY REFERENCES maps (id) ON DELETE CASCADE,
  revision    INTEGER NOT NULL,
  features    BLOB    NOT NULL,
  descriptors BLOB    NOT NULL,
  grid        BLOB    NOT NULL
) STRICT;

CREATE TABLE sessions (
  number            INTEGER PRIMARY KEY AUTOINCREMENT,
  id                TEXT    NOT NULL UNIQUE,
  robot             TEXT    NOT NULL,
  created           TEXT    NOT NULL,
  lidar_json        TEXT    NOT NULL,
  options_json      TEXT    NOT NULL,
  expected_sequence INTEGER NOT NULL,
  last_answer       TEXT    NOT NULL,
  state             BLOB    NOT NULL
) STRICT;

CREATE TABLE session_maps (
  session INTEGER NOT NULL REFERENCES sessions (number) ON DELETE CASCADE,
  ordinal INTEGER NOT NULL,
  map     TEXT    NOT NULL,
  PRIMARY KEY (session, ordinal)
) STRICT, WITHOUT ROWID;

-- WITHOUT ROWID: one tree to write instead of two, on the path of every batch of scans.
CREATE TABLE submap_scans (
  session    INTEGER NOT NULL REFERENCES sessions (number) ON DELETE CASCADE,
  scan_index INTEGER NOT NULL,
  scan       BLOB    NOT NULL,
  PRIMARY KEY (session, scan_index)
) STRICT, WITHOUT ROWID;
)sql";

// The source of a map that was made from an occupancy map instead of scans.
constexpr const char* kCreateMapGrids = R"sql(
CREATE TABLE map_grids (
  map_id INTEGER PRIMARY KEY REFERENCES maps (id) ON DELETE CASCADE,
  grid   BLOB    NOT NULL
) STRICT;
)sql";

// Whether the keyframes stand where lidar odometry put them.
constexpr const char* kAddDrift = R"sql(
ALTER TABLE maps ADD COLUMN drifts INTEGER NOT NULL DEFAULT 0;
)sql";

// What a session knows beside what it was asked for; 0 where that is not known.
constexpr const char* kRememberMapsAndBeams = R"sql(
ALTER TABLE session_maps ADD COLUMN map_id INTEGER NOT NULL DEFAULT 0;
ALTER TABLE sessions ADD COLUMN beams INTEGER NOT NULL DEFAULT 0;
)sql";

// When a session took its last batch, or was made: those that are not used expire.
constexpr const char* kRememberUse = R"sql(
ALTER TABLE sessions ADD COLUMN last_used TEXT NOT NULL DEFAULT '';
UPDATE sessions SET last_used = created;
CREATE INDEX sessions_by_robot ON sessions (robot);
CREATE INDEX sessions_by_use ON sessions (last_used);
)sql";

// Digest of the batch that last_answer answers; 0 where that is not known.
constexpr const char* kRememberBatch = R"sql(
ALTER TABLE sessions ADD COLUMN last_batch INTEGER NOT NULL DEFAULT 0;
)sql";

// Who may call, by the SHA-256 of a token. `maps` are names with blanks between them; none: all.
constexpr const char* kCreateTokens = R"sql(
CREATE TABLE tokens (
  id      INTEGER PRIMARY KEY AUTOINCREMENT,
  name    TEXT NOT NULL,
  role    TEXT NOT NULL,
  maps    TEXT NOT NULL,
  hash    BLOB NOT NULL UNIQUE,
  created TEXT NOT NULL,
  expires TEXT NOT NULL
) STRICT;
)sql";

// Long work that waits or is being done, and for a time what came of it. The inputs are apart, so
// that a heartbeat does not write them anew.
constexpr const char* kCreateJobs = R"sql(
CREATE TABLE jobs (
  number     INTEGER PRIMARY KEY AUTOINCREMENT,
  id         TEXT    NOT NULL UNIQUE,
  kind       TEXT    NOT NULL,
  map        TEXT    NOT NULL,
  status     TEXT    NOT NULL DEFAULT 'queued',
  stage      TEXT    NOT NULL DEFAULT '',
  progress   REAL    NOT NULL DEFAULT 0,
  created    TEXT    NOT NULL,
  started    TEXT    NOT NULL DEFAULT '',
  finished   TEXT    NOT NULL DEFAULT '',
  problem    TEXT    NOT NULL DEFAULT '',
  cancelling INTEGER NOT NULL DEFAULT 0,
  attempts   INTEGER NOT NULL DEFAULT 0,
  holder     TEXT    NOT NULL DEFAULT '',
  heartbeat  INTEGER NOT NULL DEFAULT 0,
  answer     TEXT    NOT NULL DEFAULT ''
) STRICT;

CREATE TABLE job_inputs (
  job     INTEGER NOT NULL REFERENCES jobs (number) ON DELETE CASCADE,
  name    TEXT    NOT NULL,
  content BLOB    NOT NULL,
  PRIMARY KEY (job, name)
) STRICT;
)sql";

// When the present revision was made and how ('' where that is not known), and former revisions as
// map archives.
constexpr const char* kKeepRevisions = R"sql(
ALTER TABLE maps ADD COLUMN revision_created TEXT NOT NULL DEFAULT '';
ALTER TABLE maps ADD COLUMN revision_origin TEXT NOT NULL DEFAULT '';
UPDATE maps SET revision_created = updated;

CREATE TABLE map_revisions (
  id            INTEGER PRIMARY KEY,
  map_id        INTEGER NOT NULL REFERENCES maps (id) ON DELETE CASCADE,
  revision      INTEGER NOT NULL,
  digest        TEXT    NOT NULL,
  created       TEXT    NOT NULL,
  origin        TEXT    NOT NULL,
  feature_count INTEGER NOT NULL,
  archive       BLOB    NOT NULL,
  UNIQUE (map_id, revision)
) STRICT;
)sql";

// What ranks a map without loading it, with the revision it was made from.
constexpr const char* kCreateMapSketches = R"sql(
CREATE TABLE map_sketches (
  map_id   INTEGER PRIMARY KEY REFERENCES maps (id) ON DELETE CASCADE,
  revision INTEGER NOT NULL,
  sketch   BLOB    NOT NULL
) STRICT;
)sql";

constexpr std::array<const char*, 10> kMigrations = {
    kCreateTables,  kCreateMapGrids, kAddDrift,   kRememberMapsAndBeams, kRememberUse,
    kRememberBatch, kCreateTokens,   kCreateJobs, kKeepRevisions,        kCreateMapSketches};

}  // namespace

std::span<const char* const> migrations() { return kMigrations; }

std::int64_t schema_version() { return static_cast<std::int64_t>(kMigrations.size()); }

std::int64_t user_version(SQLite::Database& connection) {
  return connection.execAndGet("PRAGMA user_version").getInt64();
}

Result<void> check_schema_version(std::int64_t found, std::int64_t known) {
  if (found >= 0 && found <= known) return {};
  return Error{ErrorCode::kInvalidArgument,
               "the database has schema " + std::to_string(found) + ", this program knows up to " +
                   std::to_string(known) + ": use a newer program",
               ""};
}

Result<void> migrate(SQLite::Database& connection, std::span<const char* const> steps) {
  const auto target = static_cast<std::int64_t>(steps.size());
  if (user_version(connection) == target) return {};

  SQLite::Transaction transaction(connection, SQLite::TransactionBehavior::IMMEDIATE);
  // Read again: another process may have migrated the file before we got the lock.
  const std::int64_t found = user_version(connection);
  if (Result<void> known = check_schema_version(found, target); !known) return known;
  for (const char* step : steps.subspan(static_cast<std::size_t>(found))) connection.exec(step);
  connection.exec("PRAGMA application_id = " + std::to_string(kApplicationId));
  connection.exec("PRAGMA user_version = " + std::to_string(target));
  transaction.commit();
  return {};
}

}  // namespace cornerfix::storage
