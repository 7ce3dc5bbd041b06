/// \file  Which of the lidars of a log of lines is taken, and what else there is.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace cornerfix::evaluation {

/// Takes the scans of one name: the chosen one, or else that of the first good scan.
class LidarChoice {
 public:
  explicit LidarChoice(std::optional<std::string> chosen) : chosen_(std::move(chosen)) {}

  /// Whether a scan of this name is to be taken. Those that are not are counted.
  [[nodiscard]] bool is_wanted(const std::string& name) {
    if (!chosen_ || *chosen_ == name) return true;
    const auto known = std::ranges::find(others_, name, &Other::name);
    if (known != others_.end()) {
      ++known->scans;
    } else if (others_.size() < kMostNames) {
      others_.push_back({name, 1});
    }
    return false;
  }

  /// A good scan of this name was taken.
  void take(const std::string& name) {
    if (!chosen_) chosen_ = name;
    has_taken_ = true;
  }

  /// "scans of front only, not of rear; --lidar chooses"; empty while there is nothing to choose.
  [[nodiscard]] std::string choice() const {
    if (!has_taken_ || others_.empty()) return "";
    return "scans of " + shown(*chosen_) + " only, not of " + shown(others_.front().name) +
           "; --lidar chooses";
  }

  /// What there is instead, when no scan was taken.
  [[nodiscard]] std::string contents() const {
    std::string text;
    for (const Other& other : others_) {
      text += (text.empty() ? "its scans are of " : ", ") + shown(other.name) + " (" +
              std::to_string(other.scans) + ")";
    }
    return text;
  }

 private:
  struct Other {
    std::string name;
    std::size_t scans = 0;
  };
  static constexpr std::size_t kMostNames = 20;

  static std::string shown(const std::string& name) {
    constexpr std::size_t kLongest = 40;
    return name.empty() ? "a lidar without a name" : name.substr(0, kLongest);
  }

  std::optional<std::string> chosen_;
  bool has_taken_ = false;
  std::vector<Other> others_;
};

}  // namespace cornerfix::evaluation
