"""Detection of faces in a picture by neural networks of the package mtcnn."""
