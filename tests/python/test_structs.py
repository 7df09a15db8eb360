"""Structs are keywords over the library's defaults, and refuse what they do not have. Errors have the library's text."""

import numpy as np
import pytest
import talus
from conftest import bed, prepared, settings
from talus import errors


def test_defaults_are_those_of_the_library():
    laws = talus.Laws()
    assert laws.normal == talus.Normal.HERTZ and laws.rolling == talus.Rolling.CONSTANT and laws.rolling_damping == 0.3
    given = talus.Settings()
    assert given.gravity.tolist() == [0, -9.81, 0] and np.isnan(given.domain_lo).all() and given.threads == 1
    assert given.rebalance == talus.Rebalance.AUTO and given.laws.rolling_rate == laws.rolling_rate == 1e-3
    assert talus.Fill().jitter == 1.0 and talus.Fill().first_label == 1


@pytest.mark.parametrize("struct, wrong, right", [
    (talus.Settings, "time_stp", "time_step"), (talus.Laws, "normall", "normal"), (talus.Material, "yuong", "young"),
    (talus.Contact, "friktion", "friction"), (talus.Wall, "nromal", "normal"), (talus.Fill, "radius", "radius_m"),
    (talus.Settings, "struct_size", "domain_lo"), (talus.Settings, "header_version", "domain_lo")])
def test_an_unknown_keyword_is_refused_and_the_right_ones_are_named(struct, wrong, right):
    with pytest.raises(TypeError, match=f"{struct.__name__} has no '{wrong}'.*{right}") as error:
        struct(**{wrong: 1})
    assert all(name in str(error.value) for name in struct.names())


def test_a_misspelt_member_is_refused():
    given = talus.Settings()
    with pytest.raises(AttributeError, match="did you mean 'time_step'"):
        given.timestep = 1e-6


def test_engine_takes_the_keywords_of_settings():
    with pytest.raises(TypeError, match="did you mean 'time_step'"):
        talus.Engine(domain_lo=(0, 0, 0), time_stepp=1)
    with pytest.raises(TypeError, match="not both"):
        talus.Engine(settings(), threads=2)
    with pytest.raises(TypeError, match="talus.Settings"):
        talus.Engine(talus.Laws())


def test_choices_are_text_members_or_numbers():
    assert talus.Laws(normal="linear").normal == talus.Laws(normal=talus.Normal.LINEAR).normal == talus.Laws(normal=1).normal == 1
    assert "rolling='spring'" in repr(talus.Laws(rolling="Spring"))
    with pytest.raises(ValueError, match="Laws.tangential = 'none at all': takes one of force_rescaled, force, displacement, none"):
        talus.Laws(tangential="none at all")
    assert talus.Settings(laws={"rolling": "none"}, rebalance="every").laws.rolling == 0


@pytest.mark.parametrize("values, error, text", [
    (dict(threads=2**32 + 1), ValueError, "does not fit in int32"), (dict(threads=1.5), TypeError, "whole"),
    (dict(threads=[1, 2]), ValueError, "one whole number"), (dict(gravity=(0, 1)), ValueError, "takes 3 numbers"),
    (dict(gravity="down"), TypeError, "real numbers"), (dict(gravity=9.81), ValueError, "takes 3 numbers"),
    (dict(periodic=(0.5, 0, 0)), TypeError, "whole"), (dict(time_step="small"), TypeError, "real"),
    (dict(time_step=None), TypeError, "real"), (dict(seed=-1), ValueError, "does not fit"), (dict(laws=5), TypeError, "")])
def test_values_of_a_wrong_kind_are_refused(values, error, text):
    with pytest.raises(error, match=text):
        talus.Settings(**values)


def test_array_members_share_the_structs_memory():
    given = talus.Settings(gravity=np.array([0, 0, -1.62], "f4"), periodic=(True, False, True))
    given.gravity[0] = 0.5
    np.testing.assert_allclose(given.gravity, (0.5, 0, -1.62), rtol=1e-6)
    assert given.periodic.tolist() == [1, 0, 1]
    given.laws.rolling_rate = 2e-3
    assert given.laws.rolling_rate == 2e-3
    gravity = given.gravity
    del given
    assert gravity[0] == 0.5


def test_all_faults_of_settings_are_told_at_once():
    with pytest.raises(talus.ArgumentError) as error:
        talus.Engine()
    assert all(text in str(error.value) for text in ("domain_lo/hi x", "domain_lo/hi z", "time_step"))
    with pytest.raises(talus.ArgumentError):
        talus.Engine(settings(rank_grid=(2, 1, 1)))
    with pytest.raises(talus.ArgumentError):
        talus.Engine(settings(laws=dict(normal=17)))


def explode():
    """Two grains that overlap by nine tenths and rush into each other."""
    with prepared() as engine:
        engine.insert([0, 1], [(0.02, 0.02, 0.02), (0.0211, 0.02, 0.02)], 1e-3, velocity=[(300, 0, 0), (0, 0, 0)], max_overlap=1.0)
        engine.step(10)


def lose():
    with prepared() as engine:
        engine.insert(17, (0.039, 0.02, 0.02), 1e-3, velocity=(10, 0, 0))
        engine.step(1000)


def too_late():
    with bed(10) as engine:
        engine.step(1)
        engine.add_material(young=1e6, poisson=0.2, density=1000)


def no_such_folder(tmp_path):
    with bed(10) as engine:
        engine.save(tmp_path / "missing/bed.ckpt")


def damaged(tmp_path):
    (tmp_path / "bed.ckpt").write_bytes(b"no checkpoint")
    talus.Engine.load(tmp_path / "bed.ckpt")


@pytest.mark.parametrize("fail, error, base, text", [
    (lambda _: prepared().wall(7), talus.ArgumentError, ValueError, "wall 7"),
    (lambda _: prepared().step(-1), talus.ArgumentError, ValueError, "n_steps = -1"),
    (lambda _: too_late(), talus.StateError, RuntimeError, "before the first step"),
    (lambda _: talus.Engine(settings(), comm=0), talus.StateError, RuntimeError, "MPI is not initialised"),
    (lambda _: explode(), talus.UnstableError, ArithmeticError, "exploding"),
    (lambda _: lose(), talus.LostError, ArithmeticError, "grain 17 left the domain"),
    (no_such_folder, talus.FileError, OSError, "missing/bed.ckpt"),
    (damaged, talus.FileError, OSError, "bed.ckpt"),
    (lambda t: prepared().save(f"{t}/a\0b"), ValueError, ValueError, "zero byte")])
def test_failures_are_exceptions_with_the_librarys_text(tmp_path, fail, error, base, text):
    with pytest.raises(error, match=text) as caught:
        fail(tmp_path)
    assert isinstance(caught.value, base)
    if isinstance(caught.value, talus.TalusError):
        assert talus.status_string(caught.value.status) == f"TALUS_{caught.value.status.name}"


def test_every_status_has_a_class_of_its_own():
    from talus import _handle

    for status in talus.Status:
        if status >= 0:
            _handle.raise_for(status, b"")
            continue
        with pytest.raises(talus.TalusError, match="the reason") as caught:
            _handle.raise_for(status, b"the reason")
        assert caught.value.status == status and type(caught.value) is errors.BY_STATUS[status]
    assert len(set(errors.BY_STATUS.values())) == len(errors.BY_STATUS)
    with pytest.raises(talus.TalusError, match="status -77"):
        _handle.raise_for(-77, b"")
