"""Execute a style on the CPU with NumPy, OpenCV and Numba; the GPU must agree with its results."""
