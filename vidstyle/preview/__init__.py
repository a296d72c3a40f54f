"""The input on a page: frames by number, encoded pictures, and plans for the renderer of the page."""
