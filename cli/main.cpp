#include "cli/command_line.hpp"

int main(int argc, char** argv) { return cornerfix::cli::run_command_line(argc, argv); }
