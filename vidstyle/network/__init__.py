"""Neural networks of styles: ONNX files that are checked here and run in another process."""
