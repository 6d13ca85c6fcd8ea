"""The core on calibrated and miscalibrated cameras."""

from __future__ import annotations

import json

import nsrm
import numpy as np
import pytest
from world_scenes import DOMAIN

from nsrm_harness.cli.main import main
from nsrm_harness.evaluation.miscalibration.faults import FAULTS
from nsrm_harness.evaluation.miscalibration.measure import MiscalibrationReport, measure
from nsrm_harness.evaluation.miscalibration.scenes import KINDS, scenes
from nsrm_harness.geometry.camera import default_camera

COUNT = 12
GROSS = ("5 cm in height", "depths -5 %", "depths +5 %", "tilted by -3", "tilted by +3")
"""What names faults begin or end with that must always be found."""


@pytest.fixture(scope="module")
def report() -> MiscalibrationReport:
    return measure(nsrm.Model.pretrained(), DOMAIN, COUNT, 7, KINDS[:3])


def test_no_calibrated_scene_is_refused(report: MiscalibrationReport) -> None:
    rows = [row for row in report.rows if row.fault == "none"]
    assert {(row.kind, row.boxes) for row in rows} == {
        (kind.name, boxes) for kind in KINDS[:3] for boxes in ("mask", "detector")
    }
    assert all(row.scenes == COUNT for row in rows)
    assert [row for row in rows if row.refused] == []


def test_what_would_put_sub_goals_centimetres_off_is_always_found(
    report: MiscalibrationReport,
) -> None:
    gross = [fault.name for fault in FAULTS if any(part in fault.name for part in GROSS)]
    assert len(gross) == 6
    assert {name: report.share(name) for name in gross} == dict.fromkeys(gross, 1.0)


def test_other_units_and_conventions_are_told_as_such(report: MiscalibrationReport) -> None:
    causes = {fault.name for fault in FAULTS if fault.cause is not None}
    rows = [row for row in report.rows if row.fault in causes]
    assert len(causes) == 6
    assert [row for row in rows if row.known != row.scenes] == []


def test_a_shift_along_the_table_is_not_found(report: MiscalibrationReport) -> None:
    """What the documentation says is impossible."""
    assert report.share("principal point +20 px in x") == 0.0


def test_faults_change_what_they_say() -> None:
    named = {fault.name: fault for fault in FAULTS}
    assert len(named) == len(FAULTS)
    camera = default_camera()
    assert FAULTS[0].change(camera) == camera
    higher = named["pose +5 cm in height"].change(camera)
    assert np.subtract(higher.position, camera.position) == pytest.approx((0.0, 0.0, 0.05))
    inverted = named["pose inverted"].change(camera)
    there = camera.pose.matrix() @ inverted.pose.matrix()
    np.testing.assert_allclose(there, np.eye(4), atol=1e-12)
    rolled = named["rolled by +3 degrees"].change(camera)
    right = camera.pose.rotation().T @ rolled.pose.rotation()[:, 0]
    assert np.degrees(np.arctan2(right[1], right[0])) == pytest.approx(3.0)


def test_scenes_depend_on_seed_kind_and_place_alone() -> None:
    two = list(scenes(KINDS[1], DOMAIN, 2, 5))
    again = list(scenes(KINDS[1], DOMAIN, 2, 5))
    for one, other in zip(two, again, strict=True):
        np.testing.assert_array_equal(one.boxes, other.boxes)
    assert two[0].boxes.shape != two[1].boxes.shape or (two[0].boxes != two[1].boxes).any()


def test_the_command_prints_tables_or_json(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["miscalibration", "--count", "1", "--json"])
    assert ended.value.code == 0
    rows = json.loads(capsys.readouterr().out)
    assert len(rows) == len(KINDS) * 2 * len(FAULTS)
    assert {row["scenes"] for row in rows} == {1}


def test_the_report_has_a_line_for_each_kind_and_fault(report: MiscalibrationReport) -> None:
    lines = str(report).splitlines()
    assert f"| {KINDS[0].name} | mask | {COUNT} | 0 |" in lines
    assert "| depths in millimetres | 100.0 % | 100.0 % |" in lines
    assert "| principal point +20 px in x | 0.0 % | - |" in lines
    assert len(lines) == 2 + 2 * 3 + 1 + 2 + len(FAULTS) - 1
