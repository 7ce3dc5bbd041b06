#include "evaluation/datasets/bag/sqlite_bag.hpp"

#include <SQLiteCpp/SQLiteCpp.h>

#include <cstdint>
#include <cstdio>
#include <string>
#include <utility>

#include "evaluation/datasets/bag/channel_table.hpp"

namespace cornerfix::evaluation {

namespace {

constexpr std::int64_t kMaxMessageBytes = 16 << 20;
constexpr int kCannotOpen = 14;  // SQLITE_CANTOPEN

// A message that is too large is not even loaded.
constexpr const char* kMessages =
    "SELECT id, topic_id, timestamp, CASE WHEN length(data) <= ? THEN data END FROM messages "
    "ORDER BY id";

class SqliteBag final : public MessageSource {
 public:
  /// Throws SQLite::Exception when the file is no bag.
  SqliteBag(const std::string& path, int flags)
      : database_(path, flags), messages_(database_, kMessages) {
    messages_.bind(1, kMaxMessageBytes);
    last_id_ = database_.execAndGet("SELECT ifnull(max(id), 0) FROM messages").getInt64();
    SQLite::Statement topics(database_, "SELECT id, name, type, serialization_format FROM topics");
    while (topics.executeStep()) {
      channels_.add(topics.getColumn(0).getUInt(), topics.getColumn(1).getString(),
                    topics.getColumn(2).getString(), topics.getColumn(3).getString());
    }
  }

  std::optional<RecordedMessage> next(LogFaults& faults) override {
    try {
      while (!is_at_end_ && messages_.executeStep()) {
        id_ = messages_.getColumn(0).getInt64();
        const Channel* channel = channels_.pass(messages_.getColumn(1).getUInt());
        if (channel == nullptr) continue;
        if (auto message = message_in_row(*channel, faults)) return message;
      }
    } catch (const SQLite::Exception& error) {
      faults.add(place(), std::string("the file is damaged: ") + error.what());
    }
    is_at_end_ = true;
    return std::nullopt;
  }

  [[nodiscard]] double progress() const override {
    return last_id_ > 0 ? static_cast<double>(id_) / static_cast<double>(last_id_) : 1.0;
  }

  [[nodiscard]] std::vector<BagTopic> topics() const override { return channels_.topics(); }

 private:
  /// SQLite does not give the place of a row in the file.
  [[nodiscard]] std::string place() const { return "message " + std::to_string(id_); }

  std::optional<RecordedMessage> message_in_row(const Channel& channel, LogFaults& faults) {
    const SQLite::Column data = messages_.getColumn(3);
    if (data.isNull()) {
      faults.add(place(), "no data, or more than " + std::to_string(kMaxMessageBytes) + " bytes");
      return std::nullopt;
    }
    const auto* const bytes = static_cast<const std::byte*>(data.getBlob());
    const double received = 1e-9 * static_cast<double>(messages_.getColumn(2).getInt64());
    return RecordedMessage{channel.topic.name,
                           channel.topic.type,
                           *channel.kind,
                           channel.format,
                           received,
                           {bytes, static_cast<std::size_t>(data.getBytes())},
                           place()};
  }

  SQLite::Database database_;
  SQLite::Statement messages_;
  ChannelTable channels_;
  std::int64_t id_ = 0;
  std::int64_t last_id_ = 0;
  bool is_at_end_ = false;
};

/// A path as SQLite reads it in a URI.
std::string escaped(const std::string& path) {
  std::string out;
  for (const char letter : path) {
    char code[4];
    std::snprintf(code, sizeof code, "%%%02X", static_cast<unsigned>(letter) & 0xffU);
    const bool is_special = letter == '%' || letter == '?' || letter == '#';
    out += is_special ? std::string(code) : std::string(1, letter);
  }
  return out;
}

/// Reading a bag whose recorder used a write-ahead log needs a file beside it. Where none can be
/// made (a read-only disk) and no log is left, the bag is read as a file that nobody changes.
std::unique_ptr<SqliteBag> open_database(const std::filesystem::path& path) {
  try {
    return std::make_unique<SqliteBag>(path.string(), SQLite::OPEN_READONLY);
  } catch (const SQLite::Exception& error) {
    std::error_code missing;
    const auto log_bytes = std::filesystem::file_size(path.string() + "-wal", missing);
    if (error.getErrorCode() != kCannotOpen || (!missing && log_bytes > 0)) throw;
    return std::make_unique<SqliteBag>("file:" + escaped(path.string()) + "?immutable=1",
                                       SQLite::OPEN_READONLY | SQLite::OPEN_URI);
  }
}

}  // namespace

Result<std::unique_ptr<MessageSource>> open_sqlite_messages(const std::filesystem::path& path) {
  try {
    return std::unique_ptr<MessageSource>(open_database(path));
  } catch (const SQLite::Exception& error) {
    return Error{ErrorCode::kMalformed,
                 std::string("is no bag of ROS 2 that can be read, expected tables topics and "
                             "messages: ") +
                     error.what() + "; sqlite3's .recover may save what is left of a damaged file",
                 path.string()};
  }
}

}  // namespace cornerfix::evaluation
