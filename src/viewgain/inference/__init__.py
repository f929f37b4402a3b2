"""Scores from a network file through onnxruntime; torch is not needed."""
