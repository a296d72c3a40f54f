"""Read films, images and image sequences."""
