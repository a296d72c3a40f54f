"""Random styles by the rules of the paper (section 6.2)."""
