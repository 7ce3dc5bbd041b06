/// \file  How long work shows how far it is, and learns that it is to be given up.
#pragma once

#include <functional>
#include <string_view>

namespace cornerfix::server {

/// Called when a stage begins and as it goes on, with the share of the whole work that is done, in
/// [0, 1]. The work is given up when it returns false; what it would have changed stays.
using WorkProgress = std::function<bool(std::string_view stage, double share)>;

}  // namespace cornerfix::server
