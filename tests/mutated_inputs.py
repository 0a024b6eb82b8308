"""Inputs with random errors, reproducible by the number of a trial: gallery cases, `--set`, and the files that cases read."""

import io
import random
import re
import time
import traceback
from contextlib import redirect_stdout
from functools import cache
from pathlib import Path
from typing import NamedTuple

import meshlane
from numba.core.event import TimingListener, install_listener

from pellucid import catalogue
from pellucid.commands.arguments import read_case
from pellucid.commands.cases import validate
from pellucid.errors import CONTROL, PellucidError
from pellucid.geometry.solid_meshes.box import BoxMesh
from pellucid.geometry.surfaces.triangles import Icosphere

NUMBERS = [
    *("0", "-1", "-0.0", "1", "2", "3", "7", "50", "1e-9", "1e-300", "5e-324", "1e9", "1e300", "1.8e308", "nan", "inf", "-inf"),
    *("9223372036854775807", "9223372036854775808", "-9223372036854775809", "1" + "0" * 400, "1" * 4400, "0x7fffffff", "1_0"),
]
TEXTS = [
    *('""', '"x"', '"gas"', '"all"', '"../../etc/passwd"', '"/dev/zero"', '"/"', '"a/b"', '"time"', '"kinetic_energy"'),
    *('"2 kPa"', '"3 m"', '"1 m**m"', '"9**9**9 s"', '"1e999 m"', '"1 " ', '"é"', '"𝔘"', "'''\n'''", f'"{"n" * 300}"'),
    *(r'"\u0000"', r'"\u001b[2J"', r'"\u0007"', f'"{"(" * 200}"', "\"__import__('os')\"", '"{0.__class__}"', '"%s%n"'),
]
OTHERS = [
    *("true", "false", "[]", "{}", "[[]]", "[0, 0, 0]", "[1, 2]", "[nan, 0, 0]", '["a", "b", "c"]', "[1e300, 1e300, 1e300]"),
    *(
        "[20000, 20000]",
        "[1000000000, 1, 1]",
        "[2000, 2000, 2000]",
        "{ a = 1 }",
        '{ kind = "sphere" }',
        "1979-05-27",
        "07:32:00",
    ),
    *("[" * 40 + "]" * 40, "[" * 600 + "]" * 600, "{ a = " * 40 + "1" + " }" * 40, ".", "=", "[", "#"),
]
HOSTILE = NUMBERS + TEXTS + OTHERS
VALUE = re.compile(r'"[^"\n]*"|-?\d[\d.e+-]*|true|false')
WORDS = [
    b"\0",
    b"\xff",
    b"\x1b[2J",
    b"\r",
    b"\n",
    b"\t",
    b'"',
    b"'''",
    b"[",
    b"]",
    b"{",
    b"}",
    b"=",
    b".",
    b"-",
    b"#",
    b"9" * 30,
]

FOLLOWED = """
schema = 1
title = "A block that is moved as a table says"
grid = { lower = [0, 0, 0], upper = [4, 2, 2], cell = 0.5 }
time = { end = 1.0 }
[[body]]
name = "block"
shape = { box = { lower = [0.5, 0.5, 0.5], upper = [1.5, 1.5, 1.5] } }
material = { kind = "linear-elastic", density = 1000, young_modulus = 1e3, poisson_ratio = 0.3 }
[[motion]]
name = "pull"
body = "block"
hold = ["y"]
displacement = { x = { kind = "table", path = "FILE" } }
"""
BAG = """
schema = 1
title = "A membrane of a file"
grid = { lower = [-2, -2, -2], upper = [2, 2, 2], cell = 1 }
time = { end = 1.0 }
[[body]]
name = "bag"
kind = "membrane-points"
thickness = 0.01
surface = { file = { path = "FILE", closed = true } }
material = { kind = "linear-membrane", density = 1000, young_modulus = 1e6, poisson_ratio = 0.3 }
"""
BLOCK = """
schema = 1
title = "A solid of a file"
time = { end = 1.0 }
[[body]]
name = "block"
kind = "meshless-solid"
mesh = { file = { path = "FILE" } }
material = { kind = "neo-hookean", density = 1000, young_modulus = 1e6, poisson_ratio = 0.3 }
"""
KINDS = ("bytes of a case", "values of a case", "lines of a case", "settings", "files of a case")
FORMATS = {"msh": "gmsh22"}
SLOWEST = 10.0
"""Largest processor time of a trial without compilation [s]; other processes may use the machine. The heart takes five with
half its cubes."""
LONGEST = 4000
"""Largest number of characters of a message."""


