#include "evaluation/datasets/log_reader.hpp"

#include <utility>

#include "evaluation/datasets/constant_range.hpp"
#include "evaluation/datasets/log_format.hpp"
#include "evaluation/datasets/log_source.hpp"
#include "evaluation/datasets/odd_scans.hpp"
#include "evaluation/datasets/scan_queue.hpp"
#include "evaluation/datasets/scan_straightener.hpp"
#include "evaluation/datasets/stamp_order.hpp"

namespace cornerfix::evaluation {

namespace {

/// The name of the file without ".gz" and its own extension, or that of the directory.
std::string plain_name(std::filesystem::path path) {
  path = path.has_filename() ? path.filename() : path.parent_path().filename();
  if (path.extension() == ".gz") path = path.stem();
  return path.stem().string();
}

Result<std::unique_ptr<LogSource>> open_source(const std::filesystem::path& path,
                                               const LogSelection& selection) {
  const Result<LogFormat> format = detect_log_format(path);
  if (!format) return format.error();
  if (*format != LogFormat::kBag && !selection.odometry.empty()) {
    return Error{ErrorCode::kInvalidArgument,
                 "has one odometry, without topics: " + selection.odometry +
                     " can be chosen in bags only (--odom)",
                 path.string()};
  }
  switch (*format) {
    case LogFormat::kJsonLines:
      return open_json_lines_log(path, selection.lidar);
    case LogFormat::kCarmen:
      return open_carmen_log(path, selection.lidar);
    case LogFormat::kBag:
      return open_bag(path, selection);
  }
  return Error{ErrorCode::kInternal, "format without reader", path.string()};
}

/// "3 broken records left out, the first at line 7, byte 120: FLASER: expected 180 ranges".
std::string faults_text(const LogFaults& faults) {
  const LogFault& first = faults.first().front();
  return std::to_string(faults.count()) +
         (faults.count() == 1 ? " broken record" : " broken records") + " left out, the first at " +
         first.where + ": " + first.message;
}

}  // namespace

LogReader::LogReader(std::unique_ptr<LogSource> source, std::filesystem::path path,
                     double scan_time)
    : source_(std::move(source)),
      path_(std::move(path)),
      constant_range_(std::make_unique<ConstantRange>()),
      oddities_(std::make_unique<OddScans>()),
      queue_(std::make_unique<ScanQueue>()),
      order_(std::make_unique<StampOrder>()),
      straightener_(std::make_unique<ScanStraightener>()),
      scan_time_(scan_time) {}
LogReader::~LogReader() = default;
LogReader::LogReader(LogReader&&) noexcept = default;

Result<LogReader> LogReader::open(const std::filesystem::path& path,
                                  const LogSelection& selection) {
  Result<std::unique_ptr<LogSource>> source = open_source(path, selection);
  if (!source) return source.error();
  LogReader reader(std::move(*source), path, selection.scan_time);
  reader.ahead_ = reader.next_in_order();
  if (!reader.ahead_) {
    const std::string which = selection.lidar.empty() ? "" : " of " + selection.lidar;
    const std::string why = remarks(reader);
    return Error{ErrorCode::kMalformed, "holds no scan" + which + (why.empty() ? "" : "; " + why),
                 path.string()};
  }
  reader.header_ = reader.source_->header();
  if (reader.header_.name.empty()) reader.header_.name = plain_name(path);
  return reader;
}

void set_lidar(LogHeader& header, const LaserScan& scan) {
  header.beams = scan.ranges.size();
  header.lidar = scan;
  header.lidar.ranges.clear();
  header.lidar.stamp = 0.0;
}

bool has_lidar_of(const LogHeader& header, const LaserScan& scan) {
  const LaserScan& lidar = header.lidar;
  return scan.ranges.size() == header.beams && scan.angle_min == lidar.angle_min &&
         scan.angle_increment == lidar.angle_increment && scan.range_min == lidar.range_min &&
         scan.range_max == lidar.range_max;
}

const LogHeader& LogReader::header() const { return header_; }

double LogReader::progress() const { return source_->progress(); }

std::vector<std::string> LogReader::notes() const {
  std::vector<std::string> notes = source_->notes();
  if (std::string note = constant_range_->note(); !note.empty()) notes.push_back(std::move(note));
  for (std::string& note : oddities_->notes()) notes.push_back(std::move(note));
  if (std::string note = queue_->note(); !note.empty()) notes.push_back(std::move(note));
  for (std::string& note : order_->notes()) notes.push_back(std::move(note));
  for (std::string& note : straightener_->notes()) notes.push_back(std::move(note));
  return notes;
}

std::optional<Error> LogReader::most_scans_lost() const {
  const std::size_t lost = faults_.scans();
  if (lost <= scans_) return std::nullopt;
  return Error{ErrorCode::kMalformed,
               std::to_string(lost) + " of " + std::to_string(lost + scans_) +
                   " scans were left out; " + remarks(*this),
               path_.string()};
}

std::optional<LogScan> LogReader::next() {
  std::optional<LogScan> scan = ahead_ ? std::exchange(ahead_, std::nullopt) : next_in_order();
  if (!scan) return scan;
  if (scan->time_increment != 0.0) ahead_ = next_in_order();
  straightener_->straighten(*scan, ahead_ ? &*ahead_ : nullptr);
  return scan;
}

std::optional<LogScan> LogReader::next_recorded() {
  while (!is_read_ && recorded_.size() < ConstantRange::kScans) {
    std::optional<LogScan> scan = source_->next(faults_);
    is_read_ = !scan;
    if (!scan) break;
    constant_range_->look_at(scan->scan);
    recorded_.push_back(std::move(*scan));
  }
  if (recorded_.empty()) return std::nullopt;
  LogScan scan = std::move(recorded_.front());
  recorded_.pop_front();
  constant_range_->clear(scan.scan);
  oddities_->look_at(scan);
  return scan;
}

std::optional<LogScan> LogReader::next_in_order() {
  while (true) {
    while (!queue_->is_full()) {
      std::optional<LogScan> recorded = next_recorded();
      if (!recorded) break;
      queue_->push(std::move(*recorded));
    }
    if (queue_->is_empty()) return std::nullopt;
    std::optional<LogScan> scan = queue_->pop();
    if (!order_->take(*scan, queue_->next_stamp(), faults_)) continue;
    ++scans_;
    if (scan_time_ > 0.0) {
      scan->time_increment = scan_time_ / static_cast<double>(scan->scan.ranges.size());
    }
    return scan;
  }
}

std::string remarks(const LogReader& reader) {
  std::string text;
  for (const std::string& note : reader.notes()) text += (text.empty() ? "" : "; ") + note;
  if (reader.faults().count() == 0) return text;
  return text + (text.empty() ? "" : "; ") + faults_text(reader.faults());
}

RecordedLog read_all(LogReader& reader, std::size_t stride,
                     const std::function<void(double)>& progress) {
  RecordedLog log;
  log.header = reader.header();
  std::size_t index = 0;
  while (std::optional<LogScan> scan = reader.next()) {
    if (index++ % stride == 0) log.scans.push_back(std::move(*scan));
    if (progress) progress(reader.progress());
  }
  return log;
}

Result<RecordedLog> read_log(const std::filesystem::path& path, std::size_t stride) {
  Result<LogReader> reader = LogReader::open(path);
  if (!reader) return reader.error();
  return read_all(*reader, stride);
}

}  // namespace cornerfix::evaluation
