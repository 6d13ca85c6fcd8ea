"""The model in other runtimes, for `cargo compare`: ONNX graphs, and contenders in Python."""