class Outcome(NamedTuple):
    """Outcome of a trial: kind and origin of the input, whether it was accepted, processor time [s], defect of the program
    (empty if none), and the message."""

    kind: str
    origin: str
    accepted: bool
    seconds: float
    wrong: str
    message: str


def trial(number: int, folder: Path) -> Outcome:
    """Insert errors into an input, validate it, and return the outcome; `folder` is empty before and after."""
    rng = random.Random(number)
    kind = KINDS[number % len(KINDS)]
    origin, settings, files = _damaged(rng, kind)
    for name, data in files.items():
        (folder / name).write_bytes(data)
    compiling, wrong, message = TimingListener(), "", ""
    begun, accepted = time.process_time(), False
    try:
        with redirect_stdout(io.StringIO()), install_listener("numba:compiler_lock", compiling):
            if settings:
                read_case(origin, rng.random() < 0.3, settings)
            else:
                validate(str(folder / "case.toml"))
        accepted = True
    except PellucidError as error:
        message = str(error).replace(str(folder), "")  # how deep the folder lies is not the program's affair
        if CONTROL.search(message) or len(message) > LONGEST:
            wrong = f"a message of {len(message)} characters" if len(message) > LONGEST else "control characters"
    except Exception:
        wrong, message = "traceback", traceback.format_exc()
    seconds = time.process_time() - begun - (compiling.duration if compiling.done else 0.0)
    if not wrong and seconds > SLOWEST:
        wrong = f"{seconds:.1f} s"
    after = {path.name: path.read_bytes() for path in folder.iterdir()}
    if after != files:
        wrong = wrong or f"left {sorted(after.keys() ^ files.keys()) or 'another file than it found'}"
    for path in folder.iterdir():
        path.unlink()
    return Outcome(kind, origin, accepted, seconds, wrong, message)


def _damaged(rng: random.Random, kind: str) -> tuple[str, list[str], dict[str, bytes]]:
    """Return an input with random errors: the name of the case or file, settings, and the files by name."""
    origin = rng.choice(catalogue.ids())
    text = catalogue.text(origin)
    if kind == "settings":
        return origin, [_setting(rng, text) for _ in range(rng.randint(1, 3))], {}
    if kind == "files of a case":
        name, case, data = rng.choice(cases_with_files())
        named = rng.choice([name] * 9 + ["", ".", "..", "/", "/dev/zero", "missing.stl", "case.toml", "x" * 300 + ".stl"])
        return name, [], {"case.toml": case.replace("FILE", named).encode(), name: _bytes(rng, data)}
    if kind == "bytes of a case":
        return origin, [], {"case.toml": _bytes(rng, text.encode())}
    damage = _values if kind == "values of a case" else _lines
    return origin, [], {"case.toml": damage(rng, text).encode()}


def _bytes(rng: random.Random, data: bytes) -> bytes:
    """Return the data with some bytes changed, removed or inserted; sometimes the data is truncated or a part repeated."""
    found = bytearray(data)
    for _ in range(rng.choice([1, 1, 2, 5, 30])):
        place = rng.randrange(len(found) + 1)
        what = rng.randrange(6)
        if what == 0:
            found[place : place + 1] = bytes([rng.randrange(256)])
        elif what == 1:
            del found[place : place + rng.choice([1, 2, 10, 200])]
        elif what == 2:
            found[place:place] = rng.choice(WORDS)
        elif what == 3 and (digits := list(re.finditer(rb"\d+", bytes(found)))):
            one = rng.choice(digits)
            found[one.start() : one.end()] = rng.choice([b"-1", b"0", b"99999", b"4294967296", b"1e999", b"nan", b"x", b""])
        elif what == 4 and rng.random() < 0.2:
            del found[place:]
        elif what == 5 and rng.random() < 0.2:
            found += found[place : place + 5000]
    return bytes(found)


