"""Lettering of panels: subtitles and their speakers, balloons, captions, titles and fonts."""
