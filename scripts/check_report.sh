#!/usr/bin/env bash
# Opens pages of `pled-vins report` in headless Chromium: no message on the console, no request to
# anywhere, and screenshots at the widths of a desk and a phone to look at.
#
#   scripts/check_report.sh PAGE.html...
#   scripts/check_report.sh --picture OUT.png PAGE.html    the picture of the README: a page's upper part
#
# Screenshots go to build/report/. Chromium is no dependency: where there is none, nothing is checked and
# the script says so. CHROMIUM names another one.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

case ${1:-} in
  '' | -h | --help) sed -n '2,/^set /{/^set /d;s/^# \{0,1\}//;p}' "${BASH_SOURCE[0]}"; [[ -n ${1:-} ]]; exit ;;
esac

chromium=${CHROMIUM:-$(command -v chromium chromium-browser google-chrome | head -n 1 || true)}
if [[ -z $chromium ]]; then
  echo "check_report: skipped: no Chromium here (on Debian: apt-get install chromium)"
  exit 0
fi

out=build/report
extra=()
mkdir -p "$out"
profile=$(mktemp -d)
trap 'rm -rf -- "$profile"' EXIT

# open_page PAGE WIDTH HEIGHT NAME: a screenshot, the console in NAME.console, requests in NAME.net.
open_page() {
  local flags=(--headless=new --disable-gpu --hide-scrollbars --no-first-run --disable-extensions
    --disable-background-networking --disable-component-update --disable-sync --disable-default-apps
    --host-resolver-rules='MAP * ~NOTFOUND' --user-data-dir="$profile" --virtual-time-budget=8000 --enable-logging=stderr --v=0)
  # Root may not use Chromium's sandbox; the page is our own.
  if [[ $(id -u) -eq 0 ]]; then flags+=(--no-sandbox); fi
  flags+=("${extra[@]}")
  timeout 120 "$chromium" "${flags[@]}" --window-size="$2,$3" --log-net-log="$out/$4.net" \
    --screenshot="$out/$4.png" "file://$1" >"$out/$4.log" 2>&1
  grep ':CONSOLE' "$out/$4.log" >"$out/$4.console" || true
}

# A narrow window is widened by some versions of Chromium; a frame inside the window never is.
phone_page() {
  printf '<!doctype html><body style="margin:0"><iframe src="file://%s" style="border:0;width:390px;height:%spx">' \
    "$1" "$2" >"$out/phone.html"
  open_page "$PWD/$out/phone.html" 390 "$2" "$3"
}

if [[ $1 == --picture ]]; then
  [[ $# -eq 3 ]] || { echo "check_report: --picture needs OUT.png and a page (see --help)" >&2; exit 2; }
  page=$(realpath "$3")
  extra=(--force-device-scale-factor=0.7)
  open_page "$page" 1280 1790 picture
  mv -- "$out/picture.png" "$2"
  exit
fi

failed=0
for page in "$@"; do
  page=$(realpath "$page")
  name=$(basename "$(dirname "$page")")-$(basename "$page" .html)
  open_page "$page" 1280 4200 "$name-1280"
  phone_page "$page" 6800 "$name-390"
  for width in 1280 390; do
    console=$out/$name-$width.console
    if [[ ! -s $out/$name-$width.png ]]; then
      echo "check_report: $page at $width px: no screenshot was made, see $out/$name-$width.log" >&2
      failed=1
    fi
    if [[ -s $console ]]; then
      echo "check_report: $page at $width px: the console says:" >&2
      cat "$console" >&2
      failed=1
    fi
    # What the page asked for; what the browser does on its own account has no origin.
    requests=$(grep '"initiator":' "$out/$name-$width.net" | grep -v '"initiator":"not an origin"' |
      grep -o '"url":"[^"]*"' | grep -v -e '"url":"file:' -e '"url":"data:' || true)
    if [[ -n $requests ]]; then
      printf 'check_report: %s at %s px: the page asked for\n%s\n' "$page" "$width" "$requests" >&2
      failed=1
    fi
  done
  echo "$page: $(stat -c %s "$page") bytes, screenshots $out/$name-1280.png and $out/$name-390.png"
done
exit "$failed"
