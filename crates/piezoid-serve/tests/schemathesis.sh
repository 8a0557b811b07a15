#!/usr/bin/env bash
# Requests made from /api/openapi.json, good ones and bad ones: no answer may be an error of the server, and each must be as described.
# Needs `pip install schemathesis`; the program is `piezoid`, or the first argument. Further arguments go to schemathesis.
set -euo pipefail
program=$(command -v "${1:-piezoid}")
folder=$(mktemp -d)
cd "$folder"
"$program" serve "$folder/project" --port 0 --limit 1 >"$folder/told" &
server=$!
trap 'kill -INT $server; wait $server; cd /; rm -r "$folder"' EXIT
until grep -q Ctrl-C "$folder/told"; do sleep 0.05; done
address=$(grep -o 'http://[^?]*' "$folder/told")
key="Authorization: Bearer $(cat "$folder/project/.piezoid-key")"
curl --silent --fail --header "$key" "$address"api/openapi.json >"$folder/openapi.json"
# A version that is not there is refused with 412, as described.
cat >"$folder/schemathesis.toml" <<'END'
[checks.positive_data_acceptance]
expected-statuses = ["2xx", "3xx", "401", "403", "404", "409", "412", "429", "5xx"]
[checks.negative_data_rejection]
expected-statuses = ["400", "401", "403", "404", "405", "406", "409", "412", "415", "422", "428", "429"]
END
schemathesis --config-file "$folder/schemathesis.toml" run "$folder/openapi.json" --url "$address" --header "$key" "${@:2}"