def _values(rng: random.Random, text: str) -> str:
    for _ in range(rng.choice([1, 1, 1, 2, 4])):
        values = list(VALUE.finditer(text))
        one = rng.choice(values)
        new = rng.choice(HOSTILE) if rng.random() < 0.6 else rng.choice(values)[0]
        text = text[: one.start()] + new + text[one.end() :]
    return text


def _lines(rng: random.Random, text: str) -> str:
    lines = text.splitlines(keepends=True)
    for _ in range(rng.choice([1, 1, 2, 4])):
        place, other = rng.randrange(len(lines)), rng.randrange(len(lines))
        what = rng.randrange(5)
        if what == 0 and len(lines) > 1:
            del lines[place]
        elif what == 1:
            lines.insert(place, lines[other])
        elif what == 2:
            lines[place], lines[other] = lines[other], lines[place]
        elif what == 3:
            foreign = catalogue.text(rng.choice(catalogue.ids())).splitlines(keepends=True)
            start = rng.randrange(len(foreign))
            lines[place:place] = foreign[start : start + rng.choice([1, 3, 20])]
        else:
            lines[place] = lines[place].replace("=", rng.choice(["= =", "", ".a =", f"= {rng.choice(HOSTILE)} #"]), 1)
    return "".join(lines)


def _setting(rng: random.Random, text: str) -> str:
    key = rng.choice(sorted(set(_keys(text))))
    what = rng.random()
    if what < 0.1:
        strange = ["", ".", "..", key + ".", key + ".x", key + "." * 40, ".".join(["a"] * 500), "body." + "1" * 5000]
        key = rng.choice([*strange, f'"{key}"', key + "\0", "\x1b[2J"])
    elif what < 0.2:
        others = ["body.0.kind", "body.-1.name", "body", "quick", "schema"]
        key = rng.choice([*others, key.rpartition(".")[0], key.upper(), key[:-1]])
    value = rng.choice(HOSTILE) if rng.random() < 0.8 else rng.choice(list(VALUE.finditer(text)))[0]
    return rng.choice([f"{key}={value}"] * 20 + [key, value, "", "=", f"={value}", f"{key}={value[:-1]}"])


def _keys(text: str) -> list[str]:
    """Return the dotted keys of the tables in the text of a case."""
    found, table = [], ""
    for line in text.splitlines():
        if head := re.match(r"\[+([\w.-]+)\]+", line):
            table = head[1] + "."
        elif key := re.match(r"([\w-]+) *=", line):
            found.append(table + key[1])
    return found


@cache
def cases_with_files() -> list[tuple[str, str, bytes]]:
    """Return files that cases can read: name, text of a case that reads it, and content of each."""
    from tempfile import TemporaryDirectory

    ball = Icosphere(centre=(0.0, 0.0, 0.0), radius=1.0, refinements=1).mesh()
    solid = BoxMesh(lower=(0.0, 0.0, 0.0), upper=(1.0, 1.0, 1.0), cells=(2, 2, 2)).mesh()
    found = [("motion.csv", FOLLOWED, b"time,displacement\n0,0\n0.1,0.02\n0.4,0.1\n1.0,0.15\n")]
    with TemporaryDirectory() as folder:
        for ending in ("stl", "obj", "ply", "vtk", "msh"):
            path = Path(folder) / f"ball.{ending}"
            meshlane.write_points_cells(path, ball.vertices, [("triangle", ball.triangles)], file_format=FORMATS.get(ending))
            found.append((path.name, BAG, path.read_bytes()))
        for ending in ("inp", "vtk", "vtu", "msh", "bdf"):
            path = Path(folder) / f"box.{ending}"
            meshlane.write_points_cells(path, solid.nodes, [("tetra", solid.cells)], file_format=FORMATS.get(ending))
            found.append((path.name, BLOCK, path.read_bytes()))
    return found
