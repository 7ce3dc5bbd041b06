#!/usr/bin/env bash
# A PostgreSQL server for tests, on a Unix socket in DIRECTORY and on no port.
#   postgresql.sh start DIRECTORY OWNER   makes the cluster when there is none and starts the server;
#                                         it stops by itself when the process OWNER has ended
#   postgresql.sh stop DIRECTORY          as an operator does
#   postgresql.sh crash DIRECTORY         at once, as a crash does
# Its databases: postgresql:///NAME?host=DIRECTORY&user=cornerfix
# Exits with 77 where PostgreSQL is not installed.
set -euo pipefail
action=$1 directory=$2 owner=${3:-}

programs=$(find /usr/lib/postgresql -maxdepth 2 -name bin 2>/dev/null | sort -V | tail -1)
if [[ -z $programs ]]; then
  echo "PostgreSQL is not installed: install postgresql" >&2
  exit 77
fi
run=()
# PostgreSQL refuses to run as root.
[[ $(id -u) -ne 0 ]] || run=(setpriv --reuid=postgres --regid=postgres --init-groups)
in_cluster() { (cd / && "${run[@]}" "$programs/$1" -D "$directory/data" "${@:2}"); }

case $action in
  start)
    if [[ ! -d $directory/data ]]; then
      mkdir -p "$directory"
      [[ $(id -u) -ne 0 ]] || chown postgres "$directory"
      # A locale whose order of names is not that of their bytes.
      in_cluster initdb -A trust -U cornerfix -E UTF8 --locale=C.UTF-8 --locale-provider=icu \
        --icu-locale=en --no-sync >"$directory/initdb.log"
    fi
    in_cluster pg_ctl -s -w -l "$directory/data/server.log" \
      -o "-c listen_addresses='' -c unix_socket_directories='$directory' -c fsync=off -c full_page_writes=off" start >/dev/null
    if [[ -n $owner ]]; then
      # The streams are closed, so that a caller which reads them does not wait for this.
      (tail --pid="$owner" -f /dev/null && in_cluster pg_ctl -s -m immediate stop) \
        </dev/null >/dev/null 2>&1 &
    fi
    ;;
  stop) in_cluster pg_ctl -s -w -m fast stop ;;
  crash) in_cluster pg_ctl -s -w -m immediate stop ;;
  *) echo "usage: $0 start|stop|crash DIRECTORY [OWNER]" >&2; exit 2 ;;
esac
