"""The page: well-formed, complete, readable without pictures, closed to the network, and safe whatever a file was called."""

import base64
import re
from dataclasses import replace
from pathlib import Path

import pytest

from tests.report.html import Element, Page
from viewgain.episodes import Episode
from viewgain.plan import Assessment
from viewgain.report import write_report
from viewgain.report._embedded import range_file, scene_file
from viewgain.report._page import render_page


@pytest.fixture(scope="module")
def folder(episode: Episode, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_report(episode, tmp_path_factory.mktemp("report")).parent


@pytest.fixture(scope="module")
def page(folder: Path) -> Element:
    return Page((folder / "index.html").read_text(encoding="utf-8")).root


def rendered(episode: Episode) -> str:
    """The page with pictures of one byte."""
    numbers = range(1, len(episode.steps) + 1)
    pngs = dict.fromkeys(["dimensions.png", *map(range_file, numbers), *map(scene_file, numbers)], b"x")
    return render_page(episode, pngs).decode()


def section(page: Element, number: int) -> Element:
    return next(found for found in page.all("section") if found.attributes.get("id") == f"view{number}")


def rows(table: Element) -> list[list[str]]:
    return [[cell.words() for cell in row.inside] for row in table.all("tbody")[0].all("tr")]


def test_nothing_is_fetched_from_anywhere(page: Element, folder: Path) -> None:
    every = [element for tag in ("img", "link", "a", "script", "iframe") for element in page.all(tag)]
    targets = [element.attributes[key] or "" for element in every for key in ("src", "href") if key in element.attributes]
    assert targets
    assert all(target.startswith(("data:", "#")) for target in targets)
    text = (folder / "index.html").read_text()
    assert not re.search(r"https?://|url\(|@import", text)
    assert any("default-src 'none'" in (meta.attributes.get("content") or "") for meta in page.all("meta"))


def test_there_is_one_section_per_view_and_every_inner_link_leads_somewhere(page: Element, episode: Episode) -> None:
    views = [found for found in page.all("section") if found.attributes.get("class") == "step"]
    assert [view.attributes["id"] for view in views] == [f"view{number}" for number in range(1, len(episode.steps) + 1)]
    ids = [element.attributes["id"] for tag in ("section", "h2") for element in page.all(tag) if "id" in element.attributes]
    assert len(ids) == len(set(ids))
    assert {(link.attributes["href"] or "").removeprefix("#") for link in page.all("a")} <= set(ids)


def test_every_picture_has_a_text_and_is_the_file_beside_the_page(page: Element, folder: Path) -> None:
    figures = page.all("figure")
    assert len(figures) == len(list(folder.glob("*.png"))) == len(page.all("img"))
    for figure in figures:
        (image,) = figure.all("img")
        assert len(image.attributes["alt"] or "") > 30
        name = re.search(r"File: (\S+\.png)", figure.words())
        assert name
        kind, _, data = (image.attributes["src"] or "").partition(",")
        assert kind == "data:image/png;base64"
        assert base64.b64decode(data, validate=True) == (folder / name.group(1)).read_bytes()


def test_the_page_reads_without_pictures(page: Element) -> None:
    assert page.all("html")[0].attributes["lang"] == "en"
    assert len(page.all("h1")) == 1
    assert all(table.all("caption") and table.all("th") for table in page.all("table"))
    assert all(cell.attributes.get("scope") in ("col", "row") for cell in page.all("th"))


def test_the_top_says_what_came_out_and_why_it_ended(page: Element, episode: Episode) -> None:
    top = page.all("header")[0].words()
    estimate = episode.steps[-1].fused.boxes[0]
    assert "A box measured in 2 views" in top
    assert f"{1000 * estimate.dimensions[0]:.1f} ± {1000 * (estimate.sigma[0] or 0):.1f} mm" in top
    assert f"{1000 * estimate.volume:.2f}" in top
    assert "450.0 × 300.0 × 250.0 mm, 33.75 litres" in top
    assert "known as well as asked for" in top


def test_an_open_dimension_is_a_lower_bound_without_error(page: Element) -> None:
    length, width, height, volume = rows(section(page, 1).all("table")[0])
    assert length[0] == "Length"
    assert width[0] == "Width (upright)"
    assert length[1] != height[1].removeprefix("≥ ")
    assert height[1].startswith("≥ ")
    assert (height[5], height[7]) == ("open", "lower bound")
    assert volume[7] == "lower bound"
    assert "open: The scans do not bound every dimension" in section(page, 1).words()


def test_a_measured_dimension_stands_beside_its_truth(page: Element, episode: Episode) -> None:
    for row, true in zip(rows(section(page, 2).all("table")[0]), (450.0, 300.0, 250.0, 33.75), strict=True):
        assert float(row[6]) == true
        assert float(row[1]) == pytest.approx(true, rel=0.05)
        assert f"{float(row[1]) - true:+.2f}".replace("-", "−")[:4] == row[7][:4]


def test_the_winner_stands_first_and_alone_is_marked(page: Element, episode: Episode) -> None:
    for number, step in enumerate(episode.steps, start=1):
        table = section(page, number).all("table")[1]
        marked = [row for row in table.all("tr") if row.attributes.get("class") == "best"]
        assert len(marked) == 1
        assert rows(table)[0][0] == f"{step.plan.best} (winner)"
        assert len(rows(table)) == len(step.plan.candidates)
        assert f"Candidate {step.plan.best} " in section(page, number).words()


def test_the_winner_stands_first_even_where_another_scores_a_little_higher(episode: Episode) -> None:
    step = episode.steps[0]
    plan = replace(step.plan, best=min(step.plan.candidates, key=lambda candidate: candidate.assessment.score).index)
    page = Page(rendered(replace(episode, steps=(replace(step, plan=plan),)))).root
    scores = [float(row[5].removesuffix(" %").replace("−", "-")) for row in rows(section(page, 1).all("table")[1])]
    assert rows(section(page, 1).all("table")[1])[0][0] == f"{plan.best} (winner)"
    assert scores[1:] == sorted(scores[1:], reverse=True)
    assert scores[0] < scores[1]


def test_expectation_and_outcome_of_a_move_stand_side_by_side(page: Element, episode: Episode) -> None:
    best = episode.steps[0].plan.candidates[episode.steps[0].plan.best or 0]
    assert best.assessment.outlook is not None
    sigma = f"{1000 * best.assessment.outlook.volume_sigma:.3f} litres"
    assert f"The plan expected a standard deviation of the volume of {sigma} after this view; it is" in section(page, 2).words()


def test_markup_in_a_name_is_shown_and_not_obeyed(episode: Episode) -> None:
    name = '<script>alert("1")</script>'
    step = episode.steps[0]
    hostile = replace(step, scan=replace(step.scan, source=name), fused=replace(step.fused, notes=(name,)))
    text = rendered(replace(episode, steps=(hostile, *episode.steps[1:])))
    assert "<script" not in text
    assert Page(text).root.words().count(name) == 2


def test_a_policy_that_foresees_nothing_leaves_its_columns_blank(episode: Episode) -> None:
    step = episode.steps[0]
    blind = tuple(
        replace(candidate, assessment=Assessment(candidate.index / 10, None, None), reachable=candidate.index != 1)
        for candidate in step.plan.candidates
    )
    plan = replace(step.plan, candidates=blind, best=7, policy="random")
    page = Page(rendered(replace(episode, steps=(replace(step, plan=plan),)))).root
    table = rows(section(page, 1).all("table")[1])
    assert table[0][2:6] == ["–", "–", "–", "0.700"]
    assert table[-1][0] == "1"
    assert table[-1][-1] == "no"
    assert "the policy “random” gave it the highest score" in section(page, 1).words()


def test_nothing_measured_says_why_and_what_to_do(blob: Episode, empty: Episode) -> None:
    near = section(Page(rendered(blob)).root, 1).words()
    assert "the object leaves the image on so many sides" in near
    assert "Move back." in near
    assert "There is no next view: nothing stands on the floor." in section(Page(rendered(empty)).root, 1).words()
