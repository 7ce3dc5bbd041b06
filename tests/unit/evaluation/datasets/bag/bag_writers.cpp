#include "unit/evaluation/datasets/bag/bag_writers.hpp"

#include <SQLiteCpp/SQLiteCpp.h>
#include <bzlib.h>
#include <gtest/gtest.h>
#include <lz4frame.h>
#include <zstd.h>

#include <map>

namespace cornerfix::evaluation {

namespace {

constexpr std::uint32_t kIndexEntryBytes = 12;

std::string compressed(const std::string& compression, const std::string& text) {
  std::string packed(text.size() * 2 + 1000, '\0');
  if (compression == "bz2") {
    auto size = static_cast<unsigned>(packed.size());
    std::string input = text;
    EXPECT_EQ(BZ2_bzBuffToBuffCompress(packed.data(), &size, input.data(),
                                       static_cast<unsigned>(input.size()), 9, 0, 0),
              BZ_OK);
    packed.resize(size);
  } else if (compression == "lz4") {
    packed.resize(
        LZ4F_compressFrame(packed.data(), packed.size(), text.data(), text.size(), nullptr));
  } else if (compression == "zstd") {
    packed.resize(ZSTD_compress(packed.data(), packed.size(), text.data(), text.size(), 3));
  } else {
    packed = text;
  }
  return packed;
}

// --- ROS 1 --------------------------------------------------------------------------------------

std::string field(const std::string& name, const std::string& value) {
  return WireWriter().text(name + "=" + value).bytes();
}

template <typename Number>
std::string as_bytes(Number value) {
  return WireWriter().number(value).bytes();
}

std::string record(const std::string& header, const std::string& data) {
  return WireWriter().text(header).text(data).bytes();
}

std::string time_bytes(double time) {
  const auto seconds = static_cast<std::uint32_t>(time);
  return WireWriter()
      .number(seconds)
      .number(static_cast<std::uint32_t>((time - seconds) * 1e9))
      .bytes();
}

std::string connection_record(std::uint32_t id, const WrittenMessage& message) {
  return record(field("op", "\x07") + field("conn", as_bytes(id)) + field("topic", message.topic),
                field("topic", message.topic) + field("type", message.type) + field("md5sum", "*") +
                    field("message_definition", "# none"));
}

std::string message_record(std::uint32_t id, const WrittenMessage& message) {
  return record(field("op", "\x02") + field("conn", as_bytes(id)) +
                    field("time", time_bytes(message.received)),
                message.bytes);
}

// --- MCAP ---------------------------------------------------------------------------------------

std::string mcap_record(std::uint8_t op, const std::string& content) {
  return WireWriter().number(op).number(std::uint64_t{content.size()}).raw(content).bytes();
}

std::string mcap_channel(std::uint16_t id, const WrittenMessage& message) {
  const std::string schema =
      WireWriter().number(id).text(message.type).text("ros2msg").text("# none").bytes();
  const std::string channel = WireWriter()
                                  .number(id)
                                  .number(id)
                                  .text(message.topic)
                                  .text("cdr")
                                  .number(std::uint32_t{0})
                                  .bytes();
  return mcap_record(0x03, schema) + mcap_record(0x04, channel);
}

std::string mcap_message(std::uint16_t id, const WrittenMessage& message) {
  const auto time_ns = static_cast<std::uint64_t>(message.received * 1e9);
  return mcap_record(0x05, WireWriter()
                               .number(id)
                               .number(std::uint32_t{0})
                               .number(time_ns)
                               .number(time_ns)
                               .raw(message.bytes)
                               .bytes());
}

std::string mcap_chunk(const std::string& records, const std::string& compression) {
  const std::string packed = compressed(compression, records);
  return mcap_record(0x06, WireWriter()
                               .number(std::uint64_t{0})
                               .number(std::uint64_t{0})
                               .number(std::uint64_t{records.size()})
                               .number(std::uint32_t{0})
                               .text(compression)
                               .number(std::uint64_t{packed.size()})
                               .raw(packed)
                               .bytes());
}

}  // namespace

std::string index_record(std::uint32_t entries, std::uint32_t claimed_bytes) {
  return WireWriter()
      .text(field("op", "\x04") + field("ver", as_bytes(std::uint32_t{1})) +
            field("conn", as_bytes(std::uint32_t{0})) + field("count", as_bytes(entries)))
      .number(claimed_bytes)
      .bytes();
}

std::string ros1_bag(const std::vector<std::vector<WrittenMessage>>& chunks,
                     const std::string& compression) {
  std::string bag = "#ROSBAG V2.0\n";
  bag += record(field("op", "\x03") + field("index_pos", as_bytes(std::uint64_t{0})) +
                    field("conn_count", as_bytes(std::uint32_t{0})) +
                    field("chunk_count", as_bytes(std::uint32_t{0})),
                std::string(4096 - 69, ' '));
  std::map<std::string, std::uint32_t> ids;
  for (const auto& messages : chunks) {
    std::string chunk;
    for (const WrittenMessage& message : messages) {
      const auto [entry, is_new] = ids.try_emplace(message.topic, ids.size());
      if (is_new) chunk += connection_record(entry->second, message);
      chunk += message_record(entry->second, message);
    }
    bag += record(field("op", "\x05") + field("compression", compression) +
                      field("size", as_bytes(static_cast<std::uint32_t>(chunk.size()))),
                  compressed(compression, chunk));
    const auto entries = static_cast<std::uint32_t>(messages.size());
    bag += index_record(entries, entries * kIndexEntryBytes) +
           std::string(entries * kIndexEntryBytes, '\0');
  }
  return bag;
}

std::string mcap(const std::vector<std::vector<WrittenMessage>>& chunks,
                 const std::string& compression) {
  const std::string magic = "\x89MCAP0\r\n";
  std::string file = magic + mcap_record(0x01, WireWriter().text("ros2").text("test").bytes());
  std::map<std::string, std::uint16_t> ids;
  for (const auto& messages : chunks) {
    std::string records;
    for (const WrittenMessage& message : messages) {
      const auto [entry, is_new] =
          ids.try_emplace(message.topic, static_cast<std::uint16_t>(ids.size() + 1));
      if (is_new) records += mcap_channel(entry->second, message);
      records += mcap_message(entry->second, message);
    }
    file += mcap_chunk(records, compression);
  }
  file += mcap_record(0x0f, as_bytes(std::uint32_t{0}));
  return file + mcap_record(0x02, std::string(20, '\0')) + magic;
}

std::string zstd_packed(const std::string& text) { return compressed("zstd", text); }

void write_sqlite_bag(const std::filesystem::path& path,
                      const std::vector<WrittenMessage>& messages) {
  SQLite::Database database(path.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
  database.exec(
      "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, "
      "serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);"
      "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, "
      "timestamp INTEGER NOT NULL, data BLOB NOT NULL)");
  std::map<std::string, int> ids;
  for (const WrittenMessage& message : messages) {
    const auto [entry, is_new] = ids.try_emplace(message.topic, static_cast<int>(ids.size() + 1));
    if (is_new) {
      SQLite::Statement topic(database, "INSERT INTO topics VALUES (?, ?, ?, 'cdr', '')");
      topic.bind(1, entry->second);
      topic.bind(2, message.topic);
      topic.bind(3, message.type);
      topic.exec();
    }
    SQLite::Statement row(database,
                          "INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)");
    row.bind(1, entry->second);
    row.bind(2, static_cast<std::int64_t>(message.received * 1e9));
    row.bind(3, message.bytes.data(), static_cast<int>(message.bytes.size()));
    row.exec();
  }
}

}  // namespace cornerfix::evaluation
