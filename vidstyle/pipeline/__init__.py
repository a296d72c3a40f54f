"""TODO vidstyle/pipeline."""
