"""Tables on the terminal: numbers and their sentences, beside each other where there is room, else below."""

from __future__ import annotations

from functools import partial

import pytest

from fbcouple.cli import table

COLUMNS = ["number", "value", "wanted", "meaning"]
SENTENCE = "Dashpots act half a step late: with fewer a packed bed creeps and never comes to rest."
ROWS = [["DEM steps per contact", "6", "at least 6", SENTENCE], ["settled height", "0.03", "below 0.12", "At rest."]]


@pytest.mark.parametrize(("width", "lines"), [(60, 9), (150, 3)])
def test_sentences_go_below_where_there_is_no_room_beside(monkeypatch, capsys, width, lines):
    monkeypatch.setattr(
        table, "TableConsole", partial(table.TableConsole, width=width, force_terminal=True, color_system=None)
    )
    table.print_explained(COLUMNS, ROWS)
    printed = capsys.readouterr().out.splitlines()
    assert len(printed) == lines and max(map(len, printed)) <= width
    assert " ".join(" ".join(line.split()) for line in printed).count("Dashpots act half") == 1
