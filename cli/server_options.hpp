/// \file  Options of the commands that are clients of a server.
#pragma once

#include <CLI/CLI.hpp>

#include "clients/cpp/server_connection.hpp"

namespace cornerfix::cli {

/// --server and --token.
void add_server_options(CLI::App& command, client::ServerAddress& server);

/// --server, --token and --print-curl.
void add_connection_options(CLI::App& command, client::ConnectionOptions& options);

}  // namespace cornerfix::cli
