#!/usr/bin/python3
# timeout: 240
# processors: 2
"""talus-sandbox on four hosts that talk over TCP: the same bits as in one process; a signal stops all of them; and a host
that dies ends the job, soon and with a message.

A host is a set of namespaces of its own (network, host name, processes), made without changing anything outside. All of it
is held by this process through pipes and file descriptors, and goes with it, however it ends. Needs root, or a kernel
that lets users make namespaces; exit code 77 (skipped) without.

Run by ctest with TALUS_BUILD_DIR set, or by hand."""

import collections
import fcntl
import json
import os
import pathlib
import select
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest

BUILD = pathlib.Path(os.environ.get("TALUS_BUILD_DIR", "build/release")).resolve()
BINARY = next((str(BUILD / p) for p in ("bin/talus-sandbox", "apps/sandbox/talus-sandbox") if (BUILD / p).exists()), None)
REMOTE_SHELL = pathlib.Path(__file__).resolve().with_name("remote_shell")

HEAD = "head"  # where mpirun runs; no rank does
HOSTS = ["h1", "h2", "h3", "h4"]
NETWORK = "10.77.0.0/24"
ADDRESSES = {name: f"10.77.0.{i}" for i, name in enumerate([HEAD, *HOSTS], start=1)}
DELAY = 0.0005  # seconds, one way
MTU = 9000      # bytes; large ones spare this process work

# Without these Open MPI takes 300 + 9 * 20 s to notice that a host is silent.
KEEPALIVE = {"oob_tcp_keepalive_time": 3, "oob_tcp_keepalive_intvl": 1, "oob_tcp_keepalive_probes": 3}
NOTICED = 30   # seconds that a dead host may stay unnoticed
TIMEOUT = 60   # seconds, of anything else
STEPS = 400
STOPPED = 6    # exit code

# About 500 grains, periodic; walls at full speed at once, so that a few hundred steps already slide.
CONFIG = """
[sand]
diameter_mean = 1e-3
diameter_half_width = 1e-4
[box]
length = 0.02
depth = 0.005
width = 0.004
periodic_z = true
[settle]
cap = 0.06
bed_cache = "."
[shorten]
distance = 0.001
start = "at-once"
"""


def skip(reason):
    print(f"skipped: {reason}", flush=True)
    sys.exit(77)


def open_wire(name):
    """A network interface in the namespace of this process. What the kernel sends through it is read from the descriptor."""
    TUNSETIFF, IFF_TUN, IFF_NO_PI = 0x400454CA, 0x1, 0x1000
    wire = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
    fcntl.ioctl(wire, TUNSETIFF, struct.pack("16sH22x", name.encode(), IFF_TUN | IFF_NO_PI))
    return wire


