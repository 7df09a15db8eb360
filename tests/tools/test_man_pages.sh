# Man pages format without a warning, name the options that --help does and no others, and no function that is not there.
set -euo pipefail
source_dir=$TALUS_SOURCE_DIR
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
skipped=()
pages=("$source_dir"/apps/sandbox/talus-sandbox.1 "$source_dir"/apps/bench/talus-bench.1 "$source_dir"/capi/man/talus.3)
fail() {
    echo "$*" >&2
    exit 1
}

if command -v groff >/dev/null; then
    for page in "${pages[@]}"; do
        groff -mandoc -Tutf8 -ww -z "$page" 2>"$work/warnings"
        [[ ! -s $work/warnings ]] || fail "$page: $(cat "$work/warnings")"
    done
else
    skipped+=(groff)
fi

for page in "${pages[@]:0:2}"; do
    name=$(basename "$page" .1)
    program=$TALUS_BUILD_DIR/bin/$name
    [[ -x $program ]] || { skipped+=("$name"); continue; }
    commands=('')
    [[ $name != talus-sandbox ]] || commands+=(run check plan keys)
    for command in "${commands[@]}"; do
        "$program" ${command:+"$command"} --help | sed -nE 's/^  (-[a-z],)?--([a-z-]+)( .*)?$/\2/p'
    done | sort -u >"$work/in_program"
    grep -oE 'Fl -[a-z-]+' "$page" | sed 's/Fl -//' | sort -u >"$work/in_page"
    diff "$work/in_program" "$work/in_page" >"$work/difference" || fail "options of $name (<) and of its page (>) differ:
$(cat "$work/difference")"
done

for name in $(sed -nE 's/^\.(Fn|Dv|Vt|It Dv) ((talus|TALUS)_[A-Za-z_]+).*/\2/p' "${pages[2]}"); do
    grep -qw "$name" "$source_dir/capi/include/talus.h" || fail "talus.3 names $name, which talus.h does not have"
done

if ((${#skipped[@]})); then
    echo "SKIPPED, not there: ${skipped[*]}; all others are clean"
    exit 77
fi
