"""Compile a style to GPU passes and GLSL, without calling OpenGL."""
