"""Draw the pictures of the documentation and the thumbnails of styles."""
