"""All calls of OpenGL: contexts, programs, textures, transfers, and running a plan."""
