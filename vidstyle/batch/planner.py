"""Creates the films of a batch from inputs and looks, with all checks that are possible before rendering."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from vidstyle.batch.batch_film import BatchFilm, State
from vidstyle.batch.inputs import Source
from vidstyle.batch.journal import Journal
from vidstyle.batch.naming import check_names, has_fields, result_path, source_text
from vidstyle.batch.stored_path import FilmPath
from vidstyle.errors import VidstyleError
from vidstyle.media.write.containers import find_kind

Settings = Mapping[str, str]
"""Everything that determines a result, except its source; see `setting_parts`."""


@dataclass
class FilmLook:
    """A look of films, such as `--style ink` or `--cues cues/{name}.toml`.

    Args:
        option: the option.
        value: its value, which may have the fields {name} and {folder}.
        settings_of: returns the settings of a value; raises VidstyleError.
    """

    option: str
    value: str
    settings_of: Callable[[str], Settings]
    _known: dict[str, Settings] = field(default_factory=dict, init=False)

    def __post_init__(self) -> None:
        """Read the settings that all films share; raises VidstyleError."""
        if not has_fields(self.value):
            self._known[self.value] = self.settings_of(self.value)

    def settings(self, value: str) -> Settings:
        """Return the settings of a value whose fields are filled in; raises VidstyleError."""
        return self._known.get(value) or self.settings_of(value)


class Planner:
    """Creates the films of sources, one per look.

    Args:
        template: template of the results' names; see `result_path`.
        looks: the looks.
    """

    def __init__(self, template: str, looks: Sequence[FilmLook]) -> None:
        self._template, self._looks = template, looks
        self._journals: dict[FilmPath, Journal] = {}

    def films(self, sources: Sequence[Source], earlier: Iterable[BatchFilm] = ()) -> list[BatchFilm]:
        """Return the films of these sources.

        Args:
            earlier: other films of the same batch.

        Raises:
            UsageError: two results have the same name, or one cannot be written under its name.
        """
        films = [self._film(source, look) for source in sources for look in self._looks]
        if films:
            check_names((film.target, film.source, film.style) for film in [*earlier, *films])
        return films

    def _film(self, source: Source, look: FilmLook) -> BatchFilm:
        """Return a film; it has failed if its look cannot be read."""
        style = source_text(look.option, look.value, source)
        target = result_path(self._template, source, style)
        find_kind(str(target), None, False)
        folder = target.parent.resolve()
        journal = self._journals.setdefault(folder, Journal(folder))
        film = BatchFilm(source, style, target, {}, journal, option=look.option)
        try:
            film.settings = look.settings(style)
        except VidstyleError as error:
            film.end(State.FAILED, str(error), error.exit_code)
        return film
