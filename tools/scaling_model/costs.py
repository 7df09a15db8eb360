"""What one core takes for a piece of work: from a file of `talus-sandbox plan --calibrate`, from runs, or built in.

All in seconds. What no file tells stays at its built-in value; each source says so of itself.
"""
import dataclasses
import json


class CostError(Exception):
    """A file of costs that cannot be used; the text says why."""


@dataclasses.dataclass
class Costs:
    source: str = "built in: one core of a Zen 3 EPYC at 3.1 GHz, settled sand, default laws"
    force: float = 93e-9          # a grain and step, on one rank
    integrate: float = 23e-9      # a grain and step
    # A ghost and step: a round number. Traces of two ranks on a quiet machine show 10 to 13 ns for unpacking 770 ghosts and 14 to 30
    # for packing them with the MPI call; copies of 20,000 that no cache holds take 13 and 42.
    pack: float = 15e-9
    unpack: float = 15e-9
    binning: float = 114e-9       # a grain and rebuild
    pair_build: float = 457e-9    # a grain and rebuild
    steps_per_rebuild: float = 100.0
    idle_share: float = 0.0       # of a worker's time in no phase: graph, decisions; with several threads also waiting
    # Parts of a rebuild that run on one thread whatever T is. Not measured: estimates from what the loops read.
    migrate_scan: float = 1e-9    # a grain: who leaves (parallel) and the parcels around it
    halo_scan: float = 3e-9       # a grain: whether it lies near a cut (Halo::build)
    halo_ghost: float = 100e-9    # a ghost: 152 bytes packed, sent, unpacked, binned


def read_costs(path, threads):
    """From a file of --calibrate: the run whose threads come nearest."""
    try:
        with open(path, encoding="utf-8") as file:
            data = json.load(file)
        if data["format"] != 1:
            raise CostError(f"{path}: format {data['format']}, this tool reads format 1")
        run = min(data["runs"], key=lambda r: abs(r["threads"] - threads))
        busy = run["busy"]
        costs = Costs(source=f"{path}: {data['machine']['processor']}, measured with {run['threads']} threads")
        for name in ("force", "integrate", "binning", "pair_build"):
            setattr(costs, name, float(busy[name]))
        # On several ranks the phase holds the halo's part in rebuilds too, and waiting there: an upper bound of the copies.
        if busy.get("halo_exchange") is not None:
            costs.pack = costs.unpack = 0.5 * float(busy["halo_exchange"])
        costs.steps_per_rebuild = float(run["shorten"]["steps_per_rebuild"])
        # On several ranks they wait for each other: the replay finds that itself.
        costs.idle_share = float(run["idle_share"]) if data["machine"]["ranks"] == 1 else 0.0
        if not 0.0 <= costs.idle_share < 1.0 or min(costs.force, costs.integrate, costs.steps_per_rebuild) <= 0.0:
            raise CostError(f"{path}: holds a cost that cannot be")
        return costs
    except (OSError, ValueError, KeyError, TypeError) as fault:
        raise CostError(f"{path}: not a file of costs of talus-sandbox plan --calibrate ({fault!r})") from fault


def costs_of_run(run):
    """From the phases of a run on one rank and one thread, long enough for its start not to matter."""
    grains, steps, rebuilds = run.summary["particles"], run.summary["steps"], run.summary["rebuilds"]
    seconds = {name: phase["mean"] for name, phase in run.summary["phases"].items()}
    busy = sum(seconds[name] for name in ("force", "integrate", "binning", "pair_build"))
    return Costs(source=f"phases of {run.folder}",
                 force=seconds["force"] / (grains * steps), integrate=seconds["integrate"] / (grains * steps),
                 binning=seconds["binning"] / (grains * rebuilds), pair_build=seconds["pair_build"] / (grains * rebuilds),
                 steps_per_rebuild=steps / rebuilds,
                 idle_share=max(0.0, 1.0 - busy / run.summary["stepping_seconds"]))
