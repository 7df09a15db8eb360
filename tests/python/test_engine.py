# processors: 2
"""Engines: physics against closed forms, life and death, stops, threads, files."""

import gc
import signal
import subprocess
import sys
import threading
import weakref

import numpy as np
import pytest
import talus
from conftest import RADIUS, bed, prepared, settings


@pytest.mark.parametrize("restitution", [1.0, 0.8, 0.3])
def test_a_grain_that_falls_on_the_floor_bounces_with_the_speed_of_the_closed_form(restitution):
    g, fall, young, poisson, density, step = 9.81, 0.02, 5e8, 0.2, 2500, 5e-7
    impact = np.sqrt(2 * g * fall)
    # Hertz: duration of a collision of a sphere with a wall of its own kind (E* = E / (2 (1 - nu^2)), mass and radius its own).
    mass = density * 4 / 3 * np.pi * RADIUS**3
    duration = 2.868 * (mass**2 / (RADIUS * (young / 2 / (1 - poisson**2)) ** 2 * impact)) ** 0.2
    with prepared(restitution=restitution, gravity=(0, -g, 0), time_step=step, young=young) as engine:
        engine.insert(label=7, position=(0.02, RADIUS + fall, 0.02), radius=RADIUS)
        engine.step(int(0.98 * impact / g / step))
        assert engine.state().wall_contacts == 0
        np.testing.assert_allclose(engine.copy("velocity")[0], (0, -0.98 * impact, 0), atol=1e-4 * impact)
        while True:
            engine.step(20)
            height, speed = engine.view("position")[0, 1] - RADIUS, engine.view("velocity")[0, 1]
            if speed > 0 and height > 0:
                break
            assert engine.state().time < 0.1, "never left the floor"
        # Back at the height of first touch, from the energy. Gravity acts during the contact too, which damping makes longer.
        assert np.hypot(speed, np.sqrt(2 * g * height)) == pytest.approx(restitution * impact, rel=1e-4, abs=2 * g * duration)
        assert g * duration < 1e-3 * impact


def test_a_head_on_collision_keeps_momentum_and_restitution():
    with prepared(restitution=0.6, friction=0.0, wall=False) as engine:
        engine.insert([1, 2], [(0.018, 0.02, 0.02), (0.022, 0.02, 0.02)], RADIUS, velocity=[(0.5, 0, 0), (-0.3, 0, 0)])
        engine.step(3000)
        v = engine.copy("velocity")
        assert v[1, 0] - v[0, 0] == pytest.approx(0.6 * 0.8, rel=1e-3)
        assert v[:, 0].sum() == pytest.approx(0.2, rel=1e-12)
        assert engine.internal_force_sum().sum.tolist() == [0, 0, 0]


