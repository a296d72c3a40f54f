"""Look through a film: shots, faces, saliency and the features that key frames are scored by."""
