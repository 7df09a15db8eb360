"""Contacts, removal by place and name, states kept in memory, stepping to a time, and memory by category."""

import gc

import numpy as np
import pytest
import talus
from conftest import RADIUS, bed, prepared


def test_a_grain_pressed_into_the_floor_and_its_neighbour_are_seen_as_contacts():
    with prepared(gravity=(0, 0, 0)) as engine:
        overlap = 0.02 * RADIUS
        engine.insert([4, 9], [(0.02, RADIUS - overlap, 0.02), (0.02, 3 * RADIUS - 2 * overlap, 0.02)], RADIUS, max_overlap=0.1)
        assert engine.contacts("labels").tolist() == [[4, 9], [4, talus.WALL_LABEL]]
        np.testing.assert_allclose(engine.contacts("normal"), [(0, -1, 0), (0, 1, 0)], atol=1e-15)
        np.testing.assert_allclose(engine.contacts("overlap"), [overlap, overlap], rtol=1e-9)
        np.testing.assert_allclose(engine.contacts("point")[0], (0.02, 2 * RADIUS - 1.5 * overlap, 0.02), rtol=1e-12)
        force = engine.contacts("force")
        assert force[0, 1] < 0 < force[1, 1], "the upper grain presses grain 4 down, the floor holds it up"
        np.testing.assert_allclose(engine.copy("force")[0], force.sum(axis=0), atol=1e-12 * abs(force[0, 1]))
        assert engine.contacts("sliding").tolist() == [0, 0]


def test_contacts_are_as_many_as_the_state_counts_and_none_is_none(world):
    world.step(20000)
    state = world.state()
    assert len(world.contacts("force")) == state.contacts + state.wall_contacts > 100
    with prepared() as engine:
        engine.insert(1, (0.02, 0.02, 0.02), RADIUS)
        assert engine.contacts("labels").shape == (0, 2) and engine.contacts("overlap").shape == (0,)
    with pytest.raises(ValueError, match="labels"):
        world.contacts("torque")


def test_grains_are_removed_by_label_and_by_box_or_not_at_all(world):
    label = world.copy("label")
    assert world.remove(label[:3]) == 3
    assert world.copy("label").tolist() == label[3:].tolist()
    with pytest.raises(talus.ArgumentError, match=f"label {label[0]}"):
        world.remove([label[5], label[0]])
    assert len(world.copy("label")) == 197
    inside = (world.copy("position") < 0.01).all(axis=1).sum()
    assert world.remove_box((0, 0, 0), (0.01, 0.01, 0.01)) == inside > 0
    with pytest.raises(talus.ArgumentError, match="empty"):
        world.remove_box((0, 0, 0), (0, 1, 1))


def test_a_kept_state_is_come_back_to_and_outlives_nothing_it_should_not():
    engine = bed()
    engine.step(500)
    kept, at = engine.keep(), engine.state()
    engine.step(300)
    end = engine.state()
    for _ in range(2):
        engine.restore(kept)
        assert (engine.state().digest_lo, engine.state().step) == (at.digest_lo, 500)
        engine.step(300)
        assert (engine.state().digest_lo, engine.state().digest_hi) == (end.digest_lo, end.digest_hi)
    with bed() as other, pytest.raises(talus.ArgumentError, match="not one of this engine"):
        other.restore(kept)
    engine.close()
    del engine
    gc.collect()
    del kept  # after its engine


def test_stepping_to_a_time_takes_as_many_steps_as_it_needs(world):
    assert world.advance_to(10.5 * 2e-6) == 11
    assert world.advance_to(20 * 2e-6) == 9
    assert world.advance_to(0.0) == 0
    with pytest.raises(talus.ArgumentError):
        world.advance_to(float("nan"))


def test_memory_adds_up_to_what_the_state_says_a_grain_takes(world):
    world.step(10)
    assert sum(world.memory().as_dict().values()) == pytest.approx(world.state().bytes_per_particle * 200)