def test_two_engines_at_once_do_not_disturb_each_other():
    with bed() as alone:
        alone.step(400)
        expected = alone.state().digest
    with bed() as first, bed(threads=2) as second:
        threads = [threading.Thread(target=lambda e=e: [e.step(100) for _ in range(4)]) for e in (first, second)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert first.state().digest == second.state().digest == expected


def test_with_destroys_and_a_closed_engine_says_so(world):
    with bed(20) as engine:
        view = engine.view("position")
        assert not engine.closed
    assert engine.closed and view.stale
    engine.close()
    for call in (lambda: engine.step(1), engine.state, lambda: engine.message, lambda: engine.copy("label"), engine.request_stop):
        with pytest.raises(talus.ClosedError):
            call()
    with pytest.raises(talus.StaleView):
        view.array
    assert "closed" in repr(engine) and "stale" in repr(view)
    world.step(1)


def test_a_with_block_that_fails_destroys_too():
    with pytest.raises(KeyError), bed(20) as engine:
        raise KeyError
    assert engine.closed


def test_an_engine_survives_its_parts_being_deleted_in_any_order():
    import itertools

    for order in itertools.permutations(("engine", "view", "array", "state")):
        names = {"engine": bed(20)}
        names["engine"].step(1)
        gone = weakref.ref(names["engine"])
        names["view"] = names["engine"].view("position")
        names["array"] = names["view"].array
        names["state"] = names["engine"].state()
        expected = names["array"].copy()
        for name in order:
            del names[name]
            gc.collect()
            if "array" in names:
                assert (names["array"] == expected).all(), "the array keeps the engine's memory"
            if "view" in names:
                assert (names["view"].array == expected).all()
            if "state" in names:
                assert names["state"].particles == 20
        assert gone() is None


def test_an_engine_after_an_error_can_be_closed():
    with prepared() as engine:
        engine.insert(0, (0.039, 0.02, 0.02), RADIUS, velocity=(100, 0, 0))
        with pytest.raises(talus.LostError) as error:
            engine.step(1000)
        assert 0 <= error.value.done < 1000
        assert "grain 0 left the domain" in str(error.value)
        with pytest.raises(talus.StateError):
            engine.step(1)
        assert engine.state().particles == 1


def test_a_stop_asked_for_by_another_thread_ends_the_step(world):
    world.step(1)
    threading.Timer(0.05, world.request_stop).start()
    done = world.step(10**9)
    assert world.stopped and 0 < done < 10**9
    assert world.step(3) == 3 and not world.stopped
    assert world.state().step == done + 4


def test_a_second_caller_is_refused_while_an_engine_steps(world):
    world.step(1)
    seen, started, view = [], threading.Event(), world.view("radius")

    def look():
        started.wait()
        while not seen:
            try:
                world.state(), view.stale
            except talus.BusyError as error:
                seen.append(error)
            except talus.ClosedError:
                return
        world.request_stop()

    thread = threading.Thread(target=look)
    thread.start()
    started.set()
    while not seen:
        try:
            world.step(10**5)
        except talus.BusyError:
            pass  # the other thread was looking just then
    thread.join()
    assert "one caller at a time" in str(seen[0])


def test_ctrl_c_ends_a_loop_of_steps():
    program = """if True:
        from conftest import bed
        with bed() as engine:
            print("ready", flush=True)
            while True:
                engine.step(100)
    """
    child = subprocess.Popen([sys.executable, "-c", program], cwd=__file__.rpartition("/")[0], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "ready\n"
    child.send_signal(signal.SIGINT)
    _, error = child.communicate(timeout=60)
    assert "KeyboardInterrupt" in error


@pytest.mark.parametrize("threads", [1, 2])
def test_a_checkpoint_goes_on_with_the_same_bits(tmp_path, world, threads):
    world.step(300)
    world.save(tmp_path / "bed.ckpt")
    with talus.Engine.load(tmp_path / "bed.ckpt", threads=threads) as again:
        assert again.state().digest == world.state().digest
        assert len(world.state().digest) == 32
        for engine in (world, again):
            engine.step(200)
        assert again.state().digest == world.state().digest
        assert again.state().threads == threads
        assert (again.copy("position") == world.copy("position")).all()


def test_snapshots_and_traces_are_files(tmp_path, world):
    import json

    import h5py

    world.trace(tmp_path / "trace.json", 3)
    world.step(5)
    assert json.loads((tmp_path / "trace.json").read_text())
    world.snapshot(tmp_path / "bed.hdf")
    with h5py.File(tmp_path / "bed.hdf") as file:
        assert file["VTKHDF/Points"].shape == (200, 3)


def test_observations_have_their_types_and_agree(world):
    world.step(500)
    state, energy = world.state(), world.energy()
    assert state.particles == state.local_particles == 200 and state.time == pytest.approx(1e-3)
    assert energy.kinetic + energy.rotational == pytest.approx(state.kinetic_energy)
    assert sum(r.particles for r in world.ranks()) == 200
    assert (world.rank, world.size) == (0, 1)
    assert [p.name for p in world.phases()][:4] == ["binning", "pair_build", "force", "integrate"]
    stress = world.stress((0, 0, 0), (0.04, 0.04, 0.04))
    assert stress.tensor.shape == (3, 3) and 0 < stress.solid_fraction < 1 and stress.coordination >= 0
    assert world.wall(0).force.shape == (3,) and world.wall(0).contacts == state.wall_contacts
    assert isinstance(state.as_dict()["time"], float) and "particles=200" in repr(state)


def test_setup_may_change_between_steps(world):
    world.step(1)
    world.set_wall_velocity(0, (0.01, 0, 0))
    world.set_gravity([0, 0, -9.81])
    world.set_time_step(1e-6)
    world.set_laws(rolling="spring", rolling_damping=0.2)
    world.set_contact(0, 0, talus.Contact(restitution=0.4, friction=0.1))
    world.set_group(1, "driven", velocity=(0, 0.1, 0))
    world.colour_layers("y", 0.0, 2.5e-3)
    world.add_velocity((0.1, 0, 0))
    world.step(10)
    assert world.copy("velocity")[:, 0].min() > 0.05
    assert sorted(set(world.copy("colour"))) == [0, 1]
    world.stop_grains()
    assert not world.copy("velocity").any()
    world.mark_reference()
    assert not world.copy("displacement").any()
    assert world.remove_above("y", 3.5e-3) == 100
    assert world.state().particles == 100
    assert world.wall(0).velocity.tolist() == [0.01, 0, 0]
    assert 0 < world.critical_step() < 1


def test_rank_grids_are_planned_without_an_engine():
    assert talus.rank_grid((4, 1, 1), 4) == (4, 1, 1)
    assert talus.rank_grid((1, 1, 1), 8, given=(0, 1, 0))[1] == 1
    with pytest.raises(talus.ArgumentError):
        talus.rank_grid((1, 1, 1), 4, given=(3, 0, 0))


def test_settings_reach_the_engine():
    with talus.Engine(settings(threads=2, laws=talus.Laws(normal="linear", stiffness_n=1000.0))) as engine:
        assert engine.state().threads == 2
    assert talus.version() == (0, 1, 0) and "Talus 0.1.0" in talus.build_info()
    assert talus.status_string(-5) == "TALUS_ERR_IO"
