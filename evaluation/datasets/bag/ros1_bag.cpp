#include "evaluation/datasets/bag/ros1_bag.hpp"

#include <map>
#include <utility>
#include <vector>

#include "evaluation/datasets/bag/binary_file.hpp"
#include "evaluation/datasets/bag/channel_table.hpp"
#include "evaluation/datasets/bag/decompress.hpp"

namespace cornerfix::evaluation {

namespace {

using Bytes = std::span<const std::byte>;

constexpr std::size_t kBagMagicBytes = sizeof "#ROSBAG V2.0\n" - 1;
constexpr std::uint32_t kMaxHeaderBytes = 1U << 20U;
constexpr std::string_view kPlain = "none";  // compression

struct BagOp {
  enum : std::uint8_t { kMessage = 0x02, kIndex = 0x04, kChunk = 0x05, kConnection = 0x07 };
};

/// The fields name=value of a record's header; views of its bytes.
class Fields {
 public:
  /// Nothing when the lengths are wrong or a field has no name.
  static std::optional<Fields> parse(Bytes bytes) {
    Fields fields;
    WireReader reader(bytes);
    while (reader.rest() > 0) {
      const std::string_view field = reader.text();
      const std::size_t equals = field.find('=');
      if (!reader.ok() || equals == std::string_view::npos) return std::nullopt;
      fields.values_[field.substr(0, equals)] = field.substr(equals + 1);
    }
    return fields;
  }

  [[nodiscard]] std::string_view text(std::string_view name) const {
    const auto found = values_.find(name);
    return found == values_.end() ? std::string_view() : found->second;
  }

  /// Little-endian; nothing when the value has another size.
  template <typename Number>
  [[nodiscard]] std::optional<Number> number(std::string_view name) const {
    const std::string_view value = text(name);
    if (value.size() != sizeof(Number)) return std::nullopt;
    return WireReader(std::as_bytes(std::span(value))).number<Number>();
  }

 private:
  std::map<std::string_view, std::string_view> values_;
};

/// Seconds and nanoseconds, each of 32 bits.
double seconds_of(std::uint64_t time) {
  return static_cast<double>(time & 0xffffffffU) + 1e-9 * static_cast<double>(time >> 32U);
}

class Ros1Bag final : public MessageSource {
 public:
  explicit Ros1Bag(BinaryFile file) : file_(std::move(file)), chunk_reader_(Bytes()) {}

  std::optional<RecordedMessage> next(LogFaults& faults) override {
    while (true) {
      if (chunk_reader_.rest() > 0) {
        if (auto message = next_in_chunk(faults)) return message;
      } else if (file_.rest() == 0) {
        return std::nullopt;
      } else if (auto fault = next_record(faults)) {
        faults.add(std::move(fault->where), std::move(fault->message));
        return std::nullopt;
      }
    }
  }

  [[nodiscard]] double progress() const override { return file_.progress(); }

  [[nodiscard]] std::vector<BagTopic> topics() const override { return channels_.topics(); }

 private:
  /// A record of the file: a chunk is opened. The records of the last chunk of a bag that was never
  /// closed (.bag.active) follow the empty chunk that was to hold them. Returns why nothing can be
  /// read from here on.
  std::optional<LogFault> next_record(LogFaults& faults) {
    const std::string where = file_.place();
    const auto ends_here = [&](std::string message) { return LogFault{where, std::move(message)}; };
    std::vector<std::byte> header;
    if (!read_block(header, kMaxHeaderBytes)) return ends_here("a record header that is cut off");
    const auto fields = Fields::parse(header);
    const auto op = fields ? fields->number<std::uint8_t>("op") : std::nullopt;
    if (!op) return ends_here("expected a record header with op");
    std::vector<std::byte> length;
    if (!file_.read(sizeof(std::uint32_t), length)) return ends_here("a record that is cut off");
    const auto size = WireReader(length).number<std::uint32_t>();
    if ((*op == BagOp::kMessage || *op == BagOp::kConnection) && size <= kMaxChunkBytes) {
      if (open_loose_record(header, size, where)) return std::nullopt;
      return ends_here("a record that is cut off");
    }
    if (*op != BagOp::kChunk || size > kMaxChunkBytes) {
      if (*op == BagOp::kChunk) faults.add(where, "a chunk of " + std::to_string(size) + " bytes");
      const std::uint64_t skipped = *op == BagOp::kIndex ? index_bytes(*fields, size) : size;
      if (!file_.skip(skipped)) return ends_here("a record that is cut off");
      return std::nullopt;
    }
    std::vector<std::byte> packed;
    if (file_.read(size, packed)) {
      open_chunk(*fields, std::move(packed), where, faults);
      return std::nullopt;
    }
    // What is there of a plain chunk can be read.
    if (fields->text("compression") == kPlain && file_.read(file_.rest(), chunk_)) {
      faults.add(where, "a chunk that is cut off");
      show_chunk(where);
      return std::nullopt;
    }
    return ends_here("a chunk that is cut off");
  }

