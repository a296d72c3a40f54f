"""Everything that touches PyAV: films, pictures and pipes, in and out."""
