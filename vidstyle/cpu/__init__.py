"""Execute a style on the CPU with NumPy, OpenCV and Numba; the reference that the GPU is compared with."""
