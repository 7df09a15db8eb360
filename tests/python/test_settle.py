# processors: 2
"""The example runs small, and its own count of contacts is the engine's."""

import re
import subprocess
import sys

from conftest import SOURCE


def test_the_example_draws_a_picture(tmp_path):
    out = tmp_path / "settle.png"
    program = SOURCE / "apps/embed/settle.py"
    done = subprocess.run([sys.executable, "-B", str(program), "--grains", "300", "--out", str(out)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    contacts, by_distance = re.search(r"(\d+) contacts, (\d+) by distance", done.stdout).groups()
    assert contacts == by_distance and int(contacts) > 300
    assert out.read_bytes().startswith(b"\x89PNG") and out.stat().st_size > 20000
    assert len(program.read_text().splitlines()) < 100, "it is to be read at one glance"
