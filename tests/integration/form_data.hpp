/// \file  Bodies of multipart/form-data.
#pragma once

#include <string>

namespace cornerfix::testing {

inline constexpr const char* kForm = "multipart/form-data; boundary=xyz";

/// One file of a form; "--xyz--\r\n" follows the last.
[[nodiscard]] inline std::string part(const std::string& name, const std::string& content) {
  return "--xyz\r\nContent-Disposition: form-data; name=\"" + name + "\"; filename=\"" + name +
         "\"\r\n\r\n" + content + "\r\n";
}

}  // namespace cornerfix::testing