class Network(threading.Thread):
    """Four hosts and this process, the head, on one switch. Every packet takes DELAY; a host that is cut off loses its
    packets without a word, in both directions. Packets are carried here and not by a bridge of the kernel because not
    every kernel has the module that delays them (netem)."""

    def __init__(self, folder):
        super().__init__(daemon=True)
        self.cut = set()
        self.carried = collections.Counter()  # bytes by (from, to)
        self.keepers = {}
        self.is_open = True
        self.wires = {name: open_wire(f"wire-{name}") for name in ADDRESSES}
        for name in HOSTS:
            self.keepers[name] = self.make_host(name)
            (folder / name).write_text(str(self.keepers[name].pid))
        for command in self.address(HEAD):
            subprocess.run(command.split(), check=True)
        # Open, so that they outlive a host's processes.
        self.namespaces = [os.open(f"/proc/{pid}/ns/net", os.O_RDONLY) for pid in [os.getpid(), *self.keeper_ids()]]
        self.start()

    def keeper_ids(self):
        return [keeper.pid for keeper in self.keepers.values()]

    @staticmethod
    def address(name):
        return [f"ip address add {ADDRESSES[name]}/24 dev wire-{name}", f"ip link set wire-{name} mtu {MTU} up"]

    def make_host(self, name):
        # The host lives until the shell, its first process, ends; that waits for the end of its input.
        script = f"hostname {name}; ip link set lo up; echo made; read wired; {'; '.join(self.address(name))}; echo up; read end"
        keeper = subprocess.Popen(["unshare", "--net", "--uts", "--ipc", "--pid", "--fork", "--kill-child", "sh", "-ec", script],
                                  stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.expect(keeper, "made")
        subprocess.run(["ip", "link", "set", f"wire-{name}", "netns", str(keeper.pid)], check=True)
        print("wired", file=keeper.stdin, flush=True)
        self.expect(keeper, "up")
        return keeper

    @staticmethod
    def expect(keeper, word):
        told = keeper.stdout.readline().strip()
        if told != word:
            raise RuntimeError(f"a host could not be made: '{told}' instead of '{word}'")

    def run(self):
        names = {wire: name for name, wire in self.wires.items()}
        owner = {bytes(map(int, address.split("."))): name for name, address in ADDRESSES.items()}
        under_way = collections.deque()  # (when it arrives, to whom, packet)
        while self.is_open:
            wait = under_way[0][0] - time.monotonic() if under_way else 0.1
            readable, _, _ = select.select(names, [], [], max(0, wait))
            for wire in readable:
                packet = os.read(wire, 1 << 16)
                sender, receiver = names[wire], owner.get(packet[16:20])  # where IPv4 has the destination
                if packet[0] >> 4 == 4 and receiver is not None and not {sender, receiver} & self.cut:
                    self.carried[sender, receiver] += len(packet)
                    under_way.append((time.monotonic() + DELAY, receiver, packet))
            while under_way and under_way[0][0] <= time.monotonic():
                _, receiver, packet = under_way.popleft()
                os.write(self.wires[receiver], packet)

    def kill(self, name):
        """Ends all processes of a host. Its kernel goes on and closes their connections, as that of a real host would."""
        self.keepers[name].kill()
        self.keepers[name].wait()

    def close(self):
        self.is_open = False
        self.join()
        for keeper in self.keepers.values():
            keeper.communicate()
        for descriptor in (*self.wires.values(), *self.namespaces):
            os.close(descriptor)

    def processes(self):
        """Commands of all processes on the head and on the hosts but this one and those that keep the hosts."""
        ours = {os.fstat(namespace).st_ino for namespace in self.namespaces}
        found = []
        for process in pathlib.Path("/proc").glob("[0-9]*"):
            try:
                parent = int((process / "stat").read_text().rpartition(")")[2].split()[1])
                is_ours = os.stat(process / "ns/net").st_ino in ours and int(process.name) != os.getpid()
                if is_ours and not {int(process.name), parent} & set(self.keeper_ids()):
                    found.append((process / "cmdline").read_text().replace("\0", " "))
            except OSError:
                pass  # ended meanwhile
        return found


class Hosts(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory(prefix="talus")
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = pathlib.Path(temporary.name)
        (cls.folder / "small.toml").write_text(CONFIG)
        # Open MPI keeps a folder for each host in TMPDIR; two tests have hosts and processes of the same names.
        os.environ.update(TALUS_HOSTS=temporary.name, TMPDIR=temporary.name)
        subprocess.run(cls.command("one", "--steps", STEPS), check=True, timeout=TIMEOUT, stdout=subprocess.DEVNULL)
        cls.digest = cls.summary("one")["state_digest"]

    def setUp(self):
        self.network = Network(self.folder)
        self.addCleanup(self.network.close)

    @classmethod
    def command(cls, out, *arguments):
        return [BINARY, "run", str(cls.folder / "small.toml"), "--out", str(cls.folder / out), "--threads", "1",
                *map(str, arguments)]

    @classmethod
    def summary(cls, out):
        return json.loads((cls.folder / out / "summary.json").read_text())

    def start(self, command):
        """A job with a rank on each host."""
        settings = {"plm": "rsh", "plm_rsh_agent": REMOTE_SHELL, "pml": "ob1", "btl": "tcp,self", "btl_tcp_if_include": NETWORK,
                    "oob_tcp_if_include": NETWORK, "mpi_yield_when_idle": 1, **KEEPALIVE}
        # However this process ends, mpirun must not stay behind.
        mpirun = ["setpriv", "--pdeathsig", "KILL", "mpirun", "--host", ",".join(HOSTS), "--map-by", "node", "--bind-to", "none"]
        for key, value in settings.items():
            mpirun += ["--mca", key, str(value)]
        self.log = self.folder / f"{self.id()}.log"
        with open(self.log, "w") as log:
            job = subprocess.Popen(mpirun + command, stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT)
        self.addCleanup(lambda: job.poll() is None and (job.kill(), job.wait()))
        return job

    def told(self):
        return self.log.read_text()

    def finish(self, job, code):
        self.assertEqual(job.wait(TIMEOUT), code, self.told())

    def start_long(self):
        """A job of an hour, some hundred steps into the shortening."""
        job = self.start(self.command("long", "--steps", 1000000, "--set", "shorten.speed=0.001"))
        walls = self.folder / "long/walls.csv"
        self.addCleanup(shutil.rmtree, self.folder / "long", ignore_errors=True)
        deadline = time.monotonic() + TIMEOUT
        while not walls.exists() or walls.read_text().count("\n") < 5:
            self.assertIsNone(job.poll(), self.told())
            self.assertLess(time.monotonic(), deadline, self.told())
            time.sleep(0.05)
        self.assertEqual(sum(command.startswith(BINARY) for command in self.network.processes()), len(HOSTS))
        return job

    def test_a_rank_on_each_host(self):
        self.finish(self.start(["hostname"]), 0)
        self.assertEqual(sorted(self.told().split()), HOSTS)

    def test_same_bits_as_in_one_process(self):
        self.finish(self.start(self.command("four", "--steps", STEPS)), 0)
        found = self.summary("four")
        self.assertEqual((found["ranks"], found["shortening"]["steps"]), (len(HOSTS), STEPS))
        self.assertGreater(found["sliding_contacts"], 0)
        self.assertEqual(found["state_digest"], self.digest)
        # Messages of ranks are all there is from host to host; Open MPI's daemons talk to the head.
        for name in HOSTS:
            for bytes_ in (sum(self.network.carried[name, other] for other in HOSTS),
                           sum(self.network.carried[other, name] for other in HOSTS)):
                self.assertGreater(bytes_, 100 * STEPS, name)

    def test_a_signal_to_mpirun_stops_every_host(self):
        job = self.start_long()
        job.send_signal(signal.SIGUSR1)
        self.finish(job, STOPPED)
        self.assertTrue(self.summary("long")["stopped"])
        self.assertTrue((self.folder / "long/run.ckpt").exists())

    def check_end(self, job, victim):
        """The job ends by itself, in time, says which host is missing, and leaves nothing behind on any host."""
        begin = time.monotonic()
        try:
            code = job.wait(NOTICED)
        except subprocess.TimeoutExpired:
            self.fail(f"{victim} died, and the job goes on after {NOTICED} s\n{self.told()}")
        ended = time.monotonic() - begin
        while self.network.processes() and time.monotonic() < begin + NOTICED:
            time.sleep(0.1)
        print(f"{victim} died: exit code {code} after {ended:.1f} s, the last process gone after {time.monotonic() - begin:.1f} s",
              flush=True)
        self.assertEqual(self.network.processes(), [])
        self.assertNotEqual(code, 0)
        self.assertRegex(self.told(), rf"lost communication with a remote daemon[\s\S]* on node {victim}\b")

    def test_killed_host_ends_the_job(self):
        job = self.start_long()
        self.network.kill("h3")
        self.check_end(job, "h3")

    def test_silent_host_ends_the_job(self):
        # No connection is closed: the others wait, and the host that is cut off goes on to wait as well.
        job = self.start_long()
        self.network.cut.add("h1")
        self.check_end(job, "h1")


def main():
    if BINARY is None:
        sys.exit(f"no talus-sandbox below {BUILD}; set TALUS_BUILD_DIR")
    if sys.argv[1:2] != ["inside"]:
        for tool in ("unshare", "nsenter", "setpriv", "ip"):
            if shutil.which(tool) is None:
                skip(f"there is no {tool} (packages util-linux, iproute2)")
        enter = ["unshare", "--net", "--uts", "--ipc"]
        for enter in enter, enter + ["--map-root-user"]:
            tried = subprocess.run(enter + ["unshare", "--pid", "--fork", "true"], capture_output=True, text=True)
            if tried.returncode == 0:
                break
        else:
            skip(f"namespaces cannot be made: {tried.stderr.strip()}")
        os.execvp("unshare", enter + [sys.executable, __file__, "inside", *sys.argv[1:]])
    try:
        os.close(open_wire("probe"))
    except OSError as error:
        skip(f"network interfaces cannot be made: /dev/net/tun: {error.strerror}")
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    subprocess.run(["hostname", HEAD], check=True)
    subprocess.run(["ip", "link", "set", "lo", "up"], check=True)  # MPI wants one interface even in one process
    os.environ.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]], verbosity=2)


if __name__ == "__main__":
    main()
