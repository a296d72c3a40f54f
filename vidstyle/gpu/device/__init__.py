"""Everything that calls OpenGL: contexts, programs, textures, transfers and running a plan."""
