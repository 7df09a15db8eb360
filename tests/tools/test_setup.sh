# tools/setup, with stand-ins for apt and dpkg: silent when nothing is missing, one line and only the missing packages
# otherwise, plain errors, through sudo for those who are not root. Touches neither the system nor the network.
set -euo pipefail
setup=$TALUS_SOURCE_DIR/tools/setup
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
chmod 755 "$work"
mkdir "$work/bin"

# ABSENT lists what dpkg does not know; apt-get notes how it was called, and fails when FAIL is set.
cat >"$work/bin/dpkg-query" <<'SH'
#!/bin/bash
status=0
for package in "${@:3}"; do
    if [[ " $ABSENT " == *" $package "* ]]; then status=1; else echo "installed $package"; fi
done
exit $status
SH
cat >"$work/bin/apt-get" <<'SH'
#!/bin/bash
echo "$*" >>"$CALLS"
echo "E: the disk is full"
[[ -z ${FAIL:-} ]]
SH
cat >"$work/bin/sudo" <<'SH'
#!/bin/bash
echo sudo >>"$CALLS"
exec "$@"
SH
chmod 755 "$work/bin"/*

as=()
run() { # run ABSENT [NAME=VALUE...]: leaves the outcome in status, and in the files out, err and calls
    : >"$work/calls"
    chmod 666 "$work/calls"
    status=0
    "${as[@]}" env PATH="$work/bin:$PATH" CALLS="$work/calls" ABSENT="$@" bash "$setup" >"$work/out" 2>"$work/err" || status=$?
}
expect() {
    eval "$1" || {
        echo "not so: $1" >&2
        head -n 50 "$work"/{out,err,calls} >&2
        exit 1
    }
}

run ""
expect '[[ $status == 0 && ! -s $work/out && ! -s $work/err && ! -s $work/calls ]]'

run "libtbb-dev libxxhash-dev"
expect '[[ $status == 0 && ! -s $work/err ]]'
expect '[[ $(cat $work/out) == "tools/setup: installing libtbb-dev libxxhash-dev" ]]'
expect 'grep -q "install --no-install-recommends libtbb-dev libxxhash-dev$" $work/calls'

run "libtbb-dev" FAIL=1
expect '[[ $status == 1 ]]'
expect 'grep -q "the disk is full" $work/err && grep -q "apt-get update failed" $work/err'

# Not root (if we are, become nobody, who must be able to read the script).
if ((EUID == 0)); then
    cp "$setup" "$work/setup" && chmod 755 "$work/setup" && setup=$work/setup
    as=(setpriv --reuid 65534 --regid 65534 --clear-groups)
fi
run "libtbb-dev"
expect '[[ $status == 0 ]] && grep -qx sudo $work/calls'

mkdir "$work/plain"
for tool in bash env sed grep mktemp rm tail dpkg-query apt-get; do
    ln -s "$(PATH="$work/bin:$PATH" command -v "$tool")" "$work/plain/$tool"
done
status=0
"${as[@]}" env PATH="$work/plain" CALLS="$work/calls" ABSENT=libtbb-dev bash "$setup" >"$work/out" 2>"$work/err" || status=$?
expect '[[ $status == 1 ]] && grep -q "Run as root, or install sudo" $work/err'
