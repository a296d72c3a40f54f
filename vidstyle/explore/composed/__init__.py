"""Random styles by the open rules: parts of shipped styles that fit together."""
