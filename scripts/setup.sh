#!/usr/bin/env bash
# Installs what the build needs: Debian packages (only those missing), and a static Ceres without
# logging, built from Debian's source package into a per-user cache. Safe to run again; quick when
# there is nothing to do.
#
#   scripts/setup.sh [--full]     --full also installs clang, clang-tidy, clang-format and libFuzzer
#
#   PLED_CACHE   where Ceres goes (default: ${XDG_CACHE_HOME:-$HOME/.cache}/pled-vins)
#   PLED_JOBS    compile jobs (default: processors, but no more than one per GiB of free memory)
set -euo pipefail
export LC_ALL=C DEBIAN_FRONTEND=noninteractive

# shellcheck source=scripts/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

readonly ceres_version=2.1.0
readonly cache=${PLED_CACHE:-${XDG_CACHE_HOME:-${HOME:?HOME is not set: set PLED_CACHE}/.cache}/pled-vins}

readonly packages=(
  build-essential dpkg-dev cmake ninja-build ccache xz-utils
  libeigen3-dev libopencv-core-dev libopencv-imgproc-dev
  libyaml-cpp-dev libcli11-dev nlohmann-json3-dev
  libpng-dev libjpeg62-turbo-dev liblz4-dev libzstd-dev libusb-1.0-0-dev doctest-dev
)
readonly full_packages=(clang clang-tidy clang-format libclang-rt-14-dev)

# Silent (the log level), no LAPACK or SuiteSparse, no fused arithmetic; the Schur complement compiled
# for the block sizes of specialise_schur.
readonly ceres_flags=(
  -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_STANDARD=17 "-DCMAKE_CXX_FLAGS=-w -ffp-contract=off"
  -DBUILD_SHARED_LIBS=OFF -DCMAKE_POSITION_INDEPENDENT_CODE=ON
  -DMINIGLOG=ON -DMINIGLOG_MAX_LOG_LEVEL=-2 -DGFLAGS=OFF
  -DSUITESPARSE=OFF -DCXSPARSE=OFF -DACCELERATESPARSE=OFF -DEIGENSPARSE=ON -DLAPACK=OFF -DCUDA=OFF
  -DSCHUR_SPECIALIZATIONS=ON
  -DBUILD_TESTING=OFF -DBUILD_EXAMPLES=OFF -DBUILD_BENCHMARKS=OFF -DBUILD_DOCUMENTATION=OFF
  -DPROVIDE_UNINSTALL_TARGET=OFF -DEXPORT_BUILD_DIR=OFF
)

say() { printf 'setup: %s\n' "$*"; }
fail() { printf 'setup: error: %s\n' "$*" >&2; exit 1; }

as_root() {
  if [[ $(id -u) -eq 0 ]]; then
    "$@"
  elif command -v sudo >/dev/null; then
    say "using sudo for: $*" >&2
    sudo DEBIAN_FRONTEND=noninteractive "$@"
  else
    fail "installing packages needs root, and there is no sudo. Run as root: $*"
  fi
}

check_system() {
  if command -v apt-get >/dev/null && command -v dpkg-query >/dev/null; then return 0; fi
  fail "this system has no apt-get. Debian 12 is supported; elsewhere install the equivalents of:
  ${packages[*]}
and Ceres $ceres_version, then point the CMake variable PLED_CERES_ROOT at it."
}

