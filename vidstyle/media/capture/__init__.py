"""TODO vidstyle/media/capture."""
