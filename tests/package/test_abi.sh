# timeout: 60
# What programs compiled against the baseline of capi/abi rely on is still so in talus.h: functions, their signatures, layouts
# of structs and values of constants. Additions pass. Then the gate itself is tried, on headers that were broken on purpose.
set -euo pipefail
command -v abidiff >/dev/null || { echo "SKIPPED: abidiff is missing; tools/setup installs it (abigail-tools)"; exit 77; }

source_dir=$TALUS_SOURCE_DIR
baseline=$source_dir/capi/abi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# HEADER: 0 if it keeps what the baseline promises. Output is the difference.
keeps_promises() {
    local code=0
    "$source_dir/tools/abi-baseline" --header "$1" --to "$work/new" || return 99
    # Any bit set is a finding: 4 a type changed, 8 incompatibly so, 12 a symbol is gone; 1 and 2 are errors of use.
    abidiff --no-added-syms --suppressions "$baseline/allowed.abignore" \
        "$baseline/libtalus.so.0.abi" "$work/new/libtalus.so.0.abi" || code=$?
    # Lines may be added, none may change: see tools/abi-baseline.
    if ! LC_ALL=C comm -23 "$baseline/numbers.txt" "$work/new/numbers.txt" >"$work/gone"; then code=99; fi
    if [[ -s $work/gone ]]; then
        echo "constants or members that changed, moved or are gone:"
        cat "$work/gone"
        code=4
    fi
    return $code
}

header=$source_dir/capi/include/talus.h
keeps_promises "$header" || {
    echo "talus.h breaks programs compiled before (code $?). If that is meant, capi/ABI.md tells what else to do" >&2
    exit 1
}

# SED SCRIPT, PASSES 0 or 1: what the gate says to a header changed like this.
try() {
    local code=0
    sed -E "$1" "$header" >"$work/talus.h"
    ! cmp -s "$header" "$work/talus.h" || { echo "nothing was changed by $1" >&2; exit 1; }
    keeps_promises "$work/talus.h" >"$work/log" 2>&1 || code=$?
    ((code != 99)) || { cat "$work/log" >&2; exit 1; }
    (((code == 0) == $2)) || { cat "$work/log" >&2; echo "the gate gave $code to: $1" >&2; exit 1; }
}
try 's/^TALUS_API int32_t talus_version.*/&\nTALUS_API int32_t talus_new(void);/' 1                # a function more
try 's/^#define TALUS_STOPPED 1.*/&\n#define TALUS_ERR_NEW (-77)/' 1                              # a constant more
try 's/^\} talus_state;/    double more;\n&/' 1                                                   # a member more, at the end
try 's/^\} talus_settings;/    double more[3];\n&/' 1
try 's/^    int32_t reserved;$/    int32_t sense;/' 1                                                # reserved room put to use
try 's/^TALUS_API int32_t talus_version.*//' 0                                                    # a function less
try 's/^(TALUS_API .*talus_engine_step\(.*)int64_t n_steps/\1int32_t n_steps/' 0                  # another argument
try 's/^TALUS_API int32_t talus_version/TALUS_API int64_t talus_version/' 0                       # another result
try 's/(^ *)double time; .*/\1double more;\n&/' 0                                                 # a member in between
try 's/^( *)int32_t periodic\[3\];/\1int32_t periodic[4];/' 0                                     # an array that grew
try 's/^\} talus_laws;/    double more;\n&/' 0                                                    # inside talus_settings
try 's/^\} talus_phase;/    double more;\n&/' 1                                                   # in an array of the caller's stride
try 's/^\} talus_rank;/    double more;\n&/' 1
try 's/^(#define TALUS_ERR_IO) .*/\1 (-15)/' 0                                                    # another number
try 's/^#define TALUS_FIELD_OWNER .*//' 0                                                         # a constant less
