"""The adapter's build: really compiled, kept in a cache, and failing with words that help."""

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from fbcouple.errors import SolverError
from fbcouple.solvers.openfoam import build, headers

SMALL = 'extern "C" int answer() { return 42; }\n'


@pytest.fixture
def headers_kept(tmp_path, monkeypatch):
    """An empty cache but for the headers, which set-up has fetched; a small source instead of the adapter."""
    installation = build.find_installation()
    fetched = build.build_adapter().parent / f"openfoam-{installation.version}-headers"
    cache = tmp_path / "cache"
    cache.mkdir()
    if fetched.is_dir():
        (cache / fetched.name).symlink_to(fetched)
    sources = tmp_path / "sources"
    sources.mkdir()
    (sources / "adapter.cpp").write_text(SMALL)
    monkeypatch.setenv("FBCOUPLE_CACHE", str(cache))
    monkeypatch.setattr(build, "SOURCES", sources)
    return cache


def write_source(text: str, name: str = "adapter.cpp") -> None:
    (build.SOURCES / name).write_text(text)


def write_program(path: Path, text: str) -> Path:
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)
    return path


def test_a_built_adapter_is_used_again_at_once():
    path = build.build_adapter()
    built = path.stat().st_mtime_ns
    start = time.perf_counter()
    assert build.build_adapter() == path
    assert time.perf_counter() - start < 1.0
    assert path.stat().st_mtime_ns == built


def test_the_adapter_sees_openfoam_with_the_libraries_own_sizes(headers_kept):
    checks = 'static_assert(sizeof(Foam::scalar) == 8 && sizeof(Foam::label) == 4, "sizes");\n'
    write_source(f'#include "fvCFD.H"\n{checks}extern "C" int rank() {{ return Foam::Pstream::myProcNo(); }}\n')
    path = build.build_adapter()
    needed = subprocess.run(["readelf", "-d", path], capture_output=True, text=True, check=True).stdout
    assert "libOpenFOAM.so" in needed and "libincompressibleTurbulenceModels.so" in needed


def test_the_key_follows_source_compiler_and_flags(headers_kept, tmp_path, monkeypatch):
    first = build.adapter_path()
    write_source(SMALL + "// changed\n")
    source_changed = build.adapter_path()
    write_source("int more();\n", "more.hpp")
    header_added = build.adapter_path()
    monkeypatch.setenv("CXX", str(write_program(tmp_path / "other", "echo other compiler 1.0")))
    compiler_changed = build.adapter_path()
    monkeypatch.setattr(build, "LIBRARIES", (*build.LIBRARIES, "more"))
    assert len({first, source_changed, header_added, compiler_changed, build.adapter_path()}) == 5


def test_force_builds_again(headers_kept):
    path = build.build_adapter()
    first = path.stat().st_ino
    held = path.open("rb")
    with held:
        assert build.build_adapter(force=True) == path
        assert path.stat().st_ino != first


def test_a_compile_error_has_the_compilers_words_and_leaves_nothing(headers_kept):
    write_source('#include "fvCFD.H"\nint broken = no_such_name;\n')
    with pytest.raises(SolverError) as caught:
        build.build_adapter()
    text = str(caught.value)
    assert "no_such_name" in text and "adapter.cpp:2" in text and "g++" in text and "exit code 1" in text
    assert not [path for path in headers_kept.iterdir() if "adapter" in path.name]


def test_all_sources_are_compiled(headers_kept):
    """The linker refuses a library with a name that none of them defines."""
    write_source('int elsewhere(); extern "C" int answer() { return elsewhere(); }\n')
    write_source("int elsewhere() { return 41; }\n", "other.cpp")
    assert build.build_adapter().is_file()


def test_an_undefined_symbol_is_found_when_it_is_built(headers_kept):
    write_source('extern "C" int elsewhere(); extern "C" int answer() { return elsewhere(); }\n')
    with pytest.raises(SolverError, match="elsewhere"):
        build.build_adapter()


def test_without_a_compiler_the_text_tells_how_to_get_one(headers_kept, monkeypatch):
    monkeypatch.setenv("CXX", "no-such-compiler")
    with pytest.raises(SolverError, match=r"'no-such-compiler' is not on PATH; .*sudo apt-get install g\+\+"):
        build.build_adapter()


def test_without_a_compiler_a_built_adapter_serves(headers_kept, monkeypatch):
    path = build.build_adapter()
    monkeypatch.setenv("CXX", "no-such-compiler")
    assert build.build_adapter() == path
    write_source(SMALL + "// changed\n")
    with pytest.raises(SolverError, match="no-such-compiler"):
        build.adapter_path()


