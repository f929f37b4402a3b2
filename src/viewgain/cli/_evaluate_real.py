"""``viewgain evaluate real``: what policies would do next on real scans, each read, ranked and drawn before the next."""

import json
from functools import partial
from pathlib import Path

from viewgain.cli._exit import NOTHING_MEASURED
from viewgain.cli._finish import finish, write_picture
from viewgain.cli._volume_commands import EvaluateReal
from viewgain.datasets import make_folder
from viewgain.errors import ConfigError, MissingExtraError, ScanError
from viewgain.evaluation import RealRanking, Unread, check_real_policies, ranked, real_markdown
from viewgain.report import write_ranking_picture
from viewgain.rigs import rig
from viewgain.scans import READERS, Scan, read_scan


def run_evaluate_real(command: EvaluateReal) -> int:
    """Print the table; exit code 3 if no view could be ranked on any scan."""
    check_real_policies(command.policies)
    rig(command.rig)
    files = _files(command.scans)
    if command.out is not None:
        make_folder(command.out)
    rankings: list[RealRanking] = []
    unread: list[Unread] = []
    for file, source, named in files:
        scan = _scan(file, source, unread, named=named)
        if scan is None:
            continue
        ranking = ranked(scan, source, command.rig, command.policies)
        rankings.append(ranking)
        if command.out is not None:
            picture = command.out / f"{len(rankings):02d}_{file.stem}.png"
            write_picture(picture, partial(write_ranking_picture, scan, ranking))
    if not rankings:
        raise ScanError(f"{command.scans[0]}: holds no file that can be read as a scan; wanted one of {' '.join(READERS)}")
    content = {
        "rig": command.rig,
        "scans": [ranking.to_dict() for ranking in rankings],
        "not_read": [{"file": each.source, "reason": each.reason} for each in unread],
    }
    finish(
        "real",
        as_json=json.dumps(content, allow_nan=False) + "\n",
        as_markdown=real_markdown(rankings, unread, command.rig),
        prints_json=command.json,
        out=command.out,
    )
    return 0 if any(ranking.foretold.candidates for ranking in rankings) else NOTHING_MEASURED


def _files(named: tuple[Path, ...]) -> list[tuple[Path, str, bool]]:
    """Return each file, its name in the table, and whether it was named itself rather than found in a folder."""
    if not named:
        raise ConfigError("evaluate real: got no scan, wanted files or folders of them")
    files = []
    for path in named:
        if path.is_dir():
            found = sorted(each for each in path.rglob("*") if each.is_file() and each.suffix.lower() in READERS)
            files += [(each, each.relative_to(path).as_posix(), False) for each in found]
        else:
            files.append((path, path.name, True))
    return files


def _scan(file: Path, source: str, unread: list[Unread], *, named: bool) -> Scan | None:
    """Return a scan; None for what is no scan in a folder, which is noted. A file that was named must be one."""
    try:
        return read_scan(file)
    except (ScanError, ConfigError, MissingExtraError) as error:
        if named:
            raise
        unread.append(Unread(source, str(error).removeprefix(f"{file}: ")))
        return None
