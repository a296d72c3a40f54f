"""A page for judging styles by eye, on photographs and clips at full size."""
