#!/bin/sh
# check_manual.sh GROFF FOLDER: groff sets every manual page of the folder without a warning.
set -eu
for page in "$2"/*.1; do
  warnings=$("$1" -ww -z -K utf8 -T utf8 -man "$page" 2>&1)
  [ -z "$warnings" ] || { echo "$warnings"; exit 1; }
done
[ -e "$2/tanor-run.1" ]
