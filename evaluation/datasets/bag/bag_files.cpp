#include "evaluation/datasets/bag/bag_files.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <optional>
#include <string_view>

namespace cornerfix::evaluation {

namespace {

namespace fs = std::filesystem;

constexpr const char* kMetadata = "metadata.yaml";

bool is_file(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

bool is_bag_file(fs::path path) {
  for (const char* packed : {".zstd", ".zst", ".gz"}) {
    if (path.extension() == packed) path = path.stem();
  }
  const std::string extension = path.extension().string();
  return extension == ".db3" || extension == ".mcap" || extension == ".bag";
}

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

/// Takes the digits in front of a text, without leading zeros.
std::string_view take_digits(std::string_view& text) {
  const std::size_t size = std::min(text.size(), text.find_first_not_of("0123456789"));
  std::string_view digits = text.substr(0, size);
  text.remove_prefix(size);
  digits.remove_prefix(std::min(digits.size(), digits.find_first_not_of('0')));
  return digits;
}

/// By characters, but numbers by their value.
bool comes_before(std::string_view a, std::string_view b) {
  while (!a.empty() && !b.empty()) {
    if (is_digit(a.front()) && is_digit(b.front())) {
      const std::string_view x = take_digits(a);
      const std::string_view y = take_digits(b);
      if (x.size() != y.size()) return x.size() < y.size();
      if (x != y) return x < y;
    } else {
      if (a.front() != b.front()) return a.front() < b.front();
      a.remove_prefix(1);
      b.remove_prefix(1);
    }
  }
  return a.size() < b.size();
}

std::vector<fs::path> all_bag_files(const fs::path& directory) {
  std::vector<fs::path> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(directory, error)) {
    if (is_file(entry.path()) && is_bag_file(entry.path())) files.push_back(entry.path());
  }
  std::ranges::sort(files, [](const fs::path& a, const fs::path& b) {
    return comes_before(a.filename().string(), b.filename().string());
  });
  return files;
}

/// The names that metadata.yaml lists; nothing when there is no list.
std::vector<std::string> listed_names(const fs::path& metadata, BagFiles& bag) {
  if (!is_file(metadata)) return {};
  try {
    const YAML::Node root = YAML::LoadFile(metadata.string());
    return root["rosbag2_bagfile_information"]["relative_file_paths"]
        .as<std::vector<std::string>>();
  } catch (const YAML::Exception& error) {
    bag.notes.push_back("metadata.yaml lists no files (" + std::string(error.what()) +
                        "): all bag files are read, by name");
    return {};
  }
}

/// Some versions of rosbag2 list a file with its directory, or without the .zstd that it got.
std::optional<fs::path> listed_file(const fs::path& directory, const std::string& name) {
  const fs::path file = directory / fs::path(name).filename();
  for (const fs::path& path : {file, fs::path(file.string() + ".zstd")}) {
    if (is_file(path)) return path;
  }
  return std::nullopt;
}

/// The names of the bag files that are not read; a file that was unpacked beside its .zstd is.
std::string unlisted(const fs::path& directory, const std::vector<fs::path>& listed) {
  std::string names;
  for (const fs::path& file : all_bag_files(directory)) {
    const bool is_read = std::ranges::any_of(listed, [&](const fs::path& path) {
      return path == file || path.stem() == file.filename();
    });
    if (!is_read) names += (names.empty() ? "" : ", ") + file.filename().string();
  }
  return names;
}

/// Names the directories in it that hold a bag.
Error no_bag(const fs::path& directory, const std::vector<std::string>& notes) {
  std::string message = "is a directory without the files of a bag (.db3, .mcap, .bag)";
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(directory, error)) {
    if (entry.is_directory(error) && !all_bag_files(entry.path()).empty()) {
      message += "; " + entry.path().string() + " is a bag";
    }
  }
  for (const std::string& note : notes) message += "; " + note;
  return {ErrorCode::kInvalidArgument, std::move(message), directory.string()};
}

}  // namespace

Result<BagFiles> find_bag_files(const fs::path& path) {
  BagFiles bag;
  std::error_code error;
  if (path.filename() == kMetadata) {
    return find_bag_files(path.has_parent_path() ? path.parent_path() : fs::path("."));
  }
  if (!fs::is_directory(path, error)) {
    bag.paths = {path};
    return bag;
  }
  const std::vector<std::string> names = listed_names(path / kMetadata, bag);
  for (const std::string& name : names) {
    if (const auto file = listed_file(path, name)) {
      bag.paths.push_back(*file);
    } else {
      bag.notes.push_back(name + ", listed in metadata.yaml, is missing");
    }
  }
  if (!bag.paths.empty()) {
    const std::string names_of_others = unlisted(path, bag.paths);
    if (!names_of_others.empty()) {
      bag.notes.push_back("not read, since metadata.yaml does not list them: " + names_of_others);
    }
    return bag;
  }
  bag.paths = all_bag_files(path);
  if (bag.paths.empty()) return no_bag(path, bag.notes);
  if (!names.empty()) bag.notes.emplace_back("all bag files of the directory are read, by name");
  return bag;
}

}  // namespace cornerfix::evaluation
