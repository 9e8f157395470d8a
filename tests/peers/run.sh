#!/usr/bin/env bash
# Runs every peer that can be run here and appends their JSON lines to a file:
#
#     tests/peers/run.sh peers.jsonl
#
# MuJoCo needs python3 with venv and PyPI, Rapier needs cargo and crates.io; a peer that cannot be
# had is named on standard error and left out. PEERS_BUILD (default: target/peers at the root of the
# repository) keeps what is installed and built. One process and one thread at a time: run nothing
# else beside it.
set -euo pipefail

[ $# -eq 1 ] || { echo "usage: $0 FILE.jsonl" >&2; exit 2; }
here="$(cd "$(dirname "$0")" && pwd)"
out="$(realpath -m "$1")"
build="$(realpath -m "${PEERS_BUILD:-$here/../../target/peers}")"
mkdir -p "$build" "$(dirname "$out")"
export OMP_NUM_THREADS=1

# Runs a command and appends what it prints, only if all of it went well.
append() {
    local found
    if found="$("$@")"; then
        printf '%s\n' "$found" | tee -a "$out"
    else
        echo "left out: $*" >&2
    fi
}

python="$build/venv/bin/python"
if { [ -x "$python" ] || python3 -m venv "$build/venv"; } && "$python" -m pip install -q -r "$here/requirements.txt"; then
    mujoco() { append "$python" "$here/mujoco_cantilever.py" "$@"; }
    for membrane in elastic edges; do
        for hz in 30 60; do mujoco --grid 11 --grid 21 --hz "$hz" --membrane "$membrane"; done
        for hz in 60 240; do mujoco --grid 11 --grid 21 --hz "$hz" --membrane "$membrane" --case release; done
    done
else
    echo "left out: MuJoCo (no python3 with venv, or PyPI out of reach)" >&2
fi

if CARGO_TARGET_DIR="$build/rapier" cargo build --release --locked --manifest-path "$here/rapier_softbody/Cargo.toml"; then
    rapier() { append "$build/rapier/release/rapier_softbody" "$@"; }
    for hinges in lines surface; do
        for hz in 30 60; do rapier --hz "$hz" --hinges "$hinges"; done
        for hz in 60 240; do rapier --hz "$hz" --hinges "$hinges" --case release; done
    done
    rapier --solver constraints --hinges surface
else
    echo "left out: Rapier (no cargo, or crates.io out of reach)" >&2
fi
