/// \file  Tables on standard output.
#pragma once

#include <string>
#include <vector>

namespace cornerfix::cli {

/// Columns as wide as their widest entry, two blanks between them. Rows are of one length.
void print_table(const std::vector<std::vector<std::string>>& rows);

}  // namespace cornerfix::cli
