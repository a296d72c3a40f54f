"""Parses the options of `vidstyle train`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from vidstyle.errors import UsageError

if TYPE_CHECKING:
    from vidstyle.blade.bins import Bins, Feature
    from vidstyle.blade.reference_filter import ReferenceFilter
    from vidstyle.blade.regression import TrainingConfig

MIN_RHO = 0.3
"""Minimum standard deviation of the windows by which filters are selected, in pixels."""


def parse_sliders(texts: tuple[str, ...]) -> list[tuple[str, float, float]]:
    """Return name and range of each --slider."""
    from vidstyle.blade.bank import MAX_WEIGHT

    found = []
    for text in texts:
        name, _, ends = text.partition("=")
        try:
            low, high = (float(end) for end in ends.split(":"))
        except ValueError:
            low = high = 0.0
        if not name or not -MAX_WEIGHT <= low < high <= MAX_WEIGHT:
            raise UsageError(text, "is not NAME=LOW:HIGH", "for example --slider strength=0:2")
        found.append((name, low, high))
    return found


def _features(texts: tuple[str, ...]) -> tuple[Feature, ...]:
    from vidstyle.blade.bank import MAX_FEATURES, MAX_FILTERS, MAX_RHO
    from vidstyle.blade.bins import FEATURE_RANGES, Feature

    found = []
    for text in texts:
        name, _, scale = text.partition("=")
        try:
            bins, rho = int(scale.partition("@")[0]), float(scale.partition("@")[2])
        except ValueError:
            bins, rho = 0, 0.0
        if name not in FEATURE_RANGES or not (1 <= bins <= MAX_FILTERS and MIN_RHO <= rho <= MAX_RHO):
            remedy = f"for example --feature mean=4@2; names are {', '.join(FEATURE_RANGES)}"
            raise UsageError(text, "is not NAME=BINS@RHO", remedy)
        found.append(Feature(name, bins, rho))
    if len(found) > MAX_FEATURES:
        raise UsageError("--feature", f"is given {len(found)} times", f"use it at most {MAX_FEATURES} times")
    return tuple(found)


def parse_reference(options: dict[str, Any], sliders: list[str]) -> ReferenceFilter:
    """Return the reference filter that one of four options declares."""
    from vidstyle.blade import reference_filter
    from vidstyle.blade.program_filter import reference_by_command

    sources = ("reference", "command", "function", "pairs")
    given = [name for name in sources if options[name]]
    if len(given) != 1:
        raise UsageError("train", "needs exactly one reference", f"add one of --{', --'.join(sources)}")
    if options["depth"] != "8" and given[0] != "command":
        raise UsageError("--depth", "has no effect without --command", "remove it")
    if given[0] == "reference":
        return reference_filter.reference_by_name(options["reference"], **_settings(options["settings"]))
    if given[0] == "function":
        return reference_filter.reference_by_function(options["function"], sliders)
    if given[0] == "command":
        return reference_by_command(options["command"], int(options["depth"]))
    return reference_filter.reference_by_pairs(options["pairs"])


def _settings(texts: tuple[str, ...]) -> dict[str, float]:
    try:
        return {name: float(value) for name, value in (text.split("=") for text in texts)}
    except ValueError:
        raise UsageError(" ".join(texts), "is not NAME=NUMBER", "for example --set sigma=2") from None


def parse_configs(options: dict[str, Any], reference: ReferenceFilter) -> list[TrainingConfig]:
    """Return the layout that --bins, --feature and --clip declare, or those from which to choose."""
    from vidstyle.blade.bank import MAX_CLIPS
    from vidstyle.blade.regression import TrainingConfig
    from vidstyle.blade.search.layouts import AUTOMATIC_LAYOUTS, Layout

    if options["size"] % 2 == 0:
        reason, remedy = f"{options['size']} is even", f"use {options['size'] - 1} or {options['size'] + 1}"
        raise UsageError("--size", reason, remedy)
    features = _features(options["features"])
    clips = tuple(sorted(set(options["clips"])))
    if len(clips) > MAX_CLIPS:
        raise UsageError("--clip", f"is given {len(clips)} times", f"use it at most {MAX_CLIPS} times")
    if options["bins"] == "auto" and not (features or clips):
        layouts: tuple[Layout, ...] = AUTOMATIC_LAYOUTS
    else:
        bins = _bins("16x5x3" if options["bins"] == "auto" else options["bins"], features)
        layouts = (Layout(bins, clips),)
    shape = options["rho"], options["size"], reference.sums
    return [TrainingConfig(each.bins, *shape, scale=options["scale"], clips=each.clips) for each in layouts]


def _bins(text: str, features: tuple[Feature, ...]) -> Bins:
    from vidstyle.blade.bank import MAX_FILTERS
    from vidstyle.blade.bins import Bins

    try:
        orientations, strengths, coherences, *others = (int(part) for part in text.split("x"))
        (curvatures,) = others or [1]
    except ValueError:
        reason, remedy = f"{text} is not auto, OxSxC or OxSxCxK", "for example --bins 16x5x3"
        raise UsageError("--bins", reason, remedy) from None
    if orientations < 2 or orientations % 2 or min(strengths, coherences, curvatures) < 1:
        reason = f"{text} is invalid: orientations must be even, the others at least 1"
        raise UsageError("--bins", reason, "for example --bins 16x5x3")
    bins = Bins(orientations, strengths, coherences, curvatures=curvatures, features=features)
    if bins.count > MAX_FILTERS:
        raise UsageError("--bins", f"{bins.count} filters are too many", f"use at most {MAX_FILTERS}")
    return bins
