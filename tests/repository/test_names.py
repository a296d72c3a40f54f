"""Names: classes and modules of the package are unique, constants name a quantity."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest
from source_files import parsed

import vidstyle

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "vidstyle"
FILES = sorted(PACKAGE.rglob("*.py"))
TOOLS = sorted(path for name in ("tools", ".ci", "examples") for path in (ROOT / name).rglob("*.py"))

SAME_ALIASES = {"Pair", "Point"}
"""Type aliases that mean the same wherever they stand."""

SHARED_MODULES = {
    "renderer": "the public renderer, the CPU and the GPU renderer",
    "session": "of a GPU, of live",
    "stabilizer": "on the CPU, on a GPU",
    "svg": "of a comic page, of a style's graph",
}
"""Names of files that may occur twice: the same thing in two subjects."""


def defined() -> Iterator[str]:
    """The classes and type aliases of every module, type variables aside."""
    for path in FILES:
        for node in parsed(path).body:
            if isinstance(node, ast.ClassDef):
                yield node.name
            elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
                name = node.targets[0].id
                is_type = name[0].isupper() and not name.isupper()
                if is_type and not ast.unparse(node.value).startswith(("TypeVar", "ParamSpec")):
                    yield name


def test_a_class_or_type_is_defined_once() -> None:
    twice = {name for name, count in Counter(defined()).items() if count > 1 and not name.startswith("_")}
    assert twice <= SAME_ALIASES


def test_public_names_are_classes_or_functions_of_one_meaning() -> None:
    """What `import vidstyle` offers is defined nowhere else, as a class or as a function."""
    functions = Counter(
        node.name
        for path in FILES
        if path.parent.name != "cli"  # a command is called as the function that it runs
        for node in parsed(path).body
        if isinstance(node, ast.FunctionDef)
    )
    classes = Counter(defined())
    assert {name: classes[name] + functions[name] for name in vidstyle.__all__} == dict.fromkeys(
        vidstyle.__all__, 1
    )


def test_a_file_name_occurs_once() -> None:
    """Commands and blocks are exempt, as users know them by their names."""
    named_by_users = {PACKAGE / "cli", PACKAGE / "blocks"}
    stems = Counter(path.stem for path in FILES if path.parent not in named_by_users)
    twice = {stem for stem, count in stems.items() if count > 1 and not stem.startswith("__")}
    assert twice <= SHARED_MODULES.keys()


ROLES = "MIN MAX DEFAULT BEST WANTED FULL"
UNITS = (
    "SECONDS FRAMES STEPS PX MM INCH POINTS DPI BYTES PIXELS CELLS UNITS LEVEL LEVELS BINS GUTTERS COLUMN"
    " HOURS DEGREES RADIANS CODE CODES ID INDEX BYTE BIT BITS LANES FLOATS LIFT"
)
COUNTED = (
    "COUNT COUNTS NUMBERS PANELS COLUMNS ROWS LINES LETTERS CANDIDATES ATTEMPTS ROUNDS POSITIONS SIZES"
    " WEIGHTS"
)
MEASURES = (
    "RATIO RATIOS SHARE FACTOR WEIGHT COST SCORE SCORES RANGE RANGES DEVIATION DEVIATIONS CORRELATION"
    " SIMILARITY INTERSECTION DIFFERENCE MOTION ASPECT TOLERANCE EXPONENT HEIGHT SIZE SEED QUALITY VERSION"
    " CURVATURE TIME COLOR COLORS RATE RATES SPEED SPEEDS MS STEP SCALE SCALES MATRIX SEMITONES CHARACTERS"
    " PERCENTILE QUANTILES DISTANCE DIGITS NITS GAMMA COEFFICIENT POLYNOMIAL WIDTH"
)
QUANTITIES = frozenset(f"{ROLES} {UNITS} {COUNTED} {MEASURES}".split())
"""A numeric constant of a module has at least two words, one of them from this set, which may be extended."""

NUMERIC_CALLS = {"Fraction", "math", "np"}
"""Types and modules whose calls with numbers give numbers."""


def is_numeric(value: ast.expr | None) -> bool:
    """Whether an expression consists of numbers: literals, tuples, arithmetic, calls like `math.log(2)`."""
    text = ast.unparse(value) if value else ""
    nodes = list(ast.walk(value)) if value and "np.empty" not in text and "np.s_" not in text else []
    literals = [node.value for node in nodes if isinstance(node, ast.Constant)]
    literals = [each for each in literals if not isinstance(each, bool)]
    callers = {next(ast.walk(node.func)) for node in nodes if isinstance(node, ast.Call)}
    names = {ast.unparse(each).partition(".")[0] for each in callers}
    numbers = [each for each in literals if isinstance(each, int | float)]
    return bool(numbers) and len(numbers) == len(literals) and names <= NUMERIC_CALLS


def constants(tree: ast.Module) -> Iterator[tuple[str, ast.expr | None]]:
    """The constants that a module defines, with their values."""
    for node in tree.body:
        if not isinstance(node, ast.Assign | ast.AnnAssign):
            continue
        for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
            pairs = [(target, node.value)]
            if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
                pairs = list(zip(target.elts, node.value.elts, strict=True))
            for name, value in pairs:
                if isinstance(name, ast.Name) and name.id.isupper():
                    yield name.id, value


def says_quantity(name: str) -> bool:
    words = name.strip("_").split("_")
    return len(words) > 1 and not QUANTITIES.isdisjoint(words)


def test_a_numeric_constant_says_its_quantity_and_role() -> None:
    """`MAX_CROP_COST` does; `_MOST` and `WHOLE` do not."""
    unclear = [
        (str(path.relative_to(ROOT)), name)
        for path in (*FILES, *TOOLS)
        for name, value in constants(parsed(path))
        if is_numeric(value) and not says_quantity(name)
    ]
    assert unclear == []


@pytest.mark.parametrize(
    ("code", "unclear"),
    [
        ("_MOST = 3", ["_MOST"]),
        ("_NEAR, MAX_NEAR_SECONDS = -0.5, 2", ["_NEAR"]),
        ("SAFE_AREA: float = 2 * math.log(3)", ["SAFE_AREA"]),
        ("_JITTER = np.array([1.0, 0.3])", ["_JITTER"]),
        ("_NAMES = 'a', 'b'\n_IS_FAST = True\n_ENCODING = Encoding(subsampling=(1, 1))", []),
    ],
)
def test_unclear_constants_are_found(code: str, unclear: list[str]) -> None:
    found = [name for name, value in constants(ast.parse(code)) if is_numeric(value)]
    assert [name for name in found if not says_quantity(name)] == unclear
