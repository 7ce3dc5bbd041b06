#include "server/event_log.hpp"

#include <spdlog/formatter.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <memory>
#include <nlohmann/json.hpp>

namespace cornerfix::server {
namespace {

std::atomic<LogFormat>& format_in_use() {
  static std::atomic<LogFormat> format = LogFormat::kText;
  return format;
}

std::string json_string(std::string_view text) {
  return nlohmann::json(text).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

bool is_left_out(const LogValue& value) {
  const auto* text = std::get_if<std::string_view>(&value);
  return text != nullptr && text->empty();
}

std::string value_text(const LogValue& value, bool as_json) {
  if (const auto* text = std::get_if<std::string_view>(&value))
    return as_json ? json_string(*text) : printable(*text);
  if (const auto* number = std::get_if<double>(&value)) return fmt::format("{:.3f}", *number);
  return std::to_string(std::get<std::int64_t>(value));
}

/// Lines as JSON objects. A payload that begins with a quote is members of one already.
class JsonFormatter final : public spdlog::formatter {
 public:
  void format(const spdlog::details::log_msg& line, spdlog::memory_buf_t& out) override {
    const std::string_view payload(line.payload.data(), line.payload.size());
    const auto level = spdlog::level::to_string_view(line.level);
    const auto since_epoch = line.time.time_since_epoch();
    const auto ms =
        std::chrono::duration_cast<std::chrono::milliseconds>(since_epoch).count() % 1000;
    const std::time_t seconds = spdlog::log_clock::to_time_t(line.time);
    std::tm utc{};
    gmtime_r(&seconds, &utc);
    char time[32];
    std::strftime(time, sizeof time, "%Y-%m-%dT%H:%M:%S", &utc);
    const std::string members =
        payload.starts_with('"') ? std::string(payload) : "\"message\":" + json_string(payload);
    const std::string text = fmt::format("{{\"time\":\"{}.{:03}Z\",\"level\":\"{}\",{}}}\n", time,
                                         ms, std::string_view(level.data(), level.size()), members);
    out.append(text.data(), text.data() + text.size());
  }
  [[nodiscard]] std::unique_ptr<spdlog::formatter> clone() const override {
    return std::make_unique<JsonFormatter>();
  }
};

void log_at(spdlog::level::level_enum level, std::string_view event, LogFields fields) {
  if (!spdlog::should_log(level)) return;
  spdlog::log(level, "{}", log_text(format_in_use(), event, fields));
}

}  // namespace

std::string printable(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x20 && byte != 0x7f) {
      out += c;
    } else {
      out += fmt::format("\\x{:02x}", byte);
    }
  }
  return out;
}

void begin_log(LogFormat format) {
  format_in_use() = format;
  const auto logger = spdlog::stderr_logger_mt("cornerfix");
  if (format == LogFormat::kJson) {
    logger->set_formatter(std::make_unique<JsonFormatter>());
  } else {
    logger->set_pattern("%Y-%m-%d %H:%M:%S.%e %l %v");
  }
  spdlog::set_default_logger(logger);
}

std::string log_text(LogFormat format, std::string_view event, LogFields fields) {
  const bool as_json = format == LogFormat::kJson;
  std::string text = as_json ? "\"event\":" + json_string(event) : std::string(event);
  for (const auto& [name, value] : fields) {
    if (is_left_out(value)) continue;
    text += as_json ? ",\"" + std::string(name) + "\":" : " " + std::string(name) + "=";
    text += value_text(value, as_json);
  }
  return text;
}

void log_event(std::string_view event, LogFields fields) {
  log_at(spdlog::level::info, event, fields);
}

void log_warning(std::string_view event, LogFields fields) {
  log_at(spdlog::level::warn, event, fields);
}

}  // namespace cornerfix::server
