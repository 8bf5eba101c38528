"""An operation at one moment as the live view shows it. Degrees and mm."""

from robotcell.operate.drive import Snapshot
from robotcell.operate.nodes import Job
from specs.json import Json


def live_data(shown: Snapshot, job: Job) -> dict[str, Json]:
    """Give state, node, joints, conditions, quantities, valves and tool, and how old they are, ms."""
    return {
        "state": shown.state,
        "reason": shown.reason,
        "node": shown.node.number if shown.node is not None else 0,
        "nodes": len(job.nodes),
        "joints": {name: round(value, 3) for name, value in zip(job.joints, shown.joints, strict=False)},
        "conditions": dict(shown.conditions),
        "quantities": {key: round(value, 4) for key, value in shown.quantities.items()},
        "jets": list(shown.jets),
        "tool": job.tool_at(shown.node.number if shown.node is not None else 0),
        "seconds": round(shown.seconds, 3),
        "age_ms": round(min(1e3 * shown.age_s, 1e9), 1),
    }
