#include "evaluation/datasets/bag/mcap.hpp"

#include <unordered_map>
#include <utility>
#include <vector>

#include "evaluation/datasets/bag/binary_file.hpp"
#include "evaluation/datasets/bag/channel_table.hpp"
#include "evaluation/datasets/bag/decompress.hpp"

namespace cornerfix::evaluation {

namespace {

using Bytes = std::span<const std::byte>;

constexpr std::size_t kMcapMagicBytes = 8;

struct McapOp {
  enum : std::uint8_t {
    kFooter = 0x02,
    kSchema = 0x03,
    kChannel = 0x04,
    kMessage = 0x05,
    kChunk = 0x06,
    kDataEnd = 0x0f,
  };
};

class Mcap final : public MessageSource {
 public:
  explicit Mcap(BinaryFile file) : file_(std::move(file)), chunk_reader_(Bytes()) {}

  std::optional<RecordedMessage> next(LogFaults& faults) override {
    while (true) {
      std::optional<RecordedMessage> message;
      if (chunk_reader_.rest() > 0) {
        message = next_in_chunk(faults);
      } else if (is_at_end_ || file_.rest() == 0) {
        return std::nullopt;
      } else {
        message = next_record(faults);
      }
      if (message) return message;
    }
  }

  [[nodiscard]] double progress() const override { return file_.progress(); }

  [[nodiscard]] std::vector<BagTopic> topics() const override { return channels_.topics(); }

 private:
  /// A record of the file: an opcode, a length, as many bytes.
  std::optional<RecordedMessage> next_record(LogFaults& faults) {
    const std::string where = file_.place();
    std::vector<std::byte> head;
    const bool has_head = file_.read(sizeof(std::uint8_t) + sizeof(std::uint64_t), head).ok();
    WireReader reader(head);
    const auto op = reader.number<std::uint8_t>();
    const auto size = reader.number<std::uint64_t>();
    if (!has_head || size > file_.rest()) {
      faults.add(where, "a record that is cut off");
      is_at_end_ = true;
      return std::nullopt;
    }
    // Behind the data are indices and the same schemas and channels again.
    is_at_end_ = op == McapOp::kDataEnd || op == McapOp::kFooter;
    const bool is_of_use = op == McapOp::kSchema || op == McapOp::kChannel ||
                           op == McapOp::kMessage || op == McapOp::kChunk;
    if (is_of_use && size > kMaxChunkBytes) {
      faults.add(where, "a record of " + std::to_string(size) + " bytes");
    }
    if (!is_of_use || size > kMaxChunkBytes) {
      is_at_end_ = !file_.skip(size) || is_at_end_;
      return std::nullopt;
    }
    if (const auto read = file_.read(size, record_); !read) {
      faults.add(where, read.error().message);
      is_at_end_ = true;
      return std::nullopt;
    }
    if (op != McapOp::kChunk) return take(op, record_, where, faults);
    open_chunk(where, faults);
    return std::nullopt;
  }

  /// Times, size and checksum of what is packed, the compression's name, and the packed records.
  void open_chunk(const std::string& where, LogFaults& faults) {
    WireReader reader(record_);
    reader.number<std::uint64_t>();
    reader.number<std::uint64_t>();
    const auto size = reader.number<std::uint64_t>();
    reader.number<std::uint32_t>();
    const std::string_view compression = reader.text();
    const auto packed_size = reader.number<std::uint64_t>();
    const Bytes packed = reader.bytes(packed_size);
    if (!reader.ok()) return faults.add(where, "a chunk with wrong lengths");
    Result<std::vector<std::byte>> chunk = decompress(compression, packed, size);
    if (!chunk) return faults.add(where, chunk.error().message);
    chunk_ = std::move(*chunk);
    chunk_reader_ = WireReader(chunk_);
    chunk_place_ = where;
  }

  std::optional<RecordedMessage> next_in_chunk(LogFaults& faults) {
    const auto op = chunk_reader_.number<std::uint8_t>();
    const auto size = chunk_reader_.number<std::uint64_t>();
    const Bytes record = chunk_reader_.bytes(size);
    if (chunk_reader_.ok()) return take(op, record, chunk_place_, faults);
    faults.add(chunk_place_, "a record of the chunk has a wrong length");
    chunk_reader_ = WireReader(Bytes());
    return std::nullopt;
  }

  /// A schema and a channel are remembered; a message is given out when its channel is of use.
  std::optional<RecordedMessage> take(std::uint8_t op, Bytes record, const std::string& where,
                                      LogFaults& faults) {
    WireReader reader(record);
    std::optional<RecordedMessage> message;
    if (op == McapOp::kSchema) add_schema(reader);
    if (op == McapOp::kChannel) add_channel(reader);
    if (op == McapOp::kMessage) message = message_of(reader, where);
    if (reader.ok()) return message;
    faults.add(where, "a record that ends too early");
    return std::nullopt;
  }

  void add_schema(WireReader& reader) {
    const auto id = reader.number<std::uint16_t>();
    const std::string_view name = reader.text();
    if (reader.ok()) types_[id] = name;
  }

  void add_channel(WireReader& reader) {
    const auto id = reader.number<std::uint16_t>();
    const auto schema = reader.number<std::uint16_t>();
    const std::string_view topic = reader.text();
    const std::string_view encoding = reader.text();
    const auto type = types_.find(schema);
    if (!reader.ok()) return;
    channels_.add(id, topic, type == types_.end() ? "without a schema" : type->second, encoding);
  }

  std::optional<RecordedMessage> message_of(WireReader& reader, const std::string& where) {
    const Channel* channel = channels_.pass(reader.number<std::uint16_t>());
    reader.number<std::uint32_t>();
    const auto received_ns = reader.number<std::uint64_t>();
    reader.number<std::uint64_t>();
    if (channel == nullptr) return std::nullopt;
    const Bytes data = reader.bytes(reader.rest());
    return RecordedMessage{channel->topic.name,
                           channel->topic.type,
                           *channel->kind,
                           channel->format,
                           1e-9 * static_cast<double>(received_ns),
                           data,
                           where};
  }

  BinaryFile file_;
  std::unordered_map<std::uint16_t, std::string> types_;  ///< Of schemas.
  ChannelTable channels_;
  std::vector<std::byte> record_;
  std::vector<std::byte> chunk_;
  WireReader chunk_reader_;  ///< Over chunk_.
  std::string chunk_place_;
  bool is_at_end_ = false;
};

}  // namespace

Result<std::unique_ptr<MessageSource>> open_mcap_messages(const std::filesystem::path& path) {
  Result<BinaryFile> file = BinaryFile::open(path);
  if (!file) return file.error();
  if (!file->skip(kMcapMagicBytes)) {
    return Error{ErrorCode::kMalformed, "ends within its magic", path.string()};
  }
  return std::unique_ptr<MessageSource>(std::make_unique<Mcap>(std::move(*file)));
}

}  // namespace cornerfix::evaluation
