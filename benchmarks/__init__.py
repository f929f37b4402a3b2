"""The figures of README and docs, each from one command: ``python -m benchmarks [accuracy|closed-loop|real|calibration]``."""
