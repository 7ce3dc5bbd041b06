/// \file  The line of the log about a request.
#pragma once

#include "server/request_body.hpp"

namespace cornerfix::server {

void log_exchange(const Exchange& exchange, int status, double ms);

}  // namespace cornerfix::server
