#include "evaluation/datasets/bag/sorted_messages.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace cornerfix::evaluation {

namespace {

constexpr std::size_t kMaxSortedBytes = std::size_t{2} << 30U;

struct KeptMessage {
  RecordedMessage message;
  std::vector<std::byte> bytes;
};

class SortedMessages final : public MessageSource {
 public:
  SortedMessages(std::unique_ptr<MessageSource> messages,
                 std::function<bool(const RecordedMessage&)> is_of_use)
      : messages_(std::move(messages)), is_of_use_(std::move(is_of_use)) {}

  std::optional<RecordedMessage> next(LogFaults& faults) override {
    if (!std::exchange(is_read_, true)) read(faults);
    if (at_ == kept_.size()) return std::nullopt;
    KeptMessage& next = kept_[at_++];
    current_ = std::move(next.bytes);
    next.message.bytes = current_;
    return next.message;
  }

  [[nodiscard]] double progress() const override {
    return kept_.empty() ? 0.0 : static_cast<double>(at_) / static_cast<double>(kept_.size());
  }

  [[nodiscard]] std::vector<BagTopic> topics() const override { return messages_->topics(); }

 private:
  void read(LogFaults& faults) {
    std::size_t bytes = 0;
    while (auto message = messages_->next(faults)) {
      if (!is_of_use_(*message)) continue;
      bytes += message->bytes.size();
      if (bytes > kMaxSortedBytes) {
        faults.add(message->where, "the bag is not in the order of its time and too large to sort");
        break;
      }
      kept_.push_back({*message, {message->bytes.begin(), message->bytes.end()}});
    }
    std::ranges::stable_sort(kept_, {},
                             [](const KeptMessage& kept) { return kept.message.received; });
  }

  std::unique_ptr<MessageSource> messages_;
  std::function<bool(const RecordedMessage&)> is_of_use_;
  bool is_read_ = false;
  std::vector<KeptMessage> kept_;
  std::size_t at_ = 0;
  std::vector<std::byte> current_;
};

}  // namespace

std::unique_ptr<MessageSource> sorted_by_time(
    std::unique_ptr<MessageSource> messages,
    std::function<bool(const RecordedMessage&)> is_of_use) {
  return std::make_unique<SortedMessages>(std::move(messages), std::move(is_of_use));
}

}  // namespace cornerfix::evaluation
