"""``viewgain export``: the best weights of a run as an ONNX file with a model card."""

from viewgain.cli._exit import NOT_WRITTEN, print_error
from viewgain.cli._training_commands import Export
from viewgain.errors import ConfigError, StorageError
from viewgain.inference import Source
from viewgain.training import export_run, read_metrics


def run_export(command: Export) -> int:
    """Export; exit code 4 if the file cannot be written."""
    if (command.source is None) != (command.licence is None):
        raise ConfigError("export: wanted --source and --licence together, or neither")
    sources = () if command.source is None else (Source(name=command.source, licence=command.licence or ""),)
    metrics = () if command.metrics is None else read_metrics(command.metrics)
    try:
        card = export_run(command.run, command.out, sources=sources, metrics=metrics)
    except (StorageError, OSError) as error:
        print_error(error)
        return NOT_WRITTEN
    print(f"{command.out}: {card.name}, {card.kind} for {card.views} views of rig {card.rig}, with its card inside and beside it")
    return 0
