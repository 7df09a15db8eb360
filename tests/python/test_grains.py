"""Arrays in and out: views that are no copies, copies in the order of labels, and arguments that are wrong."""

import warnings

import numpy as np
import pytest
import talus
from conftest import RADIUS, bed, prepared

VIEWS = ["position", "radius", "velocity", "angular_velocity", "mass"]


@pytest.mark.parametrize("field", VIEWS)
def test_views_are_the_engines_memory(world, field):
    world.step(3)
    view = world.view(field)
    first, second = view.array, world.view(field).array
    assert np.shares_memory(first, second)
    assert first.__array_interface__["data"][0] == second.__array_interface__["data"][0] != 0
    assert first.shape == view.shape == ((200,) if field in ("radius", "mass") else (200, 3))
    assert first.dtype == view.dtype == np.float64 and not first.flags.owndata and not first.flags.writeable
    with pytest.raises(ValueError):
        first[0] = 1.0
    order = np.argsort(first if first.ndim == 1 else first[:, 0], kind="stable")
    copied = world.copy(field)
    assert sorted(map(tuple, np.atleast_2d(first[order].T).T.tolist())) == sorted(map(tuple, np.atleast_2d(copied.T).T.tolist()))


def test_views_of_two_fields_lie_in_the_same_records(world):
    position, radius = world.view("position").array, world.view("radius").array
    assert position.strides[0] == radius.strides[0] > 24


CHANGES = {
    "step": lambda e: e.step(1),
    "add_velocity": lambda e: e.add_velocity((0.1, 0, 0)),
    "stop_grains": lambda e: e.stop_grains(),
    "insert": lambda e: e.insert(10**6, (0.02, 0.035, 0.02), RADIUS),
    "remove_above": lambda e: e.remove_above(1, 3.5e-3),
}


@pytest.mark.parametrize("change", CHANGES)
def test_a_view_is_stale_once_the_engine_has_moved_on(world, change):
    world.step(1)
    view = world.view("velocity")
    world.state(), world.energy(), world.copy("force")
    assert not view.stale and view.array.shape == (200, 3), "what only looks leaves views fresh"
    CHANGES[change](world)
    assert view.stale and view.generation != world.generation
    for use in (lambda: view.array, lambda: view[0], lambda: np.asarray(view), lambda: view + 1, lambda: np.linalg.norm(view)):
        with pytest.raises(talus.StaleView, match="Take the view anew"):
            use()
    assert world.view("velocity").array.shape[1] == 3


def test_a_view_works_where_an_array_does(world):
    view = world.view("position")
    array = world.view("position").array
    assert (np.asarray(view) == array).all() and np.shares_memory(np.asarray(view), array)
    assert (view * 2 == array * 2).all() and (np.sqrt(view) == np.sqrt(array)).all() and (view == array).all()
    assert view[:, 1].max() == array[:, 1].max() and len(view) == 200
    assert np.asarray(view, dtype="f4").dtype == np.float32
    assert not np.shares_memory(view[3], array), "a part is a copy, which cannot go stale unseen"


