#include "evaluation/datasets/log_writer.hpp"

#include <zlib.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>

namespace cornerfix::evaluation {

namespace {

void append_number(std::string& out, double value, int decimals) {
  std::array<char, 64> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value,
                                 std::chars_format::fixed, decimals)
                       .ptr;
  out.append(buffer.data(), end);
}

void append_pose(std::string& out, const std::optional<Pose2>& pose) {
  constexpr int kDecimals = 6;
  if (!pose) {
    out += "null";
    return;
  }
  out += '[';
  append_number(out, pose->x, kDecimals);
  out += ',';
  append_number(out, pose->y, kDecimals);
  out += ',';
  append_number(out, pose->yaw, kDecimals);
  out += ']';
}

void append_ranges(std::string& out, const LaserScan& scan) {
  out += '[';
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    if (beam > 0) out += ',';
    if (scan.has_return(beam)) {
      append_number(out, static_cast<double>(scan.ranges[beam]), 3);
    } else {
      out += "null";
    }
  }
  out += ']';
}

std::string header_line(const LogHeader& header) {
  const nlohmann::ordered_json json = {{"name", header.name},
                                       {"beams", header.beams},
                                       {"angle_min", header.lidar.angle_min},
                                       {"angle_increment", header.lidar.angle_increment},
                                       {"range_min", header.lidar.range_min},
                                       {"range_max", header.lidar.range_max},
                                       {"source", header.source},
                                       {"simulated", true}};
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + '\n';
}

std::string scan_line(const LogScan& scan) {
  std::string line = "{\"t\":";
  append_number(line, scan.scan.stamp, 3);
  line += ",\"ranges\":";
  append_ranges(line, scan.scan);
  line += ",\"odom\":";
  append_pose(line, scan.T_odom_laser);
  line += ",\"pose\":";
  append_pose(line, scan.T_map_laser);
  return line + "}\n";
}

}  // namespace

class LogWriter::File {
 public:
  File(std::filesystem::path path, gzFile file) : path_(std::move(path)), file_(file) {}
  ~File() {
    if (file_ != nullptr) gzclose(file_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  Result<void> write(const std::string& text) {
    if (gzwrite(file_, text.data(), static_cast<unsigned>(text.size())) == 0) return failure();
    return {};
  }

  Result<void> close() {
    if (gzclose(std::exchange(file_, nullptr)) != Z_OK) return failure();
    return {};
  }

 private:
  [[nodiscard]] Error failure() const {
    return {errno == ENOSPC ? ErrorCode::kStorageFull : ErrorCode::kUnavailable,
            std::string("cannot be written: ") + std::strerror(errno), path_.string()};
  }

  std::filesystem::path path_;
  gzFile file_;
};

LogWriter::LogWriter(std::unique_ptr<File> file) : file_(std::move(file)) {}
LogWriter::~LogWriter() = default;
LogWriter::LogWriter(LogWriter&&) noexcept = default;

Result<LogWriter> LogWriter::create(const std::filesystem::path& path, const LogHeader& header) {
  errno = 0;
  gzFile file = gzopen(path.c_str(), path.extension() == ".gz" ? "wb6" : "wbT");
  if (file == nullptr) {
    return Error{ErrorCode::kUnavailable, std::string("cannot be written: ") + std::strerror(errno),
                 path.string()};
  }
  LogWriter writer(std::make_unique<File>(path, file));
  const Result<void> written = writer.file_->write(header_line(header));
  if (!written) return written.error();
  return writer;
}

Result<void> LogWriter::write(const LogScan& scan) { return file_->write(scan_line(scan)); }

Result<void> LogWriter::close() { return file_->close(); }

Result<void> write_log(const std::filesystem::path& path, const RecordedLog& log,
                       const std::function<void(double)>& progress) {
  Result<LogWriter> writer = LogWriter::create(path, log.header);
  if (!writer) return writer.error();
  for (std::size_t i = 0; i < log.scans.size(); ++i) {
    Result<void> written = writer->write(log.scans[i]);
    if (!written) return written;
    if (progress) progress(static_cast<double>(i + 1) / static_cast<double>(log.scans.size()));
  }
  return writer->close();
}

}  // namespace cornerfix::evaluation
