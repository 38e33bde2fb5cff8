"""Digests change with what a result depends on, and with nothing else."""

import pytest

from visualspeech import provenance


def test_digest_ignores_the_order_of_keys_and_sees_values():
    assert provenance.digest({"a": 1, "b": [2]}) == provenance.digest({"b": [2], "a": 1})
    assert provenance.digest({"a": 1}) != provenance.digest({"a": 2})


def test_split_hash_sees_every_assignment():
    split = {"a": "train", "b": "test"}
    assert provenance.split_hash(split) == provenance.split_hash({"b": "test", "a": "train"})
    assert provenance.split_hash(split) != provenance.split_hash({"a": "test", "b": "train"})


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A package of three modules: ``used`` is reached through a lazy import of ``middle``, ``other`` by nothing."""
    root = tmp_path / "pack"
    root.mkdir()
    (root / "__init__.py").write_text("")
    (root / "middle.py").write_text(
        '"""Doc."""\ndef run():\n    """Doc."""\n    from pack.used import f\n    return f\n'
    )
    (root / "used.py").write_text("def f():\n    return 1\n")
    (root / "other.py").write_text("x = 1\n")
    script = tmp_path / "script.py"
    script.write_text("from pack import middle\nmiddle.run()\n")
    monkeypatch.setattr(provenance, "PACKAGE", root)
    return root, script


def fresh(script):
    """A digest as another process would make it."""
    provenance._read.cache_clear()
    provenance._files.cache_clear()
    return provenance.code_digest(script)


def test_code_digest_follows_imports_inside_functions(package):
    root, script = package
    before = fresh(script)
    (root / "used.py").write_text("def f():\n    return 2\n")
    assert fresh(script) != before


def test_code_digest_ignores_docstrings_comments_and_unused_modules(package):
    root, script = package
    before = fresh(script)
    (root / "middle.py").write_text('"""Other."""\ndef run():\n    # Why.\n    from pack.used import f\n    return f\n')
    (root / "other.py").write_text("x = 2\n")
    assert fresh(script) == before


def test_code_digest_sees_the_script_itself(package):
    _, script = package
    before = fresh(script)
    script.write_text("from pack import middle\nprint(middle.run())\n")
    assert fresh(script) != before


def test_code_digest_sees_the_data_that_a_module_names(package):
    root, script = package
    for folder in ("pages", "others"):
        (root / folder).mkdir()
        (root / folder / "page.html").write_text("<p>")
    (root / "used.py").write_text('def f():\n    return Path(__file__).parent / "pages"\n')
    before = fresh(script)
    (root / "others" / "page.html").write_text("<b>")
    assert fresh(script) == before
    (root / "pages" / "page.html").write_text("<b>")
    assert fresh(script) != before


def test_code_digest_of_a_real_module_reaches_lazy_imports():
    reached = provenance._read(provenance.PACKAGE / "corpora" / "adapters.py").imports
    assert provenance.PACKAGE / "corpora" / "grid.py" in reached
