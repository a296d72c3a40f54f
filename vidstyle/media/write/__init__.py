"""Write films, images, animations, streams and virtual cameras."""
