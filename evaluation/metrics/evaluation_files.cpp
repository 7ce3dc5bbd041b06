#include "evaluation/metrics/evaluation_files.hpp"

#include <fstream>
#include <ios>
#include <system_error>

#include "evaluation/metrics/evaluation_report.hpp"

namespace cornerfix::evaluation {

namespace {

template <typename Write>
Result<void> write_file(const std::string& path, std::ios::openmode mode, const Write& write) {
  std::ofstream file(path, mode);
  write(file);
  if (!file.flush()) return Error{ErrorCode::kStorageFull, "could not be written", path};
  return {};
}

template <typename Record, typename RecordJson>
Result<void> write_summary_and_records(const std::string& path,
                                       const nlohmann::ordered_json& summary,
                                       const std::vector<Record>& records,
                                       const RecordJson& json_of) {
  nlohmann::ordered_json out{{"summary", summary}, {"starts", nlohmann::ordered_json::array()}};
  for (const Record& record : records) out["starts"].push_back(json_of(record));
  return write_file(path, std::ios::out, [&](std::ostream& file) { file << out << '\n'; });
}

}  // namespace

Result<void> write_evaluation(const std::string& path, const nlohmann::ordered_json& summary,
                              const std::vector<StartRecord>& records) {
  return write_summary_and_records(path, summary, records, record_json);
}

Result<void> write_evaluation(const std::string& path, const nlohmann::ordered_json& summary,
                              const std::vector<SingleScanRecord>& records) {
  return write_summary_and_records(path, summary, records, single_scan_record_json);
}

Result<void> write_record_table(const std::string& path, const std::vector<StartRecord>& records) {
  return write_file(path, std::ios::out, [&](std::ostream& csv) { write_records(csv, records); });
}

Result<void> append_samples(const std::string& path, const std::string& name,
                            const std::vector<StartRecord>& records) {
  return write_file(path, std::ios::app, [&](std::ofstream& csv) {
    write_samples(csv, name, records, csv.tellp() == 0);
  });
}

Result<void> write_explanation(const std::filesystem::path& directory,
                               const Explanation& explanation, const LocalizationMap* right_map) {
  std::error_code failure;
  std::filesystem::create_directories(directory, failure);
  const std::string stem =
      (directory / ("start_" + std::to_string(explanation.record.start))).string();
  const nlohmann::ordered_json json = explanation_json(explanation, right_map);
  Result<void> written = write_file(stem + ".json", std::ios::out,
                                    [&](std::ostream& file) { file << json.dump(1) << '\n'; });
  if (!written || !explanation.decision) return written;
  const std::string png = draw_decision(*explanation.decision, right_map).encode();
  return write_file(stem + ".png", std::ios::out | std::ios::binary,
                    [&](std::ostream& file) { file << png; });
}

}  // namespace cornerfix::evaluation
