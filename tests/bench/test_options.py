#!/usr/bin/python3
# timeout: 300
"""The command line of talus-bench: what does not fit together is refused with a reason, and a table's JSON holds what its readers need.

Run by ctest with TALUS_BUILD_DIR set, or by hand."""

import json
import os
import pathlib
import subprocess
import sys
import tempfile

BENCH = pathlib.Path(os.environ.get("TALUS_BUILD_DIR", "build/release")).resolve() / "bin/talus-bench"
failures = []


def bench(*arguments):
    done = subprocess.run([BENCH, *map(str, arguments)], capture_output=True, text=True, timeout=240)
    return done.returncode, done.stdout + done.stderr


def expect(condition, text):
    if not condition:
        failures.append(text)


REFUSED = {
    "an unknown scene": (["--table", "--scene", "sea"], "--scene"),
    "an unknown law": (["--table", "--law", "none"], "--law"),
    "axes that are no order of axes": (["--write-bed", "x.txt", "--axes", "xxy"], "--axes"),
    "steps without a table": (["--steps", "5"], "--table"),
    "a scene without table or file": (["--scene", "gas"], "--benchmark_filter"),
    "a file of one scene for another": (["--table", "--scene", "gas", "--bed", __file__], "--bed"),
    "table and file at once": (["--table", "--write-bed", "x.txt"], "--write-bed"),
    "no threads": (["--threads", "0"], "--threads"),
    "options of nobody": (["--tabel"], "--tabel"),
}


def check_table(folder):
    out = folder / "table.json"
    code, text = bench("--table", "--scene", "gas", "--grains", 500, "--warm", 2, "--steps", 20, "--threads", 2, "--json", out)
    expect(code == 0, f"the table ends with {code}: {text}")
    if code:
        return
    for word in ("pair_build", "triad", "a plain loop over tiles", "springs hold"):
        expect(word in text, f"the table does not tell of {word}:\n{text}")
    table = json.loads(out.read_text())
    expect(table["scene"] == "gas" and table["steps"] == 20 and table["threads"] == 2 and table["particles"] == 512, "the JSON tells another run")
    expect([row["name"] for row in table["phases"]] == ["binning", "pair_build", "force", "integrate", "halo_exchange", "rebalance"], "the JSON has other phases")
    expect(all(table[key] > 0 for key in ("particle_steps_per_second", "bytes_per_particle", "rebuilds", "empty_firing")), "the JSON has figures that are not positive")
    memory = table["memory"]
    expect(memory["peak"] >= 0.9 * memory["resident"] > memory["records"] > 0, "the memory of the JSON does not fit together")
    expect(all(table["roofs"][key] > 0 for key in ("triad", "triad_one_thread", "divide_four", "root_four")), "the JSON has roofs that are not positive")
    expect(0 <= table["idle"] < 1, f"idle = {table['idle']}")
    expect(set(table["end"]) == {"mean_height", "contacts_per_grain", "kinetic_energy", "velocity"}, "the JSON has another end state")


def main():
    with tempfile.TemporaryDirectory() as name:
        os.chdir(name)
        for what, (arguments, reason) in REFUSED.items():
            code, text = bench(*arguments)
            expect(code != 0, f"{what} is accepted")
            expect(reason in text, f"{what}: the message does not name {reason}: {text}")
        expect(not list(pathlib.Path(name).iterdir()), "a refused call wrote a file")
        check_table(pathlib.Path(name))
    for failure in failures:
        print(failure, file=sys.stderr)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
