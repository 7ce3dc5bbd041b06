#!/usr/bin/env bash
# Starts the installed server as the service user with the command of the unit, checks it and stops it. A part of package_test.sh.
#   package_check.sh PORT
set -euo pipefail

fail() { echo "FAILED: $*" >&2; exit 1; }
url=http://127.0.0.1:$1
database=/var/lib/cornerfix/cornerfix.db
status() { curl --silent --max-time 30 --output /dev/null --write-out '%{http_code}' "$@"; }

command=$(sed -n 's/^ExecStart=//p' /lib/systemd/system/cornerfix.service)
# shellcheck disable=SC2086  # As systemd does, in words.
setpriv --reuid cornerfix --regid cornerfix --clear-groups --no-new-privs --bounding-set=-all $command &
server=$!
curl --silent --retry 60 --retry-connrefused --retry-delay 1 --output /dev/null "$url/readyz"
[[ $(stat -c %U /proc/$server) == cornerfix ]] || fail "runs as $(stat -c %U /proc/$server)"
[[ $(status "$url/readyz") == 200 ]] || fail "/readyz"
for file in / /app.js /vendor/leaflet/leaflet.js /vendor/chart/chart.min.js /demo/willow_full_0.05.png; do
  [[ $(status "$url$file") == 200 ]] || fail "the inspector: $file"
done
token=$(runuser -u cornerfix -- cornerfix token create --db $database --role admin --name operator)
[[ $(status "$url/v1/maps") == 401 ]] || fail "open in spite of a token"
[[ $(status --header "Authorization: Bearer $token" "$url/v1/maps") == 200 ]] || fail "the token is not taken"
kill -TERM $server
wait $server || fail "ended with $?"
