"""TODO vidstyle/demo."""
