#!/usr/bin/python3
# timeout: 300
# processors: 2
"""Bad input to talus-sandbox: each faulty configuration, bed file or command line ends with one clear error, the
documented exit code and no output folder, on one rank and on three, without a hang.

Run by ctest with TALUS_BUILD_DIR and TALUS_SOURCE_DIR set, or by hand: test_sandbox_bad_input.py [case ...]"""

import concurrent.futures
import os
import pathlib
import subprocess
import sys
import tempfile

import h5py
import numpy as np

BUILD = pathlib.Path(os.environ.get("TALUS_BUILD_DIR", "build/release")).resolve()
SOURCE = pathlib.Path(os.environ.get("TALUS_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2])).resolve()
TIMEOUT = 60  # seconds; a case takes about one, so more is a hang
INPUT, IO = 2, 4  # exit codes

# A small box of about 500 grains.
BASE = """
[sand]
diameter_mean = 1e-3
diameter_half_width = 1e-4
[box]
length = 0.02
depth = 0.005
width = 0.004
[shorten]
distance = 0.001
"""

# Three grains at rest beside each other, z up.
HEAD = "# 3 0 0.02 0 0.01 0 0.01\n"
GRAINS = ["1 0.002 0.005 0.0005 0.0005", "2 0.004 0.005 0.0005 0.0005", "3 0.006 0.005 0.0005 0.0005"]
BED = '[bed]\nfile = "bed.txt"\naxes = "xzy"\n'


def grains(*lines, head=HEAD):
    return head + "\n".join(lines) + "\n"


def write_hdf5(path, **change):
    data = {"id": np.array([1, 2, 3]), "position": np.array([[2e-3, 5e-3, 5e-4], [4e-3, 5e-3, 5e-4], [6e-3, 5e-3, 5e-4]]),
            "radius": np.full(3, 5e-4), "box": np.array([0, 0.02, 0, 0.01, 0, 0.01])}
    data.update(change)
    with h5py.File(path, "w") as file:
        for name in ("id", "position", "radius"):
            if data[name] is not None:
                file[name] = data[name]
        if data["box"] is not None:
            file.attrs["box"] = data["box"]


def cut(path):
    write_hdf5(path)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])


class Case:
    """config: text of case.toml; bed: text of bed.txt; hdf5: writer of bed.hdf; expect: texts in the message."""

    def __init__(self, name, expect, config=BASE, bed=None, hdf5=None, arguments=(), code=INPUT, prepare=None):
        self.name, self.config, self.bed, self.hdf5 = name, config, bed, hdf5
        self.expect = [expect] if isinstance(expect, str) else expect
        self.arguments, self.code, self.prepare = list(arguments), code, prepare


def setting(name, value, expect):
    return Case(f"--set {name}={value}", expect, arguments=["--set", f"{name}={value}"])


def bed_case(name, expect, *lines, head=HEAD):
    return Case(name, expect, config=BED, bed=grains(*lines, head=head))


def hdf5_case(name, expect, writer):
    return Case(name, expect, config=BED.replace("bed.txt", "bed.hdf"), hdf5=writer)


