#include "evaluation/datasets/bag/bag_messages.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "evaluation/datasets/bag/decompress.hpp"
#include "evaluation/datasets/bag/mcap.hpp"
#include "evaluation/datasets/bag/ros1_bag.hpp"
#include "evaluation/datasets/bag/sqlite_bag.hpp"

namespace cornerfix::evaluation {

namespace {

namespace fs = std::filesystem;
using Source = std::unique_ptr<MessageSource>;

/// An empty file of its own, which goes with this object. What is open then can still be read.
class TemporaryFile {
 public:
  TemporaryFile() {
    std::error_code error;
    std::string name = (fs::temp_directory_path(error) / "cornerfix-XXXXXX").string();
    const int descriptor = error ? -1 : mkstemp(name.data());
    if (descriptor < 0) return;
    close(descriptor);
    path_ = name;
  }
  ~TemporaryFile() {
    std::error_code error;
    if (!path_.empty()) fs::remove(path_, error);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  /// Empty when it could not be made.
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

bool holds_a_bag(const fs::path& path) {
  constexpr std::string_view kFirstLetters = "#\x89S";  // #ROSBAG, MCAP, SQLite
  const std::vector<std::byte> bytes = magic_bytes(path);
  return !bytes.empty() &&
         kFirstLetters.find(std::to_integer<char>(bytes.front())) != std::string_view::npos;
}

Result<Source> open_plain_file(const fs::path& path) {
  const std::vector<std::byte> bytes = magic_bytes(path);
  const char begin = bytes.empty() ? '\0' : std::to_integer<char>(bytes.front());
  if (begin == '#') return open_ros1_messages(path);
  if (begin == '\x89') return open_mcap_messages(path);
  return open_sqlite_messages(path);
}

Result<Source> open_file(const fs::path& path) {
  const std::vector<std::byte> begin = magic_bytes(path);
  if (!is_zstd(begin) && !is_gzip(begin)) return open_plain_file(path);
  const TemporaryFile unpacked;
  if (const auto done = decompress_file(path, unpacked.path()); !done) {
    return Error{done.error().code, done.error().message, path.string()};
  }
  if (!holds_a_bag(unpacked.path())) {
    return Error{ErrorCode::kInvalidArgument,
                 std::string("is packed with ") + (is_zstd(begin) ? "zstd" : "gzip") +
                     " and holds no bag (.bag, .mcap, .db3): unpack it first",
                 path.string()};
  }
  Result<Source> opened = open_plain_file(unpacked.path());
  if (opened) return opened;
  return Error{opened.error().code, "unpacked, it " + opened.error().message, path.string()};
}

/// The messages of several files, unpacked.
class BagFileSequence final : public MessageSource {
 public:
  BagFileSequence(std::vector<fs::path> paths, Source first)
      : paths_(std::move(paths)), source_(std::move(first)) {}

  std::optional<RecordedMessage> next(LogFaults& faults) override {
    while (source_) {
      auto message = source_->next(faults);
      if (!message) {
        open_next(faults);
      } else if (!is_zstd(message->bytes) || message->format != WireFormat::kCdr) {
        return message;
      } else if (auto unpacked = decompress_message(message->bytes)) {
        message_ = std::move(*unpacked);
        message->bytes = message_;
        return message;
      } else {
        faults.add(message->where, message->topic + ": " + unpacked.error().message);
      }
    }
    return std::nullopt;
  }

  [[nodiscard]] double progress() const override {
    const double here = source_ ? source_->progress() : 0.0;
    return (static_cast<double>(at_) + here) / static_cast<double>(paths_.size());
  }

  [[nodiscard]] std::vector<BagTopic> topics() const override {
    std::vector<BagTopic> topics = earlier_topics_;
    if (source_) add_topics(source_->topics(), topics);
    return topics;
  }

 private:
  void open_next(LogFaults& faults) {
    add_topics(source_->topics(), earlier_topics_);
    source_.reset();
    while (!source_ && ++at_ < paths_.size()) {
      Result<Source> opened = open_file(paths_[at_]);
      if (opened) {
        source_ = std::move(*opened);
      } else {
        faults.add(paths_[at_].filename().string(), opened.error().message);
      }
    }
  }

  static void add_topics(const std::vector<BagTopic>& more, std::vector<BagTopic>& topics) {
    for (const BagTopic& topic : more) {
      const auto known = std::ranges::find(topics, topic.name, &BagTopic::name);
      if (known == topics.end()) {
        topics.push_back(topic);
      } else {
        known->messages += topic.messages;
      }
    }
  }

  std::vector<fs::path> paths_;
  std::size_t at_ = 0;  ///< Of `source_`.
  Source source_;       ///< Nothing at the end.
  std::vector<BagTopic> earlier_topics_;
  std::vector<std::byte> message_;
};

}  // namespace

Result<Source> open_bag_messages(const BagFiles& bag) {
  Result<Source> first = open_file(bag.paths.front());
  if (!first) return first;
  return Source(std::make_unique<BagFileSequence>(bag.paths, std::move(*first)));
}

}  // namespace cornerfix::evaluation
