"""Layout of pages and strips: the shapes of panels and the parts of pictures that they show."""
