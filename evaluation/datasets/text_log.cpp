#include <string>
#include <utility>

#include "evaluation/datasets/line_reader.hpp"
#include "evaluation/datasets/log_source.hpp"
#include "evaluation/datasets/scan_parser.hpp"

namespace cornerfix::evaluation {

namespace {

/// A log of lines; each holds a scan, something else, or nonsense.
class TextLog final : public LogSource {
 public:
  TextLog(LineReader lines, std::unique_ptr<ScanParser> parser)
      : lines_(std::move(lines)), parser_(std::move(parser)) {}

  std::optional<LogScan> next(LogFaults& faults) override {
    while (true) {
      const Result<bool> more = lines_.next();
      if (!more) faults.add(place(), more.error().message);
      if (!more || !*more) return end();
      Result<std::optional<LogScan>> scan = parser_->parse(lines_.line());
      note(parser_->choice(), is_choice_noted_);
      note(parser_->assumption(), is_assumption_noted_);
      if (!scan) {
        faults.add_scan(place(), scan.error().message);
      } else if (*scan) {
        return take(std::move(*scan));
      }
      if (!has_scan_ && faults.count() >= kMaxFaultsBeforeAScan) return std::nullopt;
    }
  }

  [[nodiscard]] double progress() const override { return lines_.progress(); }

 private:
  /// More broken lines than this in front of the first scan, and the file is no log.
  static constexpr std::size_t kMaxFaultsBeforeAScan = 100;

  std::optional<LogScan> end() {
    std::optional<LogScan> last = take(parser_->finish());
    const std::string contents = parser_->contents();
    if (!has_scan_ && notes_.empty() && !contents.empty()) notes_.push_back(contents);
    return last;
  }

  void note(std::string text, bool& is_noted) {
    if (is_noted || text.empty()) return;
    is_noted = true;
    notes_.push_back(std::move(text));
  }

  std::optional<LogScan> take(std::optional<LogScan> scan) {
    header_ = parser_->header();
    has_scan_ = has_scan_ || scan.has_value();
    return scan;
  }

  [[nodiscard]] std::string place() const {
    return "line " + std::to_string(lines_.line_number()) + ", byte " +
           std::to_string(lines_.line_offset());
  }

  LineReader lines_;
  std::unique_ptr<ScanParser> parser_;
  bool has_scan_ = false;
  bool is_choice_noted_ = false;
  bool is_assumption_noted_ = false;
};

Result<std::unique_ptr<LogSource>> open_text_log(const std::filesystem::path& path,
                                                 std::unique_ptr<ScanParser> parser) {
  Result<LineReader> lines = LineReader::open(path);
  if (!lines) return lines.error();
  return std::unique_ptr<LogSource>(
      std::make_unique<TextLog>(std::move(*lines), std::move(parser)));
}

}  // namespace

Result<std::unique_ptr<LogSource>> open_json_lines_log(const std::filesystem::path& path,
                                                       const std::string& lidar) {
  return open_text_log(path, make_json_lines_parser(lidar));
}

Result<std::unique_ptr<LogSource>> open_carmen_log(const std::filesystem::path& path,
                                                   const std::string& lidar) {
  return open_text_log(path, make_carmen_parser(lidar));
}

}  // namespace cornerfix::evaluation
