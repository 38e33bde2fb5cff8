"""Peak memory of a process, which several benchmarks print."""

import resource
from pathlib import Path


def peak_megabytes() -> float:
    """Largest resident memory of this program so far, in MB of 2**20 bytes.

    Linux says it in ``VmHWM``. ``ru_maxrss`` begins, in a process that another one starts, with the memory of that one.
    """
    status = Path("/proc/self/status")
    if status.is_file():
        line = next(one for one in status.read_text().splitlines() if one.startswith("VmHWM:"))
        return int(line.split()[1]) / 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