def test_a_bare_array_that_is_kept_is_warned_of_once(world):
    kept = world.view("radius").array
    with pytest.warns(talus.StaleArrayWarning, match="'radius'"):
        world.step(1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        world.step(1)
        world.view("radius").array.sum()
        world.step(1)
    del kept


def test_copies_are_in_the_order_of_labels():
    n = 50
    label = np.random.default_rng(3).permutation(1000)[:n]
    place = np.stack(np.unravel_index(np.arange(n), (5, 2, 5)), axis=1) * 3e-3 + 2e-3
    radius = 0.5e-3 + 1e-6 * label
    with prepared() as engine:
        engine.insert(label, place, radius, velocity=place, angular_velocity=2 * place, colour=label % 256, group=1)
        order = np.argsort(label)
        expected = {"label": label, "position": place, "radius": radius, "velocity": place, "angular_velocity": 2 * place,
                    "mass": 2500 * 4 / 3 * np.pi * radius**3, "colour": label % 256, "group": np.ones(n), "material": np.zeros(n),
                    "owner": np.zeros(n), "displacement": np.zeros((n, 3))}
        for field, value in expected.items():
            np.testing.assert_allclose(engine.copy(field), value[order], rtol=1e-14, err_msg=field)
            np.testing.assert_array_equal(engine.copy(field), engine.gather(field))
        for field in talus.Field:
            array = engine.copy(field)
            dtype, components = talus.FIELDS[field]
            assert array.dtype == dtype and array.flags.owndata and array.flags.c_contiguous
            assert array.shape == ((n,) if components == 1 else (n, 3))
            assert array.dtype == engine.gather(int(field)).dtype


def test_an_empty_engine_has_empty_arrays():
    with prepared() as engine:
        assert engine.copy("position").shape == (0, 3) and engine.gather("label").shape == (0,)
        assert engine.view("position").array.shape == (0, 3)
        engine.insert([], np.zeros((0, 3)), RADIUS)
        engine.insert([], [], [])


def test_any_layout_and_width_may_be_inserted():
    place = np.array([[2e-3, 2e-3, 2e-3], [6e-3, 2e-3, 2e-3], [2e-3, 6e-3, 2e-3]])
    wide = np.zeros((6, 6))
    wide[::2, ::2] = place
    forms = {
        "lists": ([3, 1, 2], place.tolist(), [RADIUS] * 3),
        "strided": (np.array([3, 0, 1, 0, 2])[::2], wide[::2, ::2], np.full(6, RADIUS)[::2]),
        "fortran": (np.array([3, 1, 2], "u2"), np.asfortranarray(place), RADIUS),
        "big-endian": (np.array([3, 1, 2], ">i4"), place.astype(">f8"), np.float64(RADIUS)),
        "read-only": (np.array([3, 1, 2]), place.copy(), np.full(3, RADIUS)),
    }
    forms["read-only"][1].setflags(write=False)
    for name, (label, position, radius) in forms.items():
        with prepared() as engine:
            engine.insert(label, position, radius, velocity=(1, 2, 3), material=0)
            np.testing.assert_array_equal(engine.copy("position"), place[[1, 2, 0]], err_msg=name)
            np.testing.assert_array_equal(engine.copy("velocity"), [(1, 2, 3)] * 3, err_msg=name)


WRONG = {
    "too few positions": (dict(position=[(0.01, 0.01, 0.01)]), ValueError, r"position: takes shape \(2, 3\)"),
    "flat positions": (dict(position=np.zeros(6)), ValueError, r"position: takes shape \(2, 3\)"),
    "transposed": (dict(position=np.zeros((3, 2))), ValueError, "position"),
    "ragged": (dict(position=[(1, 2, 3), (1, 2)]), (ValueError, TypeError), "position"),
    "radius of another length": (dict(radius=[1e-3] * 3), ValueError, r"radius: takes shape \(2,\)"),
    "velocity of another shape": (dict(velocity=[(0, 0), (0, 0)]), ValueError, "velocity"),
    "matrix of labels": (dict(label=[[1, 2]]), ValueError, "label"),
    "labels with fractions": (dict(label=[1.5, 2.5]), TypeError, "label: takes whole numbers"),
    "labels too large": (dict(label=np.array([1, 2**63], "u8")), ValueError, "does not fit in int64"),
    "complex positions": (dict(position=np.ones((2, 3), complex)), TypeError, "position: takes real numbers"),
    "text": (dict(radius="large"), TypeError, "radius"),
    "objects": (dict(position=[[None] * 3] * 2), TypeError, "position"),
    "no radius": (dict(radius=None), TypeError, "radius"),
    "material with a fraction": (dict(material=[0.0, 0.5]), TypeError, "material"),
    "colour out of int32": (dict(colour=[0, 2**40]), ValueError, "does not fit in int32"),
    "overlap that is no number": (dict(max_overlap="some"), TypeError, "max_overlap"),
    "label given twice": (dict(label=[4, 4]), talus.ArgumentError, "label 4 is given twice"),
    "outside of the domain": (dict(position=[(1, 1, 1), (0.01, 0.01, 0.01)]), talus.ArgumentError, "domain"),
    "not finite": (dict(position=[(np.nan, 0, 0), (0.01, 0.01, 0.01)]), talus.ArgumentError, "not finite"),
    "negative label": (dict(label=[-1, 2]), talus.ArgumentError, "label -1"),
    "no such material": (dict(material=5), talus.ArgumentError, "material"),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_arguments_of_insert_are_told_and_change_nothing(name):
    given, error, text = WRONG[name]
    right = dict(label=[1, 2], position=[(0.01, 0.01, 0.01), (0.02, 0.01, 0.01)], radius=RADIUS)
    with prepared() as engine:
        with pytest.raises(error, match=text):
            engine.insert(**(right | given))
        assert engine.state().particles == 0
        engine.insert(**right)
        engine.step(2)


def test_a_box_is_filled_and_the_keywords_of_fill_are_those_of_the_struct():
    with prepared() as engine:
        n = engine.fill(talus.Fill(material=0, lo=(0, 0, 0), hi=(0.02, 0.02, 0.02), radius_min=8e-4, radius_max=1e-3, count=100))
        assert n == 100 == engine.state().particles
        assert engine.fill(lo=(0.02, 0, 0), hi=(0.04, 0.02, 0.02), radius_min=8e-4, radius_max=1e-3, first_label=10**6) > 100
        with pytest.raises(TypeError, match="not both"):
            engine.fill(talus.Fill(), material=0)
        with pytest.raises(TypeError, match="talus.Fill"):
            engine.fill(talus.Wall())
        with pytest.raises(TypeError, match="radius_min"):
            engine.fill(radius_mim=1e-3)


def test_fields_are_named_by_text_number_or_member():
    with bed(10) as engine:
        assert (engine.copy("RADIUS") == engine.copy(talus.Field.RADIUS)).all() and (engine.copy(2) == RADIUS).all()
        for bad in ("speed", 99, -1):
            with pytest.raises(ValueError, match="takes one of label, position"):
                engine.copy(bad)
        with pytest.raises(talus.ArgumentError, match="has no view"):
            engine.view("force")
