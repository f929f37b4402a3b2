import json
from dataclasses import replace
from pathlib import Path

import pytest

from tests.training.conftest import TABLE, changed
from viewgain.datasets import RECIPES
from viewgain.errors import ConfigError
from viewgain.rigs import rig
from viewgain.training import (
    TRAINING_RECIPES,
    TrainingSettings,
    learning_rate,
    recipe_to_table,
    training_recipe,
    training_recipe_from_table,
)


@pytest.mark.parametrize("name", TRAINING_RECIPES)
def test_every_shipped_recipe_fits_its_data(name: str) -> None:
    recipe = training_recipe(name)
    assert recipe.name == name
    assert (recipe.data.recipe or "boxes_recorded") in RECIPES
    # Nobody but the user has recordings, and knows from where: those recipes name neither data nor rig.
    assert (recipe.data.recipe == "") == name.startswith("volume_recorded")
    if recipe.data.rig or not (recipe.network.with_poses or name.startswith("volume_recorded")):
        assert len(rig(recipe.data.rig).stations) == recipe.network.views
    assert recipe.network.with_poses <= (recipe.data.frame == "camera")


def test_the_defaults_are_the_published_values() -> None:
    settings = training_recipe("pc_nbv").training
    assert (settings.learning_rate, settings.batch, settings.iterations) == (1e-4, 32, 400_000)
    assert learning_rate(settings, 49_999) == 1e-4
    assert learning_rate(settings, 100_000) == pytest.approx(1e-4 * 0.7**2)


@pytest.mark.parametrize("form", ["", "_short"])
def test_recordings_are_learned_as_the_papers_boxes_are(form: str) -> None:
    recorded, paper = training_recipe(f"volume_recorded{form}"), training_recipe(f"volume_paper{form}")
    assert replace(recorded.data, recipe=paper.data.recipe, rig=paper.data.rig) == paper.data
    assert replace(recorded.network, offset=paper.network.offset) == paper.network  # those cameras stand nearer
    assert (recorded.training, recorded.loss) == (paper.training, paper.loss)


def test_the_short_forms_of_the_papers_network_learn_as_the_compact_ones_do() -> None:
    """Else what Table 1 says of one beside the other would be about how they were trained."""
    for paper, ours in (("pc_nbv_short", "compact_view"), ("pc_nbv_noview_short", "compact")):
        theirs, own = training_recipe(paper), training_recipe(ours)
        assert theirs.data == own.data
        assert replace(theirs.loss, presence_weight=own.loss.presence_weight) == own.loss
        same = {"learning_rate": own.training.learning_rate, "precision": own.training.precision}
        assert replace(theirs.training, **same) == own.training


def test_a_recipe_comes_back_from_its_table() -> None:
    recipe = changed(loss={"ranking": "listwise"})
    table = json.loads(json.dumps(recipe_to_table(recipe)))
    assert training_recipe_from_table({key: value for key, value in table.items() if key != "name"}, table["name"]) == recipe


def test_warm_up_rises_and_cosine_falls_to_nothing() -> None:
    settings = TrainingSettings(iterations=100, learning_rate=1.0, schedule="cosine", warm_up=10)
    rates = [learning_rate(settings, step) for step in range(100)]
    assert rates[0] == pytest.approx(0.1)
    assert max(rates) == rates[9]
    assert rates[10:] == sorted(rates[10:], reverse=True)
    assert learning_rate(settings, 100) == 0


def test_the_clock_moves_only_the_schedule_that_asks_for_it() -> None:
    by_step = TrainingSettings(iterations=100, schedule="cosine")
    by_clock = TrainingSettings(iterations=100, schedule="cosine_clock")
    assert learning_rate(by_step, 10, clock=0.9) == learning_rate(by_step, 10)
    assert learning_rate(by_clock, 10, clock=0.9) == pytest.approx(learning_rate(by_step, 90))


@pytest.mark.parametrize(
    ("tables", "word"),
    [
        ({"training": {"batch": 0}}, "batch"),
        ({"training": {"validate_every": 3}}, "validate_every"),
        ({"training": {"learning_rate": -1.0}}, "learning_rate"),
        ({"training": {"speed": 3}}, "speed"),
        ({"data": {"validation_share": 1.0}}, "validation_share"),
        ({"data": {"frame": "world"}}, "frame"),
        ({"network": {"kind": "large"}}, "kind"),
        ({"loss": {"ranking": "best"}}, "ranking"),
        ({"extra": {}}, "extra"),
        ({"data": {"turn_deg": float("nan")}}, "turn_deg"),
        ({"data": {"mirror": True}}, "mirror"),
        ({"data": {"within": 0.5}}, "within"),
        ({"data": {"within": -1.0, "whole_scan": True, "frame": "camera"}}, "within"),
        ({"network": {"kind": "pose_scores"}, "data": {"within": 0.5, "whole_scan": True, "frame": "camera"}}, "within"),
        ({"network": {"kind": "compact", "scale": 0.0}}, "scale"),
        ({"network": {"kind": "pose_scores"}, "data": {"symmetry": True}}, "symmetry"),
        ({"network": {"kind": "pose_scores"}, "distil": {"teacher": "a.onnx"}}, "distil"),
        ({"loss": {"presence_weight": 0.1}, "network": {"kind": "compact_view"}}, "presence_weight"),
        ({"network": {"kind": "compact", "views": 16, "rig": "pcnbv16"}, "data": {"rig": "pcnbv33"}}, "pcnbv33"),
        (
            {"network": {"kind": "compact", "views": 16, "rig": "pcnbv16"}, "data": {"rig": "pcnbv16", "frame": "camera"}},
            "camera",
        ),
    ],
)
def test_a_wrong_recipe_names_the_key(tables: dict[str, dict[str, object]], word: str) -> None:
    with pytest.raises(ConfigError, match=word):
        changed(**tables)


@pytest.mark.parametrize(
    ("network", "wanted"),
    [
        ({"offset": [0.0, 1.0]}, "got [0.0, 1.0], wanted a list of 3: a number, a number, a number"),
        ({"shared": 3}, "got 3, wanted a list, of each a whole number"),
        ({"scale": "wide"}, "got 'wide', wanted a number"),
        ({"kind": "large"}, "got 'large', wanted one of pc_nbv, pc_nbv_noview, compact"),
    ],
)
def test_a_value_of_another_type_is_told_what_was_wanted(network: dict[str, object], wanted: str) -> None:
    with pytest.raises(ConfigError) as caught:
        changed(network=network)
    assert wanted in str(caught.value)


def test_a_recipe_without_network_is_refused() -> None:
    with pytest.raises(ConfigError, match="network"):
        training_recipe_from_table({"makes": TABLE["makes"]}, "quick")


@pytest.mark.parametrize("content", ["makes = ", "\x00", "[network]\n"])
def test_a_file_that_is_no_recipe_is_one_line(content: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(content)
    with pytest.raises(ConfigError) as caught:
        training_recipe(path)
    assert "mine" in str(caught.value)
