#!/usr/bin/env bash
# Installs Chromium on Debian and its relatives: the test of the HTML report drives it, and skips without it.
set -euo pipefail

if command -v chromium >/dev/null || command -v google-chrome >/dev/null; then
    echo "a browser is already installed"
    exit 0
fi
if ! command -v apt-get >/dev/null; then
    echo "this is no Debian: install Chromium with your package manager" >&2
    exit 2
fi
as_root=()
if [ "$(id -u)" -ne 0 ]; then
    as_root=(sudo)
fi
"${as_root[@]}" apt-get update -q
DEBIAN_FRONTEND=noninteractive "${as_root[@]}" apt-get install -y -q --no-install-recommends chromium
