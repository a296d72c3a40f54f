"""Film analysis: shots, faces, saliency and the features by which key frames are scored."""