  /// As if it were a chunk of one record.
  bool open_loose_record(const std::vector<std::byte>& header, std::uint32_t size,
                         const std::string& where) {
    std::vector<std::byte> data;
    if (!file_.read(size, data)) return false;
    chunk_.clear();
    append(header);
    append(data);
    show_chunk(where);
    return true;
  }

  /// A length and the bytes.
  void append(const std::vector<std::byte>& block) {
    const auto size = static_cast<std::uint32_t>(block.size());
    const auto length = std::as_bytes(std::span(&size, 1));
    chunk_.insert(chunk_.end(), length.begin(), length.end());
    chunk_.insert(chunk_.end(), block.begin(), block.end());
  }

  void show_chunk(const std::string& where) {
    chunk_reader_ = WireReader(chunk_);
    chunk_place_ = where;
  }

  /// How many bytes of index follow. Bags written in 2010 claim 20 bytes per entry and hold 12;
  /// rosbag counts entries as well, and does not look at the length.
  static std::uint64_t index_bytes(const Fields& fields, std::uint32_t size) {
    constexpr std::uint64_t kEntryBytes = sizeof(std::uint64_t) + sizeof(std::uint32_t);
    const auto entries = fields.number<std::uint32_t>("count");
    return entries ? *entries * kEntryBytes : size;
  }

  /// A length and as many bytes.
  bool read_block(std::vector<std::byte>& out, std::uint32_t max_size) {
    std::vector<std::byte> length;
    if (!file_.read(sizeof(std::uint32_t), length)) return false;
    const auto size = WireReader(length).number<std::uint32_t>();
    return size <= max_size && file_.read(size, out).ok();
  }

  void open_chunk(const Fields& fields, std::vector<std::byte> packed, const std::string& where,
                  LogFaults& faults) {
    const auto size = fields.number<std::uint32_t>("size");
    if (!size) return faults.add(where, "a chunk without its size");
    Result<std::vector<std::byte>> chunk = decompress(fields.text("compression"), packed, *size);
    if (!chunk) return faults.add(where, chunk.error().message);
    chunk_ = std::move(*chunk);
    show_chunk(where);
  }

  /// A record of the chunk: nothing when it is of no use.
  std::optional<RecordedMessage> next_in_chunk(LogFaults& faults) {
    const Bytes header = chunk_reader_.bytes(chunk_reader_.count(1));
    const Bytes data = chunk_reader_.bytes(chunk_reader_.count(1));
    const auto fields = Fields::parse(header);
    const auto op = fields ? fields->number<std::uint8_t>("op") : std::nullopt;
    if (!chunk_reader_.ok() || !op) {
      faults.add(chunk_place_, "a record of the chunk has wrong lengths");
      chunk_reader_ = WireReader(Bytes());
      return std::nullopt;
    }
    const auto connection = fields->number<std::uint32_t>("conn");
    if (!connection) return std::nullopt;
    if (*op == BagOp::kConnection) add_connection(*connection, *fields, data);
    if (*op == BagOp::kMessage) return message_of(*connection, *fields, data);
    return std::nullopt;
  }

  void add_connection(std::uint32_t id, const Fields& fields, Bytes data) {
    const auto connection = Fields::parse(data);
    if (!connection) return;
    channels_.add(id, fields.text("topic"), connection->text("type"), "ros1");
  }

  std::optional<RecordedMessage> message_of(std::uint32_t id, const Fields& fields, Bytes data) {
    const Channel* channel = channels_.pass(id);
    if (channel == nullptr) return std::nullopt;
    const double received = seconds_of(fields.number<std::uint64_t>("time").value_or(0));
    return RecordedMessage{
        channel->topic.name, channel->topic.type, *channel->kind, channel->format, received, data,
        chunk_place_};
  }

  BinaryFile file_;
  ChannelTable channels_;
  std::vector<std::byte> chunk_;
  WireReader chunk_reader_;  ///< Over chunk_.
  std::string chunk_place_;
};

}  // namespace

Result<std::unique_ptr<MessageSource>> open_ros1_messages(const std::filesystem::path& path) {
  Result<BinaryFile> file = BinaryFile::open(path);
  if (!file) return file.error();
  if (!file->skip(kBagMagicBytes)) {
    return Error{ErrorCode::kMalformed, "ends within its first line", path.string()};
  }
  return std::unique_ptr<MessageSource>(std::make_unique<Ros1Bag>(std::move(*file)));
}

}  // namespace cornerfix::evaluation
