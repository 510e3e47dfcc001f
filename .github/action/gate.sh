#!/usr/bin/env bash
# The steps of the action, and of other CI servers: gate.sh install | run | gate.
#
#   install  the wheel WHEEL: a path, an address with #sha256=SUM, or a version of the source by git; or the program of ARCHIVE,
#            a .tar.gz of a release, by path or address with #sha256=SUM; if both are unset, or ARCHIVE cannot be had, what is
#            built from the source that this script is a part of
#   run      scanbench run $RUN, with page and recording, into OUTPUT/run
#   gate     holds it to BASELINE, with its verdict in OUTPUT/verdict; ends with the exit code of the gate
#
# Reports the result to GitHub through GITHUB_PATH, GITHUB_OUTPUT and GITHUB_STEP_SUMMARY, where these are set.
set -euo pipefail

source_folder=$(cd "$(dirname "$0")/../.." && pwd)
output=${OUTPUT:-runs/gate}

# set_output NAME VALUE: a result of the step, in a line.
set_output() {
    if [[ -n "${GITHUB_OUTPUT:-}" ]]; then
        printf '%s=%s\n' "$1" "${2//$'\n'/ }" >> "$GITHUB_OUTPUT"
    fi
}

# have_archive: leaves the program of ARCHIVE in $program_folder. Fails where it cannot be had; ends all where it is another.
have_archive() {
    local from=${ARCHIVE%#sha256=*} sum=${ARCHIVE##*#sha256=} archive
    local sealed='^([^-:][^:]*|https://.+)\.tar\.gz#sha256=[0-9a-f]{64}$'
    [[ "$ARCHIVE" =~ $sealed ]] || { echo "archive is not pinned: $ARCHIVE" >&2; exit 2; }
    program_folder=${RUNNER_TEMP:-$HOME/.cache}/scanbench-$sum
    archive=$program_folder/archive.tar.gz
    mkdir -p "$program_folder"
    if [[ "$from" == https://* ]]; then
        curl --fail --silent --show-error --location --proto =https --retry 3 --output "$archive" "$from" || return 1
    else
        cp "$from" "$archive" || return 1
    fi
    sha256sum --check --quiet <<< "$sum  $archive" >&2 || exit 2
    tar -xzf "$archive" -C "$program_folder" --strip-components=1 || exit 2
}

# found_in FOLDER: its program comes before any other, in later steps, too.
found_in() {
    PATH=$1:$PATH
    [[ -z "${GITHUB_PATH:-}" ]] || echo "$1" >> "$GITHUB_PATH"
}

install() {
    local program_folder
    if [[ -n "${WHEEL:-}" ]]; then
        # No package index has scanbench: whoever takes the name there could run anything here. pip compares the checksum.
        local pinned='^([^-:][^:]*\.whl|https://.+\.whl#sha256=[0-9a-f]{64}|git\+https://.+/[^/@]+@[^#]+#subdirectory=.+)$'
        [[ "$WHEEL" =~ $pinned ]] || { echo "wheel is not pinned: $WHEEL" >&2; exit 2; }
        python3 -m pip install --quiet --disable-pip-version-check "$WHEEL"
    elif [[ -n "${ARCHIVE:-}" ]] && have_archive; then
        found_in "$program_folder"
    else
        # Even if there is a program on the PATH: it may be another version than the action.
        local target
        target=$(realpath -m "${CARGO_TARGET_DIR:-$HOME/.cache/scanbench-target}")
        # There, so that rustup takes the toolchain of the source.
        (cd "$source_folder" && CARGO_TARGET_DIR=$target cargo build --release --locked)
        found_in "$target/release"
    fi
    scanbench --version
}

run() {
    # Words as a shell reads them, quotes included, without anything else that a shell does.
    local words
    mapfile -d '' -t words < <(xargs printf '%s\0' <<< "${RUN:?the arguments of scanbench run}")
    wait "$!" # what xargs says of a quote that is not closed
    scanbench run "${words[@]}" -o "$output/run" --overwrite
    set_output page "$output/run/report.html"
}

gate() {
    local options=(--baseline "${BASELINE:?the folder of the baseline}" -o "$output/verdict") code=0
    [[ -z "${TOLERANCES:-}" ]] || options+=(--tolerances "$TOLERANCES")
    [[ -z "${ALLOW_DRIFT:-}" ]] || options+=("--allow-drift=$ALLOW_DRIFT")
    [[ -z "${GITHUB_STEP_SUMMARY:-}" ]] || printf '## scanbench\n\n' >> "$GITHUB_STEP_SUMMARY"
    mkdir -p "$output"
    # Adds the verdict to the summary by itself.
    scanbench gate "$output/run" "${options[@]}" > "$output/gate.txt" || code=$?
    cat "$output/gate.txt"
    set_output headline "$(head -n 1 "$output/gate.txt")"
    set_output exit-code "$code"
    exit "$code"
}

case "${1:-}" in
    install | run | gate) "$1" ;;
    *) echo "usage: gate.sh install | run | gate" >&2; exit 2 ;;
esac
