#!/usr/bin/env bash
# Makes a man page of each command from its --help: cornerfix.1.gz, cornerfix-map.1.gz, cornerfix-map-build.1.gz, ...
#   scripts/man_pages.sh PROGRAM DIRECTORY
set -euo pipefail

program=$1
directory=$2
version=$("$program" --version)

# The first line of the help.
meaning() { "$program" "$@" --help | sed '/^Usage:/d; /^$/d; q'; }

# Those that the help lists, one per line.
subcommands() { "$program" "$@" --help | sed -n '/^Subcommands:/,/^$/ s/^  \([a-z0-9]\+\) .*/\1/p'; }

page() {
  local name command
  name=$(IFS=- && echo "cornerfix${*:+-}$*")
  help2man --no-info --section 1 --name "$(meaning "$@")" --source "$version" --manual "Cornerfix" \
    --version-string "$name ${version#* }" "$program $*" | gzip -9n >"$directory/$name.1.gz"
  for command in $(subcommands "$@"); do page "$@" "$command"; done
}

rm -rf "$directory"
mkdir -p "$directory"
page
