"""Creates the films of a batch from inputs and styles, with all checks that are possible before rendering."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from vidstyle.batch.batch_film import BatchFilm
from vidstyle.batch.inputs import Source
from vidstyle.batch.journal import Journal
from vidstyle.batch.naming import check_names, result_path
from vidstyle.batch.stored_path import FilmPath
from vidstyle.media.write.containers import find_kind

Settings = Mapping[str, Mapping[str, str]]
"""For each style, everything that determines its results, except the source; see `setting_parts`."""


class Planner:
    """Creates the films of sources, one per style.

    Args:
        template: template of the results' names; see `result_path`.
        settings: settings of the styles.
    """

    def __init__(self, template: str, settings: Settings) -> None:
        self._template, self._settings = template, settings
        self._journals: dict[FilmPath, Journal] = {}

    def films(self, sources: Sequence[Source], earlier: Iterable[BatchFilm] = ()) -> list[BatchFilm]:
        """Return the films of these sources.

        Args:
            earlier: other films of the same batch.

        Raises:
            UsageError: two results have the same name, or one cannot be written under its name.
        """
        films = [
            self._film(source, style, result_path(self._template, source, style))
            for source in sources
            for style in self._settings
        ]
        if films:
            check_names((film.target, film.source, film.style) for film in [*earlier, *films])
        return films

    def _film(self, source: Source, style: str, target: FilmPath) -> BatchFilm:
        find_kind(str(target), None, False)
        folder = target.parent.resolve()
        journal = self._journals.setdefault(folder, Journal(folder))
        return BatchFilm(source, style, target, self._settings[style], journal)
