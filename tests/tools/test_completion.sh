# Completion of talus-sandbox: what bash would offer, word by word. Options and keys are those of the program that was built.
set -euo pipefail
program=$TALUS_BUILD_DIR/bin/talus-sandbox
[[ -x $program ]] || { echo "SKIPPED: $program is not built"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/folder"
touch "$work/a bed.toml" "$work/other.toml" "$work/notes.txt" "$work/costs.json"
cd "$work"
PATH=$(dirname "$program"):$PATH

# shellcheck source=/dev/null
source "$TALUS_SOURCE_DIR/apps/sandbox/talus-sandbox.bash"
compopt() { return 0; } # outside of a completion bash has none to set options of
complete -p talus-sandbox | grep -q _talus_sandbox

offers() { # EXPECTED WORD...: all that is offered for the last word, sorted
    COMP_WORDS=(talus-sandbox "${@:2}")
    COMP_CWORD=$#
    ((COMP_CWORD -= 1))
    _talus_sandbox
    local got
    got=$(printf '%s\n' "${COMPREPLY[@]}" | sort | paste -sd'|')
    [[ $got == "$1" ]] || { echo "offered \"$got\", wanted \"$1\": talus-sandbox ${*:2}" >&2; exit 1; }
}
offers_some() { # PART WORD...: this is among what is offered
    COMP_WORDS=(talus-sandbox "${@:2}")
    COMP_CWORD=$(($# - 1))
    _talus_sandbox
    printf '%s\n' "${COMPREPLY[@]}" | grep -qxF -- "$1" || { echo "did not offer $1: talus-sandbox ${*:2}" >&2; exit 1; }
}

offers 'check|keys|plan|run' ''
offers 'plan' pl
offers '--help|--version' -
offers 'a bed.toml|folder|other.toml' run ''
offers 'other.toml' check o
offers '' keys ''
offers '--steps' run --st
offers '--out' run other.toml --o
offers '' check other.toml --o # check writes nothing
offers '--latency' plan other.toml --l
offers 'folder' run other.toml --out ''
offers 'costs.json|folder' plan other.toml --costs ''
offers '' run other.toml --threads ''
offers 'sand.friction=' run --set sand.fr
offers_some 'run.threads=' run --set ''
offers_some 'other.toml' run --set run.seed=3 ''

# Every option and every key that the program has is offered, and no other. (Each look starts the program, and MPI with it.)
for command in run check plan; do
    offers "$("$program" $command --help | grep -oE '^ +(-h,)?--[a-z]+' | sed 's/.*--/--/' | sort | paste -sd'|')" $command --
done
(($(_talus_sandbox_keys "$program" | wc -l) == $("$program" keys | grep -cE '^  [a-z_]+ '))) || { echo "keys are missed" >&2; exit 1; }