install_packages() {
  local wanted=("$@") missing=() installed package
  installed=$(dpkg-query -W -f='${db:Status-Status} ${binary:Package}\n' "${wanted[@]}" 2>/dev/null |
    sed -n 's/^installed \([^:]*\).*/\1/p' || true)
  for package in "${wanted[@]}"; do
    grep -qxF -- "$package" <<<"$installed" || missing+=("$package")
  done
  [[ ${#missing[@]} -gt 0 ]] || return 0

  say "installing ${missing[*]}"
  local install=(apt-get -qq -y -o DPkg::Lock::Timeout=300 -o Dpkg::Use-Pty=0
    install --no-install-recommends "${missing[@]}")
  if ! apt-cache show "${missing[@]}" >/dev/null 2>&1 || ! as_root "${install[@]}" </dev/null >/dev/null; then
    say "refreshing the package lists"
    as_root apt-get -qq -o DPkg::Lock::Timeout=300 update </dev/null ||
      fail "apt-get update failed: is there a network, and are the apt sources right?"
    as_root "${install[@]}" </dev/null >/dev/null ||
      fail "apt-get could not install: ${missing[*]}"
  fi
}

# Writes a sources file for this release's source packages, from the machine's own apt sources.
write_source_list() {
  local codename entries kind keys=
  local keyring=/usr/share/keyrings/debian-archive-keyring.gpg
  if [[ -f $keyring ]]; then keys="Signed-By: $keyring"$'\n'; fi
  codename=$(. /etc/os-release && printf '%s' "${VERSION_CODENAME:-}")
  for kind in deb-src deb; do
    # shellcheck disable=SC2016  # apt's own names
    entries=$(apt-get indextargets --no-release-info \
      --format '$(TARGET_OF)|$(RELEASE)|$(COMPONENT)|$(REPO_URI)' |
      awk -F'|' -v kind="$kind" -v codename="$codename" -v keys="$keys" \
        '$1 == kind && $2 == codename && $3 == "main" && !seen[$4]++ {
           printf "Types: deb-src\nURIs: %s\nSuites: %s\nComponents: main\n%s\n", $4, $2, keys }')
    if [[ -n $entries ]]; then
      printf '%s\n' "$entries" >"$1"
      return 0
    fi
  done
  fail "apt has no source for '$codename main', so the Ceres source package cannot be found.
Add a deb or deb-src entry for it, or build Ceres $ceres_version yourself and set PLED_CERES_ROOT."
}

# Fetches and unpacks the source package in directory $1, with apt's checks, touching no apt state.
fetch_ceres() {
  local dir=$1
  mkdir -p "$dir"/{lists,cache/archives}/partial
  write_source_list "$dir/ceres.sources"
  local apt=(apt-get -qq -o "Dir::Etc::sourcelist=$dir/ceres.sources" -o Dir::Etc::sourceparts=-
    -o "Dir::State::lists=$dir/lists" -o "Dir::Cache=$dir/cache" -o "APT::Sandbox::User=$(id -un)"
    -o APT::Get::List-Cleanup=0)
  "${apt[@]}" update </dev/null ||
    fail "could not read the source package lists (the sources used: $(grep URIs "$dir/ceres.sources"))"
  (cd "$dir" && "${apt[@]}" source ceres-solver </dev/null >"$dir/source.log" 2>&1) ||
    { cat "$dir/source.log" >&2; fail "could not fetch the source package ceres-solver"; }
  local unpacked=("$dir"/ceres-solver-*/)
  [[ -f ${unpacked[0]}/CMakeLists.txt ]] || fail "the source package ceres-solver has no CMakeLists.txt"
  mv "${unpacked[0]}" "$dir/src"
  grep -q "CERES_VERSION_MINOR ${ceres_version:2:1}" "$dir/src/include/ceres/version.h" ||
    fail "this release's source package is not Ceres $ceres_version"
}

# Ceres compiles its Schur complement for a list of block sizes, which costs ten minutes. Our points
# are 3 numbers seen in 2 rows: this keeps (2, 3, 6), (2, 3, any) and (2, any, any) and drops the
# others. $1 is the directory internal/ceres of the source.
specialise_schur() {
  local dir=$1 kind file
  for kind in schur_eliminator partitioned_matrix_view; do
    find "$dir/generated" -name "${kind}_*" ! -name '*_2_3_6.cc' ! -name '*_2_3_d.cc' \
      ! -name '*_d_d.cc' -delete
  done
  for file in schur_eliminator.cc partitioned_matrix_view.cc schur_templates.cc; do
    awk '
      /^#ifndef CERES_RESTRICT_SCHUR_SPECIALIZATION/ { listing = 1; print; next }
      /^#endif/ { listing = 0 }
      !listing { print; next }
      { block = block $0 "\n" }
      /^  }/ {
        any_e = block ~ /if \(options.row_block_size == 2\)/
        ours = block ~ /row_block_size == 2/ && block ~ /e_block_size == 3\)/ &&
               (block ~ /f_block_size == 6/ || block !~ /f_block_size == /)
        if (any_e || ours) { printf "%s", block; kept++ }
        block = ""
      }
      END { exit kept == 3 ? 0 : 1 }' "$dir/$file" >"$dir/$file.new" ||
      fail "this source of Ceres lists its block sizes in another way: $file"
    mv "$dir/$file.new" "$dir/$file"
  done
}

# Builds Ceres in a directory of its own and moves the finished tree to $1 in one step.
build_ceres() {
  local prefix=$1 jobs started=$SECONDS
  jobs=$(compile_jobs)
  rm -rf -- "$cache"/build.*  # what an interrupted run left; the lock is ours
  work=$(mktemp -d "$cache/build.XXXXXX")
  trap 'rm -rf -- "$work"' EXIT
  trap 'exit 130' INT TERM
  say "building Ceres $ceres_version with $jobs jobs (once; 4 to 10 minutes)"
  fetch_ceres "$work"
  specialise_schur "$work/src/internal/ceres"
  cmake -G Ninja -S "$work/src" -B "$work/b" -DCMAKE_INSTALL_PREFIX="$prefix" "${ceres_flags[@]}" \
    >"$work/cmake.log" 2>&1 || { tail -n 40 "$work/cmake.log" >&2; fail "configuring Ceres failed"; }
  ninja -C "$work/b" -j "$jobs" >"$work/ninja.log" 2>&1 ||
    { tail -n 40 "$work/ninja.log" >&2; fail "building Ceres failed"; }
  DESTDIR="$work/stage" cmake --install "$work/b" >"$work/install.log" 2>&1 ||
    { tail -n 40 "$work/install.log" >&2; fail "installing Ceres failed"; }
  rm -rf -- "$prefix"
  mv -T -- "$work/stage$prefix" "$prefix"
  say "Ceres built in $((SECONDS - started)) s: $prefix"
}

install_ceres() {
  local recipe prefix
  # Whatever changes the result is in the name, so an old build is never taken for a new one.
  recipe=$(printf '%s\n' "${ceres_flags[@]}" "$(declare -f specialise_schur)" "$(c++ -dumpmachine)" "$(c++ -dumpfullversion)" \
    "$(dpkg-query -W -f='${Version}' libeigen3-dev)" | sha256sum)
  prefix=$cache/ceres-$ceres_version-${recipe:0:12}
  if [[ ! -d $prefix ]]; then
    mkdir -p "$cache" 2>/dev/null || fail "cannot create $cache: set PLED_CACHE to a folder that can be written"
    exec 9>"$cache/lock"
    flock -n 9 || { say "waiting for another setup that builds Ceres"; flock 9; }
    [[ -d $prefix ]] || build_ceres "$prefix"
  fi
  if [[ $(readlink "$cache/ceres" || true) != "${prefix##*/}" ]]; then
    ln -sfn "${prefix##*/}" "$cache/ceres.new.$$"
    mv -T "$cache/ceres.new.$$" "$cache/ceres"
  fi
}

main() {
  local full=0
  case ${1:-} in
    '') ;;
    --full) full=1 ;;
    -h | --help) sed -n '2,/^set /{/^set /d;s/^# \{0,1\}//;p}' "${BASH_SOURCE[0]}"; return 0 ;;
    *) fail "unknown option '$1' (there is --full)" ;;
  esac
  check_system
  install_packages "${packages[@]}"
  if [[ $full -eq 1 ]]; then install_packages "${full_packages[@]}"; fi
  install_ceres
  say "ready"
}

main "$@"