def test_two_builds_at_once_compile_once(headers_kept, tmp_path):
    record = tmp_path / "compiled"
    link = f'echo once >> {record}; sleep 0.5; g++ "$@"'
    compiler = f'case "$*" in *--version*) echo slow 1.0;; *-shared*) {link};; *) g++ "$@";; esac'
    program = (
        "import pathlib, sys; from fbcouple.solvers.openfoam import build;"
        "build.SOURCES = pathlib.Path(sys.argv[1]); print(build.build_adapter())"
    )
    environment = os.environ | {"CXX": str(write_program(tmp_path / "slow", compiler))}
    command = [sys.executable, "-c", program, str(build.SOURCES)]
    builds = [subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    paths = {process.communicate(timeout=60)[0].strip() for process in builds}
    assert [process.returncode for process in builds] == [0, 0]
    assert len(paths) == 1 and Path(paths.pop()).is_file()
    assert record.read_text() == "once\n"


@pytest.fixture
def site(tmp_path, monkeypatch):
    """The parts of a site's own OpenFOAM v1912 that the build reads."""
    project = tmp_path / "OpenFOAM-v1912"
    for folder in ("META-INFO", "src/OpenFOAM/lnInclude", "wmake/rules/General/Gcc"):
        (project / folder).mkdir(parents=True)
    (project / "META-INFO" / "api-info").write_text("api=1912\npatch=0\n")
    (project / "wmake" / "rules" / "General" / "Gcc" / "c++").write_text("CC = g++$(COMPILER_VERSION) -std=c++14\n")
    settings = {
        "WM_PROJECT_DIR": str(project),
        "WM_OPTIONS": "linux64GccSPInt64Opt",
        "WM_PRECISION_OPTION": "SP",
        "WM_LABEL_SIZE": "64",
        "FOAM_LIBBIN": "/site/lib",
        "FOAM_MPI": "openmpi-4.1.2",
    }
    for name, value in settings.items():
        monkeypatch.setenv(name, value)
    return project


def test_a_sites_openfoam_brings_its_flags(site):
    installation = build.find_installation()
    assert installation.project == site and installation.version == "1912-linux64GccSPInt64Opt"
    assert {"-std=c++14", "-DOPENFOAM=1912", "-DWM_SP", "-DWM_LABEL_SIZE=64"} <= set(installation.compile_flags)
    assert {"-L/site/lib", "-Wl,-rpath,/site/lib/openmpi-4.1.2"} <= set(installation.link_flags)


@pytest.mark.parametrize(("api", "standard"), [("2006", "11"), ("2306", "11"), ("2312", "14"), ("2512", "17")])
def test_later_versions_of_openfoam_com_are_taken(site, api, standard):
    """With the C++ standard of the version where its own rules name none."""
    (site / "META-INFO" / "api-info").write_text(f"api={api}\npatch=0\n")
    (site / "wmake" / "rules" / "General" / "Gcc" / "c++").unlink()
    assert {f"-std=c++{standard}", f"-DOPENFOAM={api}"} <= set(build.find_installation().compile_flags)


@pytest.mark.parametrize("about", ["api=1906\n", "api=7\n", "patch=0\n", ""])
def test_another_openfoam_is_refused(site, about):
    (site / "META-INFO" / "api-info").write_text(about)
    with pytest.raises(SolverError, match=r"WM_PROJECT_DIR=.*take openfoam\.com v1912 or later.*unset WM_PROJECT_DIR"):
        build.find_installation()


@pytest.mark.parametrize(
    ("project", "version", "line"),
    [
        ("OpenFOAM", "8", "OpenFOAM 8 of the OpenFOAM Foundation"),
        ("OpenFOAM", "13", "OpenFOAM 13 of the OpenFOAM Foundation .*another adapter and other decks"),
        ("OpenFOAM", "dev", "OpenFOAM dev of the OpenFOAM Foundation"),
        ("foam", "5.0", "foam-extend 5.0"),
    ],
)
def test_another_line_of_openfoam_is_refused_by_its_name(site, project, version, line):
    """As their own etc/bashrc name themselves; they have no META-INFO/api-info."""
    shutil.rmtree(site / "META-INFO")
    (site / "etc").mkdir()
    (site / "etc" / "bashrc").write_text(f"export WM_PROJECT={project}\n  export WM_PROJECT_VERSION={version}\n")
    with pytest.raises(SolverError, match=rf"{line}.*take openfoam\.com v1912 or later"):
        build.find_installation()


def test_another_openfoam_without_its_sources_is_refused_too(site):
    """Its libraries would be taken beside Debian's headers."""
    (site / "META-INFO" / "api-info").write_text("api=1906\n")
    shutil.rmtree(site / "src")
    with pytest.raises(SolverError, match=r"v1906, which the adapter does not compile with"):
        build.find_installation()


def test_without_openfoam_the_text_tells_how_to_get_it(tmp_path, monkeypatch):
    monkeypatch.delenv("WM_PROJECT_DIR", raising=False)
    write_program(tmp_path / "dpkg-query", "echo no packages found matching libopenfoam >&2; exit 1")
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    with pytest.raises(SolverError, match="sudo apt-get install openfoam"):
        build.find_installation()


def test_source_lists_turn_into_deb_src():
    stanza = "Types: deb deb-src\nURIs: http://example.org/debian\nSuites: bookworm\n\ntypes: deb\nURIs: http://b.org\n"
    assert headers.as_source_list(stanza, ".sources").count("Types: deb-src\n") == 2
    lines = "# comment\ndeb [arch=amd64] http://a.org x main\ndeb-src [arch=amd64] http://a.org x main\n\n"
    assert headers.as_source_list(lines, ".list") == "deb-src [arch=amd64] http://a.org x main\n"


def test_a_missing_source_package_names_version_and_mend(tmp_path, monkeypatch):
    write_program(tmp_path / "apt-get", 'case "$*" in *"source --only"*) echo "E: Unable to find it"; exit 100;; esac')
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    with pytest.raises(SolverError) as caught:
        headers.debian_headers("1912.0-1", tmp_path)
    text = str(caught.value)
    assert "openfoam=1912.0-1" in text and "E: Unable to find it" in text and "sudo apt-get update" in text
    assert [path.name for path in tmp_path.iterdir()] == ["apt-get"]