CASES = [
    # The file as a whole
    Case("missing configuration", "case.toml: cannot be opened", config=None),
    Case("configuration is a folder", "case.toml: is a folder", config=None, prepare=lambda folder: (folder / "case.toml").mkdir()),
    Case("not TOML", "case.toml:3:", config="[sand]\nyoung = 1e7\nfriction = = 2\n"),
    Case("key given twice", "case.toml:3:", config="[sand]\nyoung = 1e7\nyoung = 1e8\n"),
    # Names and types
    Case("unknown key", ["case.toml:12:1: time.step_fracton", "did you mean time.step_fraction?"],
         BASE + "[time]\nstep_fracton = 0.1\n"),
    Case("key of another table", "did you mean sand.friction?", BASE + "[laws]\nfriction = 0.5\n"),
    Case("unknown table", ["[shortn]", "did you mean [shorten]?"], BASE.replace("[shorten]", "[shortn]")),
    Case("key outside tables", "density = 2600: this key belongs below [sand]", "density = 2600\n" + BASE),
    Case("text for a number", ["box.height", "is a text; give a number"],
         BASE.replace("depth = 0.005", 'depth = 0.005\nheight = "20 mm"')),
    Case("fraction for a whole number", "run.walls_every = 1.5", BASE + "[run]\nwalls_every = 1.5\n"),
    Case("number for true or false", "give true or false", BASE.replace("width", "periodic_z = 1\nwidth")),
    Case("unknown word", 'did you mean "spring"?', BASE + '[laws]\nrolling = "sprnig"\n'),
    # Values
    setting("sand.friction", "-0.6", "sand.friction = -0.6: is out of range"),
    setting("sand.density", "nan", "sand.density = nan: is not a finite number"),
    setting("sand.young", "inf", "sand.young = inf: is not a finite number"),
    setting("sand.poisson", "0.5", "from 0 to below 0.5"),
    setting("sand.restitution", "0", "sand.restitution = 0: is out of range"),
    setting("box.depth", "18.8", "if 18.8 mm is meant, write 0.0188"),
    setting("box.depth", "0.0005", "holds zero grains"),
    setting("sand.diameter_half_width", "1e-3", "the smallest grain would have no size"),
    setting("run.threads", "0", "run.threads = 0: is out of range"),
    setting("run.threads", "-2", "run.threads = -2: is out of range"),
    setting("run.seed", "-1", "run.seed = -1: is out of range"),
    setting("shorten.speed", "0", "shorten.speed = 0: is out of range"),
    setting("bed.file", "bed.txt", """--set 'bed.file="bed.txt"'"""),
    setting("bed.file", '"nowhere.txt"', "nowhere.txt: cannot be opened"),
    setting("settle", "1", "is not of the form table.key=value"),
    # What does not fit together
    setting("time.step", "1e-4", "of the Rayleigh step"),
    setting("shorten.distance", "0.5", "let it go 0.018 m at most"),
    setting("box.height", "0.006", "the loose fill needs"),
    setting("laws.normal", '"linear"', "the linear law needs it"),
    setting("engine.skin", "0.01", "is larger than two grains"),
    setting("engine.rank_grid", "[7, 1, 1]", "is for 7 ranks"),
    setting("engine.rank_grid", "[40, 1, 1]", "40 subdomains along x are narrower than grain and skin"),
    setting("run.snapshot_shortening", "1e-8", "snapshots; at most 9999"),
    setting("run.snapshot_shortening", "2", "is more than the whole stage"),
    Case("periodic length too short", "a periodic length must be at least 2 (largest diameter + skin)",
         BASE.replace("width = 0.004", "width = 0.002\nperiodic_z = true")),
    Case("two ways of one", "shorten.duration = 1 is given too", BASE + "duration = 1\n"),
    Case("all faults at once", ["4 faults in case.toml", "sand.frction", "box.width", "shorten.distance", "layers.thickness"],
         BASE.replace("[box]", "frction = 1\n[box]").replace("width = 0.004", 'width = "4 mm"').replace("distance = 0.001", "distance = -1")
         + "[layers]\nthickness = 0\n"),
    Case("more grains than memory", "GB of memory", config=(SOURCE / "apps/sandbox/configs/paper.toml").read_text()),
    # Bed files
    bed_case("bed with nan", "bed.txt:3: y = nan of grain 2", GRAINS[0], "2 0.004 nan 0.0005 0.0005", GRAINS[2]),
    bed_case("bed with a duplicate label", ["bed.txt:4: id 1 was given before, at", "bed.txt:2"], GRAINS[0], GRAINS[1],
             "1 0.006 0.005 0.0005 0.0005"),
    bed_case("bed with a negative radius", "bed.txt:2: radius -0.0005 of grain 1", "1 0.002 0.005 0.0005 -0.0005", *GRAINS[1:]),
    bed_case("bed with a negative label", "bed.txt:2: id -1", "-1 0.002 0.005 0.0005 0.0005", *GRAINS[1:]),
    bed_case("bed with a column missing", "bed.txt:3: 4 columns", GRAINS[0], "2 0.004 0.005 0.0005", GRAINS[2]),
    bed_case("bed with a word", 'bed.txt:2: x = "zero" is not a number', "1 zero 0.005 0.0005 0.0005", *GRAINS[1:]),
    bed_case("bed cut short", "the head states 3 grains, the file holds 2", *GRAINS[:2]),
    bed_case("bed without head", "bed.txt:1: the first line must be", *GRAINS, head=""),
    bed_case("bed with an inverted box", "xlo = 0.02 and xhi = 0", *GRAINS, head="# 3 0.02 0 0 0.01 0 0.01\n"),
    bed_case("bed outside its box", "bed.txt:2: x = 0.03 of grain 1 is outside the box", "1 0.03 0.005 0.0005 0.0005", *GRAINS[1:]),
    bed_case("bed of zero grains", "holds no grains", head="# 0 0 0.02 0 0.01 0 0.01\n"),
    bed_case("empty bed file", "bed.txt", head=""),
    bed_case("bed with overlapping grains", ["bed.txt", "overlap"], GRAINS[0], "2 0.0024 0.005 0.0005 0.0005", GRAINS[2]),
    bed_case("all faults of a bed at once", ["2 faults", "bed.txt:2", "bed.txt:4"], "1 nan 0.005 0.0005 0.0005", GRAINS[1],
             "3 0.006 0.005 0.0005 0"),
    Case("bed and box", "is told by the bed file", BED + "[box]\nlength = 1\n", bed=grains(*GRAINS)),
    Case("axes named twice", "must name x, y and z once each", BED.replace("xzy", "xxy"), bed=grains(*GRAINS)),
    hdf5_case("HDF5 bed without radius", "has no dataset radius", lambda p: write_hdf5(p, radius=None)),
    hdf5_case("HDF5 bed without box", "has no attribute box", lambda p: write_hdf5(p, box=None)),
    hdf5_case("HDF5 bed of a wrong shape", "dataset position must be numbers of shape [N x 3]",
              lambda p: write_hdf5(p, position=np.zeros((3, 2)))),
    hdf5_case("HDF5 bed with counts that differ", "3 ids, 3 positions and 2 radii", lambda p: write_hdf5(p, radius=np.full(2, 5e-4))),
    hdf5_case("HDF5 bed with nan", "row 1: radius nan", lambda p: write_hdf5(p, radius=np.array([5e-4, np.nan, 5e-4]))),
    hdf5_case("HDF5 bed cut short", "is damaged", cut),
    # The command line
    Case("--threads 0", "run.threads = 0: is out of range", arguments=["--threads", "0"]),
    Case("--threads many", "--threads", arguments=["--threads", "many"]),
    Case("--steps -1", "--steps", arguments=["--steps", "-1"]),
    Case("--steps beyond the box", "--steps 100000000: the front wall would go", arguments=["--steps", "100000000"]),
    Case("unknown option", "--outt", arguments=["--outt", "x"]),
    Case("trace into a missing folder", "does not exist", arguments=["--trace", "nowhere/trace.json"], code=IO),
    Case("output is a file", "out: exists and is not a folder", code=IO, prepare=lambda folder: (folder / "out").touch()),
]


