"""Draw the pictures of the documentation and the thumbnails of styles."""

import os

os.environ["XDG_CONFIG_HOME"] = os.devnull  # without the user's own styles
