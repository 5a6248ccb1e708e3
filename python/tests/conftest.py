"""The program that the tests compare with, and a machine's file."""

import json
import os
import subprocess

import pytest

import stiction


@pytest.fixture(scope="session")
def program():
    """Return a function that calls the command line and returns its output."""
    path = os.environ["STICTION"]

    def call(*arguments, ok=True):
        made = subprocess.run([path, *map(str, arguments)], capture_output=True, text=True)
        assert (made.returncode == 0) == ok, made.stderr
        return made.stdout if ok else made.stderr

    return call


@pytest.fixture(scope="session")
def report(program):
    """Return a function that calls the command line and returns its JSON."""
    return lambda *arguments: json.loads(program(*arguments, "--json"))


@pytest.fixture
def arm(tmp_path):
    """Return the path of a typical joint's file."""
    return stiction.new(tmp_path / "arm.toml", "harmonic")
