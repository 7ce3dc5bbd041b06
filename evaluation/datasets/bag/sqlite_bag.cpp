#include "evaluation/datasets/bag/sqlite_bag.hpp"

#include <SQLiteCpp/SQLiteCpp.h>

#include <cstdint>
#include <utility>

#include "evaluation/datasets/bag/channel_table.hpp"

namespace cornerfix::evaluation {

namespace {

constexpr std::int64_t kMaxMessageBytes = 16 << 20;

// A message that is too large is not even loaded.
constexpr const char* kMessages =
    "SELECT id, topic_id, timestamp, CASE WHEN length(data) <= ? THEN data END FROM messages "
    "ORDER BY id";

class SqliteBag final : public MessageSource {
 public:
  /// Throws SQLite::Exception when the file is no bag.
  explicit SqliteBag(const std::filesystem::path& path)
      : database_(path.string(), SQLite::OPEN_READONLY), messages_(database_, kMessages) {
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

}  // namespace

Result<std::unique_ptr<MessageSource>> open_sqlite_messages(const std::filesystem::path& path) {
  try {
    return std::unique_ptr<MessageSource>(std::make_unique<SqliteBag>(path));
  } catch (const SQLite::Exception& error) {
    return Error{ErrorCode::kMalformed,
                 std::string("is no bag of ROS 2 that can be read, expected tables topics and "
                             "messages: ") +
                     error.what() + "; sqlite3's .recover may save what is left of a damaged file",
                 path.string()};
  }
}

}  // namespace cornerfix::evaluation
