"""How the package finds its library, and what it says if it cannot."""

import os
import pathlib
import shutil
import subprocess
import sys

from conftest import PACKAGE

LIBRARY = os.path.realpath(os.environ["TALUS_LIBRARY"])


def run(program="import talus; print(talus._library.lib._name)", **environment):
    clean = {name: value for name, value in os.environ.items() if name not in ("TALUS_LIBRARY", "PYTHONPATH", "LD_LIBRARY_PATH")}
    return subprocess.run([sys.executable, "-B", "-c", program], env=clean | environment, capture_output=True, text=True)


def test_the_environment_names_the_library():
    done = run(PYTHONPATH=str(PACKAGE), TALUS_LIBRARY=LIBRARY)
    assert done.stdout.strip() == LIBRARY, done.stderr


def test_a_library_that_was_named_but_is_not_there_is_an_error():
    done = run(PYTHONPATH=str(PACKAGE), TALUS_LIBRARY="/nowhere/libtalus.so", LD_LIBRARY_PATH=os.path.dirname(LIBRARY))
    assert "ImportError" in done.stderr and "/nowhere/libtalus.so" in done.stderr and "TALUS_LIBRARY" in done.stderr


def test_another_library_is_an_error(tmp_path):
    cc = shutil.which("cc")
    for text, message in (("int other(void) { return 0; }", "not a Talus library"),
                          ("int talus_version(void) { return 10203; }", "Talus 1.2.3, and this Python package is for 0.1"),
                          ("int talus_version(void) { return 100; }", "has no talus_")):
        (tmp_path / "other.c").write_text(text)
        subprocess.run([cc, "-shared", "-fPIC", "-o", tmp_path / "other.so", tmp_path / "other.c"], check=True)
        done = run(PYTHONPATH=str(PACKAGE), TALUS_LIBRARY=str(tmp_path / "other.so"))
        assert "ImportError" in done.stderr and message in done.stderr, done.stderr


def test_the_library_beside_the_package_is_taken_wherever_both_were_moved(tmp_path):
    prefix = tmp_path / "lib"
    package = prefix / "python3/dist-packages"
    shutil.copytree(PACKAGE, package)
    shutil.copy(LIBRARY, prefix / "libtalus.so.0")
    moved = tmp_path / "moved"
    prefix.rename(moved)
    done = run(PYTHONPATH=str(moved / "python3/dist-packages"))
    assert pathlib.Path(done.stdout.strip()) == moved / "libtalus.so.0", done.stderr


def test_the_systems_library_is_taken_last(tmp_path):
    shutil.copy(LIBRARY, tmp_path / "libtalus.so.0")
    done = run(PYTHONPATH=str(PACKAGE), LD_LIBRARY_PATH=str(tmp_path))
    assert done.stdout.strip() == "libtalus.so.0", done.stderr
