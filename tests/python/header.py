"""What talus.h declares, found by the compiler: names by its preprocessor, layouts and values by a program it compiles."""

import functools
import json
import re
import shutil
import subprocess

from conftest import SOURCE

INCLUDE = SOURCE / "capi/include"
HEADER = INCLUDE / "talus.h"
# Scalars are told by _Generic; an array decays to a pointer there, and its size tells it apart.
KINDS = {
    "int32_t": "i4", "uint32_t": "u4", "int64_t": "i8", "uint64_t": "u8", "double": "f8", "float": "f4",
    "char *": "S*", "const char *": "S*", "void *": "v*", "const void *": "v*",
    "int32_t *": "i4*", "const int32_t *": "i4*", "int64_t *": "i8*", "const int64_t *": "i8*",
    "uint64_t *": "u8*", "const uint64_t *": "u8*", "double *": "f8*", "const double *": "f8*",
}


def compiler():
    found = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    assert found, "no C compiler: the tests of the binding need one"
    return found


@functools.lru_cache
def preprocessed(*options):
    done = subprocess.run([compiler(), "-E", *options, "-I", str(INCLUDE), str(HEADER)], capture_output=True, text=True, check=True)
    return done.stdout


@functools.lru_cache
def own_text():
    """The header after preprocessing, without what it includes, on one line."""
    lines, own = [], False
    for line in preprocessed().splitlines():
        marker = re.match(r'# \d+ "([^"]*)"', line)
        if marker:
            own = marker[1] == str(HEADER)
        elif own:
            lines.append(line)
    return re.sub(r"__attribute__\s*\(\(.*?\)\)\)?", "", re.sub(r"\s+", " ", " ".join(lines)))


def structs():
    """Members of each struct, in order: {"talus_laws": ["struct_size", ...]}."""
    found = {}
    for body, name in re.findall(r"struct \w+ \{([^{}]*)\} (\w+);", own_text()):
        members = []
        for declaration in filter(str.strip, body.split(";")):
            callback = re.search(r"\(\s*\*\s*(\w+)\s*\)\s*\(", declaration)
            if callback:
                members.append(callback[1])
                continue
            for part in declaration.split(","):
                members.append(re.search(r"(\w+)\s*(\[[^\]]*\]\s*)*$", part)[1])
        found[name] = members
    return found


def functions():
    """Result and arguments of each function as C types without their names: {"talus_version": ("int32_t", [])}."""
    found = {}
    text = re.sub(r"struct \w+ \{[^{}]*\}", "", own_text())
    for result, name, arguments in re.findall(r"([\w ]+?[ *]+)\b(talus_\w+)\s*\(((?:[^()]|\([^()]*\))*)\)\s*;", text):
        found[name] = (plain_type(result), arguments_of(arguments))
    return found


def arguments_of(text):
    """The types in an argument list, without the names; a callback is kept as "result (*)(arguments)"."""
    parts = [] if text.strip() == "void" else re.split(r",(?![^()]*\))", text)
    named = [re.sub(r"\(\s*\*\s*\w+\s*\)", "(*)", p) if "(" in p else re.sub(r"(?<=[ *])\w+\s*(?=(\[|$))", "", p) for p in map(str.strip, parts)]
    return [plain_type(p) for p in named]


def callbacks():
    """Types of pointers to functions: {"talus_name": "int32_t (*)(void *, int64_t)"}."""
    found = re.findall(r"typedef ([\w ]+?[ *]*)\(\s*\*\s*(\w+)\s*\)\s*\(([^()]*)\)\s*;", own_text())
    return {name: f"{plain_type(result)} (*)({arguments})" for result, name, arguments in found}


def plain_type(text):
    """Without const, with an array as the pointer that it is: "const double [3]" is "double *"."""
    text = re.sub(r"\bconst\b|\bextern\b", " ", text)
    text = re.sub(r"\[[^\]]*\]", "*", text)
    return re.sub(r"\s*\*", " *", re.sub(r"\s+", " ", text).strip()).replace("* *", "**")


def constant_names():
    """Macros of the header with a value: not the include guard, the export mark, or ones with arguments."""
    names = re.findall(r"^#define (TALUS_\w+) (\S.*)$", preprocessed("-dM"), re.M)
    return [name for name, value in names if "__attribute__" not in value]


PROBE = """
#include <stdio.h>
#include "talus.h"
#define KIND(x) _Generic((x), %(kinds)s, default: "other")
#define MEMBER(S, m) printf("[\\"%%s\\", \\"%%s\\", %%zu, %%zu, \\"%%s\\"],\\n", #S, #m, offsetof(S, m), sizeof(((S *)0)->m), KIND(((S *)0)->m));
#define SIZE(S) printf("[\\"%%s\\", \\"\\", 0, %%zu, \\"\\"],\\n", #S, sizeof(S));
#define VALUE(c) printf("[\\"%%s\\", %%lld],\\n", #c, (long long)(c));
int main(void) {
    puts("{\\"layout\\": [");
    %(layout)s
    puts("[]], \\"constants\\": [");
    %(constants)s
    puts("[]]}");
    return 0;
}
"""


def measured(folder):
    """Layout {(struct, member or ""): (offset, size, kind)} and constants {name: value}, printed by a compiled program."""
    layout = [f"SIZE({s})" for s in structs()] + [f"MEMBER({s}, {m})" for s, members in structs().items() for m in members]
    kinds = ", ".join(f'{c_type}: "{kind}"' for c_type, kind in KINDS.items())
    constants = [f"VALUE({name})" for name in constant_names()]
    source = folder / "probe.c"
    source.write_text(PROBE % {"kinds": kinds, "layout": "\n    ".join(layout), "constants": "\n    ".join(constants)})
    program = folder / "probe"
    subprocess.run([compiler(), "-std=c11", "-Wall", "-Werror", "-I", str(INCLUDE), str(source), "-o", str(program)], check=True)
    found = json.loads(subprocess.run([str(program)], capture_output=True, text=True, check=True).stdout)
    return {(s, m): (offset, size, kind) for s, m, offset, size, kind in found["layout"][:-1]}, dict(found["constants"][:-1])