def find_binary():
    for place in ("bin/talus-sandbox", "apps/sandbox/talus-sandbox"):
        if (BUILD / place).exists():
            return str(BUILD / place)
    sys.exit(f"no talus-sandbox below {BUILD}; set TALUS_BUILD_DIR")


def run(case, ranks, binary, folder):
    """Empty if all is as it should be, else what is not."""
    folder = pathlib.Path(tempfile.mkdtemp(dir=folder))
    if case.config is not None:
        (folder / "case.toml").write_text(case.config)
    if case.bed is not None:
        (folder / "bed.txt").write_text(case.bed)
    if case.hdf5 is not None:
        case.hdf5(folder / "bed.hdf")
    if case.prepare is not None:
        case.prepare(folder)
    before = sorted(os.listdir(folder))
    launcher = [] if ranks == 1 else ["mpirun", "-n", str(ranks), "--oversubscribe", "--bind-to", "none"]
    command = launcher + [binary, "run", "case.toml", "--out", "out"] + case.arguments
    # A session of its own, so that a hanging mpirun can be ended with all of its ranks.
    process = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                               start_new_session=True)
    try:
        _, errors = process.communicate(timeout=TIMEOUT)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, 9)
        process.communicate()
        return f"did not end within {TIMEOUT} s"
    faults = []
    if process.returncode != case.code:
        faults.append(f"exit code {process.returncode}, not {case.code}")
    for text in case.expect:
        if text not in errors:
            faults.append(f"the message does not say: {text}")
    # One message, not one a rank.
    heads = [line for line in errors.splitlines() if line.startswith("talus-sandbox: ") or "Run with --help" in line]
    if len(heads) != 1:
        faults.append(f"{len(heads)} messages instead of one")
    if sorted(os.listdir(folder)) != before:
        faults.append(f"left behind: {set(os.listdir(folder)) - set(before)}")
    return "" if not faults else "; ".join(faults) + "\n" + errors


def main():
    os.environ.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1", OMPI_MCA_mpi_yield_when_idle="1",
                      OMPI_MCA_btl_vader_single_copy_mechanism="none")
    binary = find_binary()
    wanted = [case for case in CASES if not sys.argv[1:] or case.name in sys.argv[1:]]
    jobs = [(case, ranks) for case in wanted for ranks in (1, 3)]
    failures = 0
    # Starting MPI is mostly waiting, so several cases at a time.
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(4) as pool:
        for (case, ranks), problem in zip(jobs, pool.map(lambda job: run(*job, binary, folder), jobs)):
            if problem:
                failures += 1
                print(f"FAILED  {case.name}, {ranks} rank(s): {problem}")
    print(f"{len(wanted)} cases on 1 and 3 ranks, {failures} failed")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
