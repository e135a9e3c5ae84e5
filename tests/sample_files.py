"""Sample files in foreign formats: made for the tests, and real ones if there are any."""

from pathlib import Path

SAMPLES = Path(__file__).resolve().parent / "samples"
REAL = Path(__file__).resolve().parents[2] / "shared" / "data"


def files(*samples, real):
    """Return these samples, and the real files that match the pattern `real`, in order."""
    return [*(SAMPLES / name for name in samples), *sorted(REAL.glob(real))]
