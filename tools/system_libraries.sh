#!/usr/bin/env bash
# Make sure that the system libraries are there which Python packages cannot bring along.
# Installs them where it may (root, or sudo without a password); else names them with their cure.
# With "peers" as the second argument: the programs that tests compare ballesta with, and the browser
# that they open its pages in. Tests skip what is missing, so these are named and never an error.
set -euo pipefail
python=${1:-python3}

wanted=(libgl1 libegl1 libglu1-mesa libxft2 libxcursor1 libxinerama1 libgomp1   # gmsh and VTK
        libsuitesparse-dev gcc                                                # CHOLMOD's wrapper
        libopenblas0-pthread)                         # CHOLMOD is 3 times slower on plain BLAS
"$python" -c 'import ensurepip, venv' 2>/dev/null || wanted+=(python3-venv)
"$python" - <<'PY' || wanted+=(python3-dev)
import os, sys, sysconfig
sys.exit(not os.path.exists(os.path.join(sysconfig.get_path("include"), "Python.h")))
PY

need=2
if [ "${2:-}" = peers ]; then
  wanted=(calculix-ccx   # a peer in solid mechanics
          chromium)      # opens the reports in tests
  need=0
fi

if ! command -v dpkg-query >/dev/null; then
  echo "ballesta: not a Debian or Ubuntu system; it needs the equivalents of: ${wanted[*]}" >&2
  exit 0
fi
missing=()
for package in "${wanted[@]}"; do
  # newer releases carry the t64 name of some libraries
  known=$(dpkg-query -W -f '${db:Status-Status}\n' "$package" "${package}t64" 2>/dev/null || true)
  grep -qx installed <<<"$known" || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0

cure="apt-get install -y --no-install-recommends ${missing[*]}"
if [ "$(id -u)" -eq 0 ]; then
  sudo=()
elif command -v sudo >/dev/null && sudo -n true 2>/dev/null; then
  sudo=(sudo -n)
else
  echo "ballesta: system packages are missing; cure: sudo $cure" >&2
  exit $need
fi
echo "installing system packages: ${missing[*]}"
export DEBIAN_FRONTEND=noninteractive
if ! { "${sudo[@]}" apt-get update -qq && "${sudo[@]}" $cure >/dev/null; }; then
  echo "ballesta: this failed: $cure" >&2
  exit $need
fi
