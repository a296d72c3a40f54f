"""Media input and output with PyAV: files, images, streams, devices."""
