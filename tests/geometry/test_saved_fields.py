"""Fields of a checkpoint as OpenFOAM would read them: numbers and known words pass, whatever could be code does not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fbcouple.errors import CaseError
from fbcouple.geometry.saved_fields import list_words, require_known_words

BANNER = b"/*--------------------------------*- C++ -*----------------------------------*\\\n| field |\n\\*---*/\n"
HEADER = b"""FoamFile
{
    version     2.0;
    format      binary;
    class       volScalarField;
    arch        "LSB;label=32;scalar=64";
    location    "0.0025";
    object      p;
}
// * * * * * * //

dimensions      [0 2 -2 0 0 0 0];
"""
DECK = "boundaryField { outlet { // over libs\n type fixedMean; value uniform 0; } }"
# Bytes that look like all that a reader of text might trip over.
VALUES = b'#{}()"//*;\n' * 8


def write(path: Path, entry: bytes = b"", values: bytes = VALUES, header: bytes = BANNER + HEADER) -> Path:
    """A field p of as many numbers as `values` holds, with `entry` in the patch outlet."""
    inner = b"internalField   nonuniform List<scalar> \n%d\n(%s);\n" % (len(values) // 8, values)
    patches = b"boundaryField\n{\n outlet\n {\n type fixedMean;\n value nonuniform List<scalar> 0;\n%s\n }\n" % entry
    more = b" procBoundary0to1throughxlo\n {\n type processor;\n value uniform -1.5e-07;\n }\n}\n// ***** //\n"
    path.write_bytes(header + inner + patches + more)
    return path


@pytest.fixture
def field(tmp_path):
    return tmp_path / "p"


def test_numbers_and_words_of_the_decks_pass(field):
    require_known_words(write(field), list_words([DECK]))
    require_known_words(write(field, values=np.arange(9.0).tobytes()), list_words([DECK]))


@pytest.mark.parametrize(
    "entry",
    [
        b'value #codeStream { code #{ system("touch x"); #}; };',
        b'#include "/etc/passwd"',
        b'#calc "1+1";',
        b'libs ("x.so");',
        b"type codedFixedValue;",
        b"value $internalField;",
        b"// value nonuniform List<scalar> 1\n(12345678) type coded;",
        b"/* */ type coded;",
        b'value "open;\nlibs (x);',
        b"value nonuniform List<scalar> 4\n(1 2 3 4);",
        b"value nonuniform List<scalar> 999999999999\n(12345678);",
        b"value nonuniform List<word> 1(x);",
        b"over 1;",
        b"\xff 1;",
    ],
)
def test_what_could_be_code_is_refused(field, entry):
    with pytest.raises(CaseError):
        require_known_words(write(field, entry), list_words([DECK]))


@pytest.mark.parametrize(
    "change",
    [
        (b"format      binary", b"format      ascii"),
        (b"format      binary;", b"format binary; format ascii;"),
        (b"FoamFile", b"FoamFile { format ascii; } FoamFile"),
        (b"FoamFile", b"libs (x);\nFoamFile"),
        (b"scalar=64", b"scalar=32"),
        (b"/*----", b"libs (x);\n/*----"),
        (b"0.0025", b"../../0.0025"),
    ],
)
def test_a_header_that_makes_bytes_into_text_is_refused(field, change):
    """OpenFOAM would read as text what is passed over here as numbers."""
    assert change[0] in BANNER + HEADER
    with pytest.raises(CaseError):
        require_known_words(write(field, header=(BANNER + HEADER).replace(*change, 1)), list_words([DECK]))
