"""The user's own picture on a page: frames by number, encoded pictures, and plans for the page's renderer."""
