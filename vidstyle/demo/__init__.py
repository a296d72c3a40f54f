"""The demo: a generated film, restyled in several styles and as a comic page."""
